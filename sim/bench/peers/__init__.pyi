from .difficulty_sweep import sweep as sweep
from .room_methods import compare_methods as compare_methods
from .trajectories import compare_trajectories as compare_trajectories
