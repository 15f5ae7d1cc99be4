from .pooled_labels import pool_labels as pool_labels
from .room_clusters import cluster_by_sight as cluster_by_sight
from .visible_space import VisibleSpace as VisibleSpace
from .visible_space import sight as sight
from .visible_space import space_in_view as space_in_view
