from .geometric_rooms import GeometricRooms as GeometricRooms
from .lexis import Lexis as Lexis
from .odometry_only import OdometryOnly as OdometryOnly
