from .openness_sweep import sweep as sweep
from .place_methods import compare_place_methods as compare_place_methods
from .room_methods import compare_methods as compare_methods
from .trajectories import compare_trajectories as compare_trajectories
