from .components import component_of as component_of
from .graph_optimisation import GraphOptimiser as GraphOptimiser
from .pose_graph import PoseGraph as PoseGraph
