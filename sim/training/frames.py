"""Training frames: images along tours through houses, with ground truth of what is visible in each image and patch."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import cached_property, partial
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float32, Float64, Int, UInt8

from sim.errors import SimError
from sim.processes import process_pool
from sim.render.camera import fovy_deg, wide_camera
from sim.render.raster import NO_GEOM, Raster
from sim.render.scene import LIGHTS, Scene, build_scene
from sim.tours.tour import TourConfig
from sim.training.array_cache import Arrays, cached_arrays, house_origin, loaded, origin
from sim.training.houses import HouseDraw
from sim.training.variants import HELD_OUT_COLOURS, repainted
from sim.training.viewpoints import TRAINING_VIEWS, ViewpointConfig, poses_along_tour
from worlds.furniture.catalogue import CATALOGUE
from worlds.house import House, build_house
from worlds.labels import ROOM_LABELS, STAIRS
from worlds.truth import objects, room_at
from worlds.visuals.house_visuals import STAIRS_OBJECT

THINGS = tuple(sorted({*CATALOGUE, "door", "window", STAIRS}))
"""Kinds of things that are distinguished in a frame: kinds of furniture, doors, windows and stairs, sorted by name."""
PATCHES = (4, 5)
"""Numbers of rows and columns of patches in a frame, as in the last feature map of the image tower."""
BARE = 0.03
"""A frame counts as showing more than bare walls if its `Frames.content` (a share of the image) is at least this."""

_FORMAT = 1
"""Version of cached frames. Increase it after changes of textures, tours or renderers. Other changes are noticed, because
they change the origins that are stored with the frames."""
_IDS_SIZE = (80, 60)
_NONE = -1


@dataclass(frozen=True, eq=False)
class Frames:
    """Training images with their poses and the ground truth of what is visible."""

    images: UInt8[np.ndarray, "n h w 3"]
    rooms: Int[np.ndarray, "n"]
    """Label of the room that contains the camera in each frame, as an index into `ROOM_LABELS`."""
    things: UInt8[np.ndarray, "n rows columns things"]
    """Share of each patch of each image that shows each of `THINGS`, in units of 1/255."""
    views: Float32[np.ndarray, "n labels"]
    """Share of each image that shows rooms of each label, including the objects in these rooms."""
    content: Float32[np.ndarray, "n"]
    """Share of each image that shows neither the sky nor bare surfaces of the room that holds the camera."""
    houses: Int[np.ndarray, "n"]
    """Seed of the house in which each image was rendered."""
    T_W_B: Float64[np.ndarray, "n 4 4"]
    """Poses of the body in the world frame of each house."""

    @staticmethod
    def joined(parts: "Sequence[Frames]") -> "Frames":
        """Concatenate several sets of frames."""
        return Frames(*(np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Frames)))

    @property
    def arrays(self) -> Arrays:
        """All fields as a dict from field name to array."""
        return {f.name: getattr(self, f.name) for f in fields(Frames)}

    @cached_property
    def shares(self) -> Float32[np.ndarray, "n things"]:
        """Share of each image that shows each of `THINGS`."""
        return np.asarray(self.things.mean(axis=(1, 2), dtype=np.float32) / np.float32(255.0))

    def __getitem__(self, chosen: np.ndarray) -> "Frames":
        """Select frames by index or mask."""
        return Frames(*(getattr(self, f.name)[chosen] for f in fields(Frames)))


def rendered(houses: Sequence[HouseDraw], folder: Path, workers: int = 1) -> Iterator[Frames]:
    """Yield the frames of each house, in order. `folder` is a cache from which frames are loaded, or where they are saved.

    Raises `SimError` if a file in the folder cannot be read, or was made from other houses or with other settings.
    """
    if workers == 1:
        yield from map(partial(_kept, folder), houses)
        return
    with process_pool(workers) as pool:
        yield from pool.map(partial(_kept, folder), houses)


def frames_by_house(folder: Path) -> Iterator[Frames]:
    """Yield the frames that `rendered` saved in a folder, one house at a time, which needs less memory than all at once.

    Raises `SimError` if the folder has no frames.
    """
    paths = sorted(folder.glob("*.npz"))
    if not paths:
        raise SimError(f"{folder}: no frames in it; valid: the frames of lexis-sim train-encoder")
    taken = frames_origin(TRAINING_VIEWS)
    yield from (Frames(**loaded(path, (taken,))) for path in paths)


def frames_origin(views: ViewpointConfig) -> str:
    """Return a fingerprint of all settings of rendering and annotating frames. It does not depend on the house."""
    told = (THINGS, PATCHES, ROOM_LABELS, _IDS_SIZE, [f.name for f in fields(Frames)])
    looks = (sorted(LIGHTS.items()), sorted(HELD_OUT_COLOURS))
    return origin(_FORMAT, views, TourConfig(), wide_camera(*views.rendered), told, looks)


def frames_of_house(draw: HouseDraw, views: ViewpointConfig = TRAINING_VIEWS) -> Frames:
    """Render frames along a tour through a house, without furniture in held-out colours; no frames if no tour is found."""
    house = repainted(build_house(draw.spec()), held_out=False)
    return frames_at(house, poses_along_tour(house, views, np.random.default_rng([draw.seed, 2])), views)


def frames_at(house: House, poses: Float64[np.ndarray, "n 4 4"], views: ViewpointConfig = TRAINING_VIEWS) -> Frames:
    """Render frames from poses `T_W_B` of the body inside a house, in the image size `views.size`."""
    camera, plain = wide_camera(*views.rendered), wide_camera(*_IDS_SIZE)
    scene = build_scene(house, views.rendered, fovy_deg(camera.intrinsics))
    images, ids = [], []
    with Raster(scene) as raster:
        for T_W_B in poses:
            image = raster.rgb(T_W_B @ camera.T_B_C, camera.intrinsics)
            images.append(cv2.resize(image, views.size, None, 0, 0, cv2.INTER_AREA))
            ids.append(raster.geom_ids(T_W_B @ plain.T_B_C, plain.intrinsics))
    rooms = room_at(house, poses[:, :3, 3])
    labels = np.array([ROOM_LABELS.index(room.label) for room in house.rooms])
    pixels = np.array(images, np.uint8).reshape(-1, views.size[1], views.size[0], 3)
    seen = np.array(ids, np.int64).reshape(-1, _IDS_SIZE[1], _IDS_SIZE[0])
    told = _told(rooms, seen, labels, *_shown(house, scene))
    return Frames(pixels, labels[rooms], *told, np.full(len(poses), house.spec.seed), poses)


def _told(
    rooms: Int[np.ndarray, "n"],
    ids: Int[np.ndarray, "n ih iw"],
    labels: Int[np.ndarray, "rooms"],
    thing_of_geom: Int[np.ndarray, "geoms"],
    room_of_geom: Int[np.ndarray, "geoms"],
) -> tuple[UInt8[np.ndarray, "n rows columns things"], Float32[np.ndarray, "n labels"], Float32[np.ndarray, "n"]]:
    """Compute the fields `things`, `views` and `content` of frames from the id of the geom that each pixel shows."""
    things, seen = thing_of_geom[ids], room_of_geom[ids]
    (n, height, width), (rows, columns) = ids.shape, PATCHES
    patches = things.reshape(n, rows, height // rows, columns, width // columns).swapaxes(2, 3)
    shares = _histogram(patches.reshape(n, rows, columns, height * width // (rows * columns)), len(THINGS))
    views = _histogram(np.where(seen == _NONE, _NONE, labels[seen]).reshape(n, height * width), len(ROOM_LABELS))
    bare = ((things == _NONE) & ((seen == rooms[:, None, None]) | (seen == _NONE))).mean(axis=(1, 2))
    patch_shares = np.rint(shares * 255).astype(np.uint8)
    return patch_shares, views.astype(np.float32), (1.0 - bare).astype(np.float32)


def _histogram(values: Int[np.ndarray, "*n k"], bins: int) -> Float64[np.ndarray, "*n bins"]:
    """Return the share of each value in 0 ... bins - 1 along the last axis. Negative values are not counted."""
    flat = values.reshape(-1, values.shape[-1])
    index = np.arange(len(flat))[:, None] * bins + flat
    counts = np.bincount(index[flat >= 0], minlength=len(flat) * bins)
    return np.asarray(counts.reshape(*values.shape[:-1], bins) / values.shape[-1])


def _shown(house: House, scene: Scene) -> tuple[Int[np.ndarray, "geoms"], Int[np.ndarray, "geoms"]]:
    """Return the thing and the room of each geom, as indices into `THINGS` and `house.rooms`, or `_NONE`.

    The last entry is for the sky, whose geom id is -1.
    """
    kinds = {thing.id: THINGS.index(thing.kind) for thing in objects(house)} | {STAIRS_OBJECT: THINGS.index(STAIRS)}
    number = {room.id: i for i, room in enumerate(house.rooms)}
    homes = {thing.id: number[house.room_by_id[thing.room].id] for thing in objects(house)}
    names = [*scene.object_of_geom]
    things = [kinds.get(name, _NONE) for name in names]
    rooms = [homes.get(name, number.get(name.rsplit("/", 1)[0], _NONE)) for name in names]
    if NO_GEOM != _NONE:
        raise SimError(f"id of the sky: is {NO_GEOM}; valid: {_NONE}, which indexes the last entry")
    return np.array([*things, _NONE]), np.array([*rooms, _NONE])


def _kept(folder: Path, draw: HouseDraw) -> Frames:
    path, origins = folder / f"{draw.preset}-{draw.seed}.npz", (frames_origin(TRAINING_VIEWS), house_origin(draw))
    return Frames(**cached_arrays(path, origins, lambda: frames_of_house(draw).arrays))
