from .config import TOUR_KINDS as TOUR_KINDS
from .config import TourConfig as TourConfig
from .motion import Motion as Motion
from .sway import SWAYS as SWAYS
from .tour import Tour as Tour
from .tour import plan_tour as plan_tour
