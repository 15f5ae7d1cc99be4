from .dead_reckoning import DeadReckoning as DeadReckoning
from .drive import DROP as DROP
from .drive import Drive as Drive
from .drive import Robot as Robot
