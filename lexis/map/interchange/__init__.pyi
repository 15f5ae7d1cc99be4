from .hydra_rooms import write_hydra_rooms as write_hydra_rooms
from .ros_map import write_ros_maps as write_ros_maps
from .spark_dsg import write_spark_dsg as write_spark_dsg
from .spark_dsg_reader import read_spark_dsg as read_spark_dsg
