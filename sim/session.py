"""A session: the camera walks its tour through the house and yields what a robot would see, beside what is true."""

import time
from collections import deque
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from lexis.quaternions import pose_rows, poses_of
from lexis.types import Camera, Image, Observation
from sim.camera import CameraRenderer, fovy_deg
from sim.errors import SimError
from sim.odometry import Odometry
from sim.scene import build_scene
from sim.tour import Tour
from worlds.house import House
from worlds.truth import NOWHERE, floor_at, room_at

_AHEAD = 16


@dataclass(frozen=True, eq=False)
class Truth:
    """What is true when an observation is made. It never reaches LEXIS."""

    index: int
    T_W_B: Float64[np.ndarray, "4 4"]
    room: int
    """Index into `House.rooms` of the room that holds the camera."""
    label: str
    """Of that room."""
    storey: int


class Session:
    """Iterate, once or often, to get `(Observation, Truth)` pairs in the order of time.

    Frames are rendered ahead by a thread that owns the GL context, so that rendering and LEXIS share two cores. Raises
    `SimError` where the tour leaves the house.
    """

    def __init__(self, house: House, tour: Tour, odometry: Odometry, camera: Camera) -> None:
        self.house, self.tour, self.odometry, self.camera = house, tour, odometry, camera
        self.truths = _truths(house, tour)
        self.scene = build_scene(house, (camera.intrinsics.width, camera.intrinsics.height), fovy_deg(camera.intrinsics))
        self.render_seconds = 0.0
        """Time spent on rendering so far, in its own thread [s]."""

    def __len__(self) -> int:
        return len(self.tour.stamps)

    def __iter__(self) -> Iterator[tuple[Observation, Truth]]:
        # As quaternions, which is how odometry comes: a recording of the run then gives the same poses, bit by bit.
        T_O_B = poses_of(pose_rows(self.odometry.T_O_B))
        for i, image in enumerate(self._images()):
            stamp = float(self.tour.stamps[i])
            yield Observation(i, stamp, image, T_O_B[i], self.odometry.increment_covariance[i]), self.truths[i]

    def _images(self) -> Iterator[Image]:
        with ThreadPoolExecutor(max_workers=1) as thread:
            renderer = thread.submit(CameraRenderer, self.scene, self.camera).result()

            def render(T_W_B: Float64[np.ndarray, "4 4"]) -> Image:
                start = time.perf_counter()
                image = renderer.rgb(T_W_B)
                self.render_seconds += time.perf_counter() - start
                return image

            try:
                pending = deque(thread.submit(render, T) for T in self.tour.T_W_B[:_AHEAD])
                for T_W_B in self.tour.T_W_B[_AHEAD:]:
                    pending.append(thread.submit(render, T_W_B))
                    yield pending.popleft().result()
                while pending:
                    yield pending.popleft().result()
            finally:
                thread.submit(renderer.close).result()


def _truths(house: House, tour: Tour) -> tuple[Truth, ...]:
    positions = tour.T_W_B[:, :3, 3]
    rooms, storeys = room_at(house, positions), floor_at(house, positions)
    if (outside := rooms == NOWHERE).any():
        frame = int(np.argmax(outside))
        place = ", ".join(f"{coordinate:.2f}" for coordinate in positions[frame])
        raise SimError(f"session: frame {frame} at ({place}) m is in no room; valid: a tour inside the house")
    return tuple(
        Truth(i, T, int(room), house.rooms[room].label, int(storey))
        for i, (T, room, storey) in enumerate(zip(tour.T_W_B, rooms, storeys, strict=True))
    )
