from .labels import compare_labels as compare_labels
from .openness_sweep import sweep as sweep
from .room_methods import compare_methods as compare_methods
from .trajectories import compare_trajectories as compare_trajectories
