from .connections import adjacency as adjacency
from .path_ends import path_end as path_end
from .planner import Plan as Plan
from .planner import Planner as Planner
from .planner import plan as plan
