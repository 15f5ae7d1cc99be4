from .barriers import reachability_problems as reachability_problems
from .essentials import missing_essentials as missing_essentials
from .furniture_checks import furniture_problems as furniture_problems
from .opening_checks import opening_problems as opening_problems
from .plan_checks import plan_problems as plan_problems
from .plan_grid import PlanGrid as PlanGrid
from .reachability import unreachable_rooms as unreachable_rooms
