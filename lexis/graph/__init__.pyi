from .graph_optimisation import GraphOptimiser as GraphOptimiser
from .pose_graph import PoseGraph as PoseGraph
