"""A session: the camera walks its tour through the house and yields what a robot would see, beside what is true."""

import time
from collections.abc import Generator, Sequence
from contextlib import closing

import numpy as np

from lexis.maths.quaternions import pose_rows, poses_of
from lexis.types import Camera, Image, Observation, Percept
from lexis.verification import Verifier, verify
from sim.errors import SimError
from sim.faults import Fault, corrupted
from sim.feature_sensor.sensor import FeatureSensor
from sim.odometry.simulation import Odometry
from sim.prefetch import prefetched
from sim.render.lens import Distortion, rendered_camera
from sim.render.scene import Scene
from sim.tours.tour import Tour
from sim.truth import Truth
from sim.world_states import FrameRenderer, WorldStates
from worlds.house import House
from worlds.truth import NOWHERE, floor_at, room_at

__all__ = ["Session", "Truth"]

_AHEAD = 16


class Session:
    """Iterate, once or often, to get `(Observation, Truth)` pairs in the order in which they arrive.

    That is the order of time unless `faults` change it; these draw from streams of `seed`. Frames are rendered ahead by a
    thread that owns the GL context, so that rendering and LEXIS share two cores; with a `sensor` nothing is rendered, and
    observations bring what it senses. With a `distortion` the images are as a lens bends them; LEXIS, whose camera is a
    pinhole, has to be given them straightened. Who may stop early closes the iterator (`contextlib.closing`). Raises
    `SimError` where the tour leaves the house.
    """

    def __init__(
        self,
        house: House,
        tour: Tour,
        odometry: Odometry,
        camera: Camera,
        faults: Sequence[Fault] = (),
        seed: int = 0,
        sensor: FeatureSensor | None = None,
        distortion: Distortion | None = None,
    ) -> None:
        self.house, self.tour, self.odometry, self.camera = house, tour, odometry, camera
        self.faults, self._seed = tuple(faults), seed
        truths = _truths(house, tour)
        self._distortion = distortion
        rendered = rendered_camera(camera, distortion) if distortion else camera
        self._staging = WorldStates(house, tour, rendered, self.faults, seed)
        self._sensor = sensor
        if sensor is None:
            self._staging.compile()
        self.truths = self._staging.marked(truths)
        """Of every frame of the tour, without faults of the stream."""
        self.render_seconds = 0.0
        """Time spent on rendering, or on sensing, so far, in its own thread [s]."""

    @property
    def scene(self) -> Scene:
        """What there is to see at the start of the tour."""
        return self._staging.set_at(0).scene

    def __len__(self) -> int:
        """Frames of the tour."""
        return len(self.tour.stamps)

    def __iter__(self) -> Generator[tuple[Observation, Truth], None, None]:
        with closing(self._stream()) as stream:
            yield from corrupted(stream, self.faults, self._seed)

    def _stream(self) -> Generator[tuple[Observation, Truth], None, None]:
        # As quaternions, which is how odometry comes: a recording of the run then gives the same poses, bit by bit.
        T_O_B = poses_of(pose_rows(self.odometry.T_O_B))
        with closing(prefetched(self._images, _AHEAD)) as images:
            for i, image in enumerate(images):
                stamp = float(self.tour.stamps[i])
                yield Observation(i, stamp, image, T_O_B[i], self.odometry.increment_covariance[i]), self.truths[i]

    def verifier(self) -> Verifier:
        """What verifies loops of this tour: LEXIS itself on images, the sensor where there are none."""
        return verify if self._sensor is None else self._sensor.verifier(self._staging.houses, self.tour.T_W_B)

    def _images(self) -> Generator[Image | Percept, None, None]:
        return self._rendered() if self._sensor is None else self._sensed(self._sensor)

    def _sensed(self, sensor: FeatureSensor) -> Generator[Percept, None, None]:
        start = time.perf_counter()
        for percept in sensor.percepts(self._staging.houses, self.tour.T_W_B):
            self.render_seconds += time.perf_counter() - start
            yield percept
            start = time.perf_counter()

    def _rendered(self) -> Generator[Image, None, None]:
        with closing(FrameRenderer(self._staging, self.camera, self._distortion)) as painter:
            for frame, T_W_B in enumerate(self.tour.T_W_B):
                start = time.perf_counter()
                image = painter.rgb(frame, T_W_B)
                self.render_seconds += time.perf_counter() - start
                yield image


def _truths(house: House, tour: Tour) -> tuple[Truth, ...]:
    positions = tour.T_W_B[:, :3, 3]
    rooms, storeys = room_at(house, positions), floor_at(house, positions)
    if (outside := rooms == NOWHERE).any():
        frame = int(np.argmax(outside))
        place = ", ".join(f"{coordinate:.2f}" for coordinate in positions[frame])
        raise SimError(f"session: frame {frame} at ({place}) m is in no room; valid: a tour inside the house")
    return tuple(
        Truth(i, float(stamp), T, int(room), house.rooms[room].label, int(storey))
        for i, (stamp, T, room, storey) in enumerate(zip(tour.stamps, tour.T_W_B, rooms, storeys, strict=True))
    )
