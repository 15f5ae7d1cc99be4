"""`Session`: a simulated run along a tour, which yields each observation of the robot together with the ground truth."""

import time
from collections.abc import Generator, Sequence
from contextlib import closing
from dataclasses import replace

import numpy as np

from lexis.maths.quaternions import pose_rows, poses_of
from lexis.types import Camera, Image, Observation, Percept, Poses
from lexis.verification import Verifier, verify
from sim.errors import SimError
from sim.faults import Fault, corrupted
from sim.faults.delivery import Frozen
from sim.faults.fault import has_pose
from sim.faults.images import OF_IMAGES
from sim.feature_sensor.sensor import FeatureSensor, SensedTour
from sim.odometry.simulation import Odometry
from sim.prefetch import prefetched
from sim.render.lens import Distortion, rendered_camera
from sim.render.scene import Scene
from sim.tours.tour import Tour
from sim.truth import Truth, camera_positions
from sim.world_states import FrameRenderer, WorldStates
from worlds.house import House
from worlds.truth import NOWHERE, floor_at, room_at

__all__ = ["Session", "Truth"]

_AHEAD = 16
"""Number of images that are rendered ahead of the consumer."""


class Session:
    """The observations of a run along a tour, as an iterable of `(Observation, Truth)` pairs in the order of arrival.

    The images of an observation are those of all cameras of `camera.rig`.

    A session can be iterated several times. Observations arrive in order of time unless `faults` change that order. `seed`
    determines the random numbers of the faults. A background thread, which owns the GL context, renders frames ahead, so
    that rendering and LEXIS run on two cores. With a `sensor` nothing is rendered, and each observation holds a percept (a
    simulated embedding) instead of an image. With a `distortion` the images are distorted as by a real lens. The caller has
    to undistort them for LEXIS, whose camera model is a pinhole. With `keeps_images`, the images of the first complete
    iteration are kept in memory, and later iterations yield copies of them. A caller that may stop early has to close the
    iterator (`contextlib.closing`). Raises `SimError` if the tour leaves the house.
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
        keeps_images: bool = False,
    ) -> None:
        self.house, self.tour, self.odometry, self.camera = house, tour, odometry, camera
        self.faults, self._seed = tuple(faults), seed
        truths = _truths(house, tour, camera)
        self._distortion = distortion
        self._keeps_images = keeps_images
        self._kept: list[tuple[Image, ...]] = []
        """The images of all frames, as the first complete iteration rendered them; empty if they are not kept."""
        rendered = rendered_camera(camera, distortion) if distortion else camera
        self._world_states = WorldStates(house, tour, rendered, self.faults, seed)
        self._sensed = None if sensor is None else sensor.tour(self._world_states.houses, tour.T_W_B)
        if sensor is None:
            self._world_states.compile()
        self.truths = self._world_states.marked(truths)
        """Ground truth of every frame of the tour. It names active faults of the world, but no faults of observations."""
        self.render_seconds = 0.0
        """Time spent so far on rendering images, or on simulating percepts in their place [s]."""

    @property
    def scene(self) -> Scene:
        """The house as a compiled MuJoCo scene, as it is at the start of the tour."""
        return self._world_states.world_at(0).scene

    def __len__(self) -> int:
        """Return the number of frames of the tour."""
        return len(self.tour.stamps)

    def __iter__(self) -> Generator[tuple[Observation, Truth], None, None]:
        T_O_B = _as_recorded(self.odometry.T_O_B)
        with closing(self._stream(T_O_B)) as stream:
            for observation, truth in corrupted(stream, self.faults, self._seed):
                is_recorded = np.array_equal(observation.T_O_B, T_O_B[observation.index])
                yield _with_own_arrays(observation, is_recorded), truth

    def _stream(self, T_O_B: Poses) -> Generator[tuple[Observation, Truth], None, None]:
        with closing(self._images()) as images:
            for i, (image, *others) in enumerate(images):
                stamp = float(self.tour.stamps[i])
                covariance = self.odometry.increment_covariance[i]
                yield Observation(i, stamp, image, T_O_B[i], covariance, tuple(others)), self.truths[i]

    @property
    def faults_of_images(self) -> tuple[str, ...]:
        """Names of the faults that change or repeat images after they were rendered; `pictures` does not show them."""
        return tuple(fault.name for fault in self.faults if isinstance(fault, (*OF_IMAGES, Frozen)))

    def pictures(self, frames: Sequence[int]) -> list[Image]:
        """Render the first camera's images of some frames of the tour, without the faults `faults_of_images`.

        This also works in a session with a `sensor`, which itself renders no images. Raises `GraphicsError` if there is no
        off-screen OpenGL.
        """
        with closing(FrameRenderer(self._world_states, self.camera, self._distortion)) as renderer:
            return [renderer.rgb(frame, self.tour.T_W_B[frame]) for frame in frames]

    def verifier(self) -> Verifier:
        """Return the function that verifies LEXIS's loop candidates.

        In a session with images, this is LEXIS's own verifier; with a `sensor`, it is the sensor's model of this verifier.
        """
        return verify if self._sensed is None else self._sensed.verifier()

    def _images(self) -> Generator[tuple[Image | Percept, ...], None, None]:
        """Yield what all cameras of the rig see in each frame."""
        if self._sensed is not None:
            return self._percepts(self._sensed)  # not in a thread, because work in numpy alone gains nothing from it
        return self._copies() if self._kept else prefetched(self._rendered, _AHEAD)

    def _percepts(self, sensed: SensedTour) -> Generator[tuple[Percept, ...], None, None]:
        start = time.perf_counter()
        for percepts in sensed.percepts():
            self.render_seconds += time.perf_counter() - start
            yield percepts
            start = time.perf_counter()

    def _copies(self) -> Generator[tuple[Image, ...], None, None]:
        """Yield copies of the kept images, because the SLAM may write into its images."""
        for images in self._kept:
            yield tuple(image.copy() for image in images)

    def _rendered(self) -> Generator[tuple[Image, ...], None, None]:
        kept = []
        with closing(FrameRenderer(self._world_states, self.camera, self._distortion)) as renderer:
            for frame, T_W_B in enumerate(self.tour.T_W_B):
                start = time.perf_counter()
                images = renderer.rig(frame, T_W_B)
                self.render_seconds += time.perf_counter() - start
                if self._keeps_images:
                    kept.append(tuple(image.copy() for image in images))
                yield images
        self._kept = kept


def _with_own_arrays(observation: Observation, is_recorded: bool) -> Observation:
    """Return the observation with pose and covariance in arrays of its own, because the SLAM may write into them.

    Faults keep arrays of earlier observations, and reuse them. Faults that repeat images copy these themselves.
    `is_recorded` says whether the pose is one that recordings hold; another pose, which a fault has changed, becomes one.
    """
    T_O_B = observation.T_O_B.copy()
    if not is_recorded and has_pose(observation):
        T_O_B = _as_recorded(T_O_B[None])[0]
    return replace(observation, T_O_B=T_O_B, increment_covariance=observation.increment_covariance.copy())


def _as_recorded(poses: Poses) -> Poses:
    """Return the poses as recordings hold them: as quaternions. A replayed recording then gives them bit by bit."""
    return poses_of(pose_rows(poses))


def _truths(house: House, tour: Tour, camera: Camera) -> tuple[Truth, ...]:
    positions = camera_positions(tour.T_W_B, camera)
    rooms, storeys = room_at(house, positions), floor_at(house, positions)
    if (outside := rooms == NOWHERE).any():
        frame = int(np.argmax(outside))
        place = ", ".join(f"{coordinate:.2f}" for coordinate in positions[frame])
        raise SimError(f"session: frame {frame} at ({place}) m is in no room; valid: a tour that stays inside the house")
    return tuple(
        Truth(i, float(stamp), T, int(room), house.rooms[room].label, int(storey))
        for i, (stamp, T, room, storey) in enumerate(zip(tour.stamps, tour.T_W_B, rooms, storeys, strict=True))
    )
