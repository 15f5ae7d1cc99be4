from .path_ends import path_end as path_end
from .planner import PathPlanner as PathPlanner
from .planner import Plan as Plan
from .planner import plan as plan
