from .grading import Grade as Grade
from .grading import grade as grade
from .mutants import MUTANTS as MUTANTS
from .planting import Mutant as Mutant
