"""Camera viewpoints for tests of rendering: inside the rooms, clear of walls and furniture, with random headings."""

import numpy as np
from shapely.geometry import Point
from shapely.ops import unary_union

EYE_M = 1.4


def turned(yaw, pitch=0.0, roll=0.0):
    (cy, cp, cr), (sy, sp, sr) = np.cos([yaw, pitch, roll]), np.sin([yaw, pitch, roll])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    return about_z @ about_y @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])


def viewpoints(house, count, seed=0, tilt=0.0):
    """Poses of the body, in each room in turn (except stairs), with pitch and roll up to `tilt` [rad]."""
    rng = np.random.default_rng(seed)
    rooms = [room for room in house.rooms if room.label != "stairs"]
    free = []
    for room in rooms:
        taken = [piece.footprint.buffer(0.1) for piece in [*house.furniture, *house.leaves] if piece.storey == room.storey]
        free.append(room.polygon.buffer(-0.3).difference(unary_union(taken)))
    poses = []
    for i in range(count):
        room, space = rooms[i % len(rooms)], free[i % len(rooms)]
        x0, y0, x1, y1 = space.bounds
        while not space.contains(place := Point(rng.uniform(x0, x1), rng.uniform(y0, y1))):
            pass
        T_W_B = np.eye(4)
        T_W_B[:3, :3] = turned(rng.uniform(-np.pi, np.pi), *rng.uniform(-tilt, tilt, 2))
        T_W_B[:3, 3] = place.x, place.y, room.floor_m + EYE_M
        poses.append(T_W_B)
    return np.array(poses)
