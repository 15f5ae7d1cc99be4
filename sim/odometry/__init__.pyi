from .config import ODOMETRY_PRESETS as ODOMETRY_PRESETS
from .config import OdometryConfig as OdometryConfig
from .imu import Imu as Imu
from .imu import ImuConfig as ImuConfig
from .imu import ideal_imu as ideal_imu
from .simulation import Odometry as Odometry
from .simulation import simulate_odometry as simulate_odometry
from .simulation import tour_odometry as tour_odometry
