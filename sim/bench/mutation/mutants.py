"""The mutants: mistakes that a programmer of a SLAM makes easily. With most mutants, each run by itself looks plausible.

The list follows the stages of `lexis/slam.py`. It has hardly any bugs that crash, because these are found easily.
"""

from sim.bench.mutation.graph_mutants import GRAPH_MUTANTS
from sim.bench.mutation.image_mutants import IMAGE_MUTANTS
from sim.bench.mutation.keyframe_mutants import KEYFRAME_MUTANTS
from sim.bench.mutation.label_mutants import LABEL_MUTANTS
from sim.bench.mutation.place_mutants import PLACE_MUTANTS
from sim.bench.mutation.planting import Mutant
from sim.bench.mutation.room_mutants import ROOM_MUTANTS

MUTANTS: tuple[Mutant, ...] = (
    *KEYFRAME_MUTANTS,
    *GRAPH_MUTANTS,
    *PLACE_MUTANTS,
    *IMAGE_MUTANTS,
    *LABEL_MUTANTS,
    *ROOM_MUTANTS,
)
"""All mutants, in the order of the stages."""
