"""Overview pages of many houses: a page of floor plans, and a page that shows one room of each label."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float64, UInt8

from sim.errors import SimError
from sim.render.camera import CameraRenderer, fovy_deg, wide_camera
from sim.render.scene import build_scene
from sim.report.house_plan import plan_image
from worlds.furniture.catalogue import kind_of
from worlds.house import House, Room, build_house
from worlds.labels import OUTDOOR_LABELS, ROOM_LABELS, STAIRS
from worlds.presets import sample_house
from worlds.spec import HouseSpec, OpeningSpec, RoomSpec, StoreySpec
from worlds.visuals.house_visuals import STAIRS_OBJECT

Picture = UInt8[np.ndarray, "_ _ 3"]

COLUMNS = 5
"""Largest number of pictures in a row."""
_PLAN_PX = (640, 460)
_LARGER = 2.0
"""Largest factor by which plans are drawn larger if there are fewer than `COLUMNS` in a row."""
_PLAN_PX_PER_M = 36
_VIEW_PX = (400, 300)
_VIEW_HFOV_DEG = 95.0
_CAPTION_PX = 26
_EYE_M = 1.5
_FROM_CORNER_M = 0.45
_NEAR_M = 0.9
"""Surfaces that are nearer to the camera than this reduce the score of a view [m]."""
_MOST_SHARE = 0.06
"""Largest share of the image that one object adds to a view's score: several objects show more of a room than one large
object."""
_PITCH_RAD = math.radians(12.0)
_ROOMS_PER_HOUSE = 2


@dataclass(frozen=True, eq=False)
class RoomView:
    """An image of a room, with the room's label and the name of its house."""

    label: str
    house: str
    image: Picture


def plans_page(specs: Sequence[HouseSpec]) -> Picture:
    """Draw the floor plans of houses, each with the house's name. Fewer than 17 plans are drawn larger, in shorter rows."""
    columns = min(COLUMNS, math.isqrt(len(specs) - 1) + 1)
    larger = min(_LARGER, COLUMNS / columns)
    size_px = int(larger * _PLAN_PX[0]), int(larger * _PLAN_PX[1])
    plans = (_fitted(plan_image(build_house(spec), round(larger * _PLAN_PX_PER_M)), size_px) for spec in specs)
    return _page([_captioned(plan, spec.name) for plan, spec in zip(plans, specs, strict=True)], columns)


def rooms_page(views: Sequence[RoomView], *, labelled: bool = True) -> Picture:
    """Arrange views in rows of five. Each caption is the label of the view or, if not `labelled`, a number from 1."""
    return _page([_captioned(v.image, v.label if labelled else str(i)) for i, v in enumerate(views, 1)], COLUMNS)


