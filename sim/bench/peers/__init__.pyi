from .difficulty_sweep import sweep as sweep
from .labels import compare_labels as compare_labels
from .room_methods import compare_methods as compare_methods
from .trajectories import compare_trajectories as compare_trajectories
