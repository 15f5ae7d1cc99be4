"""Training frames: what a camera sees on tours through training houses, and what is in view."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float32, Int, UInt8

from sim.camera import CameraRenderer, fovy_deg, wide_camera
from sim.scene import build_scene
from sim.tour import TourConfig, plan_tour
from worlds.furniture.catalogue import CATALOGUE
from worlds.house import build_house
from worlds.labels import ROOM_LABELS
from worlds.presets import sample_house
from worlds.truth import room_at
from worlds.walkable import Walkable

TRAINING_SEEDS = range(100_000, 900_000)
"""House seeds that the encoder may see; demos, tests and acceptance use others."""
IMAGE_SIZE = (128, 96)
"""Width and height that the encoder sees [px]."""
PRESET_SHARE = {"home": 0.5, "random": 0.3, "ori": 0.08, "uh2-apt": 0.06, "uh2-office": 0.06}
OBJECT_KINDS = tuple(sorted(CATALOGUE))
_SUPERSAMPLING = 2
_SPACING_M = 1.2


@dataclass(frozen=True, eq=False)
class Frames:
    """Images with the room that holds the camera and the share of the image that each kind of object fills."""

    images: UInt8[np.ndarray, "n h w 3"]
    rooms: Int[np.ndarray, "n"]
    """Index into `ROOM_LABELS`."""
    shares: Float32[np.ndarray, "n kinds"]
    """Indexed as `OBJECT_KINDS`, in [0, 1]."""

    @staticmethod
    def joined(parts: "Sequence[Frames]") -> "Frames":
        """All frames of several sets, in order."""
        return Frames(*(np.concatenate([getattr(p, name) for p in parts]) for name in ("images", "rooms", "shares")))


def render_frames(houses: int, seed: int, workers: int = 2) -> Iterator[Frames]:
    """Frames of `houses` houses drawn by `seed`, one set per house, in an order that does not depend on `workers`."""
    with ProcessPoolExecutor(workers) as pool:
        yield from pool.map(frames_of_house, _draw_houses(houses, seed))


def _draw_houses(houses: int, seed: int) -> list[tuple[str, int]]:
    rng = np.random.default_rng(seed)
    presets = rng.choice(list(PRESET_SHARE), houses, p=list(PRESET_SHARE.values()))
    seeds = rng.choice(len(TRAINING_SEEDS), houses, replace=False)
    return [(str(preset), TRAINING_SEEDS[int(s)]) for preset, s in zip(presets, seeds, strict=True)]


def frames_of_house(house_of: tuple[str, int]) -> Frames:
    """Render a tour through one house, (preset, seed), every 1.2 m, looking a little to the sides at random."""
    preset, seed = house_of
    rng = np.random.default_rng([seed, 2])
    house = build_house(sample_house(preset, seed))
    tour = plan_tour(house, Walkable(house), rng, TourConfig())
    path = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(tour.T_W_B[:, :3, 3], axis=0), axis=1))])
    chosen = np.unique(np.searchsorted(path, np.arange(0.0, path[-1], _SPACING_M)))
    poses = np.array([_glance(tour.T_W_B[i], rng) for i in chosen])
    width, height = IMAGE_SIZE[0] * _SUPERSAMPLING, IMAGE_SIZE[1] * _SUPERSAMPLING
    camera = wide_camera(width, height)
    scene = build_scene(house, (width, height), fovy_deg(camera.intrinsics))
    kind_of = {piece.id: OBJECT_KINDS.index(piece.kind) for piece in house.furniture}
    kind_of_geom = np.array([kind_of.get(name, -1) for name in scene.object_of_geom] + [-1])
    images, shares = [], []
    with CameraRenderer(scene, camera) as renderer:
        for T_W_B in poses:
            images.append(cv2.resize(renderer.rgb(T_W_B), IMAGE_SIZE, interpolation=cv2.INTER_AREA))
            kinds = kind_of_geom[renderer.geom_ids(T_W_B)[::2, ::2]]
            shares.append(np.bincount(kinds[kinds >= 0], minlength=len(OBJECT_KINDS)) / kinds.size)
    labels = np.array([ROOM_LABELS.index(house.rooms[r].label) for r in room_at(house, poses[:, :3, 3])])
    return Frames(np.array(images), labels, np.array(shares, np.float32))


def _glance(T_W_B: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    yaw = rng.normal(0.0, 0.35)
    turn = np.eye(4)
    turn[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    return T_W_B @ turn