def sampled_specs(presets: Sequence[str], seed: int, count: int = 25) -> list[HouseSpec]:
    """Sample `count` houses for a page: one house of each of the `presets` with `seed`, then with `seed + 1`, and so on.

    Raises `SimError` if `count` is below 1 or `presets` is empty.
    """
    if count < 1 or not presets:
        raise SimError(f"gallery: {count} houses of {len(presets)} presets; valid: at least 1 of each")
    return [sample_house(presets[i % len(presets)], seed + i // len(presets)) for i in range(count)]


def room_views(specs: Sequence[HouseSpec], labels: Sequence[str] = ROOM_LABELS) -> Iterator[RoomView]:
    """Render one room of each label, in the order of `labels`.

    The rooms are taken from the first houses of `specs` that have them, at most two rooms from each house. For a label that
    no house provides, a small house with such a room is built.
    """
    chosen: dict[str, tuple[House, Room]] = {}
    for spec in specs:
        wanted = set(labels) - set(chosen)
        if wanted & set(spec.room_labels):
            house = build_house(spec)
            rooms = {room.label: room for room in house.rooms if room.label in wanted}
            chosen |= {label: (house, rooms[label]) for label in sorted(rooms)[:_ROOMS_PER_HOUSE]}
    for label in labels:
        house, room = chosen.get(label) or _lone_room(label, specs[0].seed if specs else 0)
        yield RoomView(label, house.spec.name, best_view(house, room))


def best_view(house: House, room: Room, size_px: tuple[int, int] = _VIEW_PX) -> Picture:
    """Render `room` from a corner or the middle of a side.

    The viewpoint is the one from which the objects that are typical of the room's label can be seen best.
    """
    camera = wide_camera(*size_px, _VIEW_HFOV_DEG)
    scene = build_scene(house, size_px, fovy_deg(camera.intrinsics))
    # Furniture that occurs in few kinds of rooms is more characteristic of the label.
    telling = {piece.id: 1.0 / len(kind_of(piece.kind).rooms) for piece in house.furniture if piece.room == room.id}
    if room.label == STAIRS:
        telling[STAIRS_OBJECT] = 1.0
    weight_of = np.array([telling.get(name, 0.0) for name in scene.object_of_geom])
    with CameraRenderer(scene, camera) as renderer:

        def worth(T_W_B: Float64[np.ndarray, "4 4"]) -> float:
            seen, depth = renderer.geom_ids(T_W_B), renderer.depth(T_W_B)
            central = np.outer(*(np.sin(np.pi * (np.arange(n) + 0.5) / n) for n in seen.shape))
            shares = np.bincount(seen[seen >= 0], central[seen >= 0], len(weight_of)) / central.sum()
            return float(weight_of @ np.sqrt(np.minimum(shares, _MOST_SHARE))) * (1.0 - float((depth < _NEAR_M).mean()))

        return renderer.rgb(max(_poses(house, room), key=worth))


def _poses(house: House, room: Room) -> Iterator[Float64[np.ndarray, "4 4"]]:
    """Yield body poses in each corner and at the middle of each side, facing the centre of the room or of its furniture."""
    inner = room.polygon.buffer(-_FROM_CORNER_M, join_style="mitre")
    inner = room.polygon.buffer(-0.2, join_style="mitre") if inner.is_empty or inner.geom_type != "Polygon" else inner
    corners = np.array(inner.exterior.coords)
    aims = [np.array(room.polygon.centroid.coords[0])]
    solid = [piece.position[:2] for piece in house.furniture if piece.room == room.id and piece.solid]
    if solid:
        aims.append(np.mean(solid, axis=0))
    for eye in (*corners[:-1], *(corners[:-1] + corners[1:]) / 2):
        for aim in aims:
            yield _looking(np.array([*eye, room.floor_m + _EYE_M]), math.atan2(aim[1] - eye[1], aim[0] - eye[0]))


def _looking(eye: Float64[np.ndarray, "3"], yaw: float) -> Float64[np.ndarray, "4 4"]:
    """Return the body pose at `eye` that faces `yaw` and looks slightly down."""
    cos, sin, down, level = math.cos(yaw), math.sin(yaw), math.sin(_PITCH_RAD), math.cos(_PITCH_RAD)
    T_W_B = np.eye(4)
    T_W_B[:3, :3] = [[cos * level, -sin, cos * down], [sin * level, cos, sin * down], [-down, 0.0, level]]
    T_W_B[:3, 3] = eye
    return T_W_B


def _lone_room(label: str, seed: int) -> tuple[House, Room]:
    width, depth = (4.0, 1.8) if label in OUTDOOR_LABELS else (4.6, 4.0)
    rooms = (
        RoomSpec(id="room", label=label, polygon_m=((0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth))),
        RoomSpec(
            id="hall", label="corridor", polygon_m=((0.0, depth), (width, depth), (width, depth + 1.6), (0.0, depth + 1.6))
        ),
    )
    door = OpeningSpec(rooms=("room", "hall"), kind="door", start_m=(0.4, depth), end_m=(1.3, depth))
    house = build_house(HouseSpec(name=label, seed=seed, storeys=(StoreySpec(rooms=rooms, openings=(door,)),)))
    return house, house.room_by_id["room"]


def _fitted(image: Picture, size_px: tuple[int, int]) -> Picture:
    """Scale the whole image to fit `size_px` (width, height) and centre it on white."""
    width, height = size_px
    scale = min(width / image.shape[1], height / image.shape[0])
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)[:height, :width]
    tile = np.full((height, width, 3), 255, np.uint8)
    top, left = (height - small.shape[0]) // 2, (width - small.shape[1]) // 2
    tile[top : top + small.shape[0], left : left + small.shape[1]] = small
    return tile


def _captioned(image: Picture, text: str) -> Picture:
    strip = np.full((_CAPTION_PX, image.shape[1], 3), 255, np.uint8)
    cv2.putText(strip, text, (6, 18), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (20, 20, 20), 1, cv2.LINE_AA)
    return np.vstack([image, strip])


def _page(tiles: Sequence[Picture], columns: int) -> Picture:
    blank = np.full_like(tiles[0], 255)
    rows = [list(tiles[i : i + columns]) for i in range(0, len(tiles), columns)]
    rows[-1] += [blank] * (min(columns, len(tiles)) - len(rows[-1]))
    return np.vstack([np.hstack([np.pad(t, ((2, 2), (2, 2), (0, 0)), constant_values=255) for t in row]) for row in rows])
