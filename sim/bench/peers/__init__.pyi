from .certainty import measure_certainty as measure_certainty
from .difficulty_sweep import sweep as sweep
from .labels import compare_labels as compare_labels
from .place_methods import compare_place_methods as compare_place_methods
from .room_methods import compare_methods as compare_methods
from .trajectories import compare_trajectories as compare_trajectories
