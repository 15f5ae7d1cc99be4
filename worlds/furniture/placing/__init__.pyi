from .piece import Piece as Piece
from .room_plan import RoomPlan as RoomPlan
from .room_shape import RoomShape as RoomShape
