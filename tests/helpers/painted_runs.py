"""Runs with a real trajectory and artificial images: the value of every pixel is the index of the room's label."""

from functools import cache

import numpy as np

from sim.bench.encoders.runs import EncoderRun, keyframes_along
from sim.harness.scenario import Scenario
from sim.harness.walk import walk
from sim.training.frames import PATCHES, THINGS, Frames
from sim.training.houses import HouseDraw
from worlds.labels import ROOM_LABELS
from worlds.truth import room_at


def painted(rooms, rng, T_W_B=None):
    """Frames whose pixels are the indices `rooms`; the frames of each room show a kind of object of their own."""
    n = len(rooms)
    T_W_B = np.tile(np.eye(4), (n, 1, 1)) if T_W_B is None else T_W_B
    things = rng.integers(0, 3, (n, *PATCHES, len(THINGS))).astype(np.uint8)
    things[np.arange(n), ..., rooms] = 60
    views, content = np.zeros((n, len(ROOM_LABELS)), np.float32), np.ones(n, np.float32)
    return Frames(_images(rooms), rooms, things, views, content, np.zeros(n, int), T_W_B)


@cache
def painted_run(seed):
    """A run through a small flat with painted frames."""
    walked = walk(Scenario(preset="uh2-apt", seed=seed))
    kept = keyframes_along(walked.tour.T_W_B[:, :3, 3])
    T_W_B = walked.tour.T_W_B[kept]
    room = room_at(walked.house, T_W_B[:, :3, 3])
    labels = np.array([ROOM_LABELS.index(walked.house.rooms[i].label) for i in room])
    looks = np.stack([_images(labels[:9])] * 2)
    frames = painted(labels, np.random.default_rng(seed), T_W_B)
    return EncoderRun(
        HouseDraw("uh2-apt", seed), walked.tour.stamps[kept], room, frames, np.arange(9), looks, looks, looks[:1], looks[:1]
    )


def _images(rooms):
    return np.tile(rooms.astype(np.uint8)[:, None, None, None], (1, 6, 8, 3))
