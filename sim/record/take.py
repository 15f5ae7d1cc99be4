"""What the sensors of a robot report on one walk: images of several cameras, depth, IMU and odometry, beside the truth.

A take begins with a moment at rest, which visual-inertial systems use to find gravity. LEXIS makes nothing of it: it keeps
no frame where the odometry has not moved.
"""

from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from zlib import crc32

import numpy as np
from jaxtyping import Float32, Float64, Int64

from lexis.inputs import pixels
from lexis.types import Camera, Image, Observation
from sim.errors import SimError
from sim.harness.config import RunConfig
from sim.harness.walk import Walk, walk
from sim.odometry.imu import GRAVITY_M_S2, Imu, ImuConfig, corrupted, ideal_imu
from sim.render.lens import Distortion, rendered_camera
from sim.render.rig import FREE_M, STEREO_BASELINE_M
from sim.session import Session
from sim.truth import Truth
from sim.world_states import FrameRenderer, WorldStates

EPOCH_NS = 10**18
"""Stamp of the first frame, in 2001: stamps have 19 digits, as tools that cut them into seconds and nanoseconds expect."""
REST_S = 2.0
"""At the start [s]."""
_MARGIN_S = 0.1
"""The IMU begins this much before the first frame and ends this much after the walk [s]."""


@dataclass(frozen=True, eq=False)
class RecordedFrame:
    """All that is recorded at one instant."""

    stamp_ns: int
    observation: Observation
    """What LEXIS is given; its image is that of the first camera."""
    truth: Truth
    images: Mapping[str, Image]
    """By camera, the first one included."""
    depth: Float32[np.ndarray, "h w"] | None
    """Of the first camera, along its optical axis [m]."""


@dataclass(frozen=True, eq=False)
class Take:
    """One walk, its sensors, and what they report."""

    config: RunConfig
    walk: Walk
    cameras: Mapping[str, Camera]
    """cam0 is the one that LEXIS sees."""
    imu_config: ImuConfig
    distortion: Distortion
    """Distortion of the lens of every camera."""
    imu: Imu
    """Stamps count from the start of the walk, so they begin below 0 [s]."""

    @property
    def rest_frames(self) -> int:
        """How many frames are at rest before the walk begins."""
        return round(REST_S / self.frame_s)

    @property
    def frame_s(self) -> float:
        """Time between frames [s]."""
        return float(self.walk.tour.stamps[1] - self.walk.tour.stamps[0])

    def __len__(self) -> int:
        return self.rest_frames + len(self.walk.tour.stamps)

    @cached_property
    def imu_ns(self) -> Int64[np.ndarray, "n"]:
        """Stamps of the IMU and of the true poses [ns]."""
        return np.array([stamp_ns(t) for t in self.imu.stamps.tolist()], np.int64)

    @property
    def T_W_B(self) -> Float64[np.ndarray, "n 4 4"]:
        """True poses at the stamps of the IMU."""
        return self.walk.tour.motion.poses_at(self.imu.stamps, self.walk.tour.eye_height_m)

    @property
    def velocity(self) -> Float64[np.ndarray, "n 3"]:
        """True velocities in W at the stamps of the IMU [m/s]."""
        moving = (self.imu.stamps > 0.0) & (self.imu.stamps < self.walk.tour.motion.duration_s)
        return np.where(moving[:, None], self.walk.tour.motion.velocity(self.imu.stamps), 0.0)

    def frames(self, cameras: tuple[str, ...] = (), depth: bool = False) -> Generator[RecordedFrame, None, None]:
        """The frames as they arrive, with images of cam0 and of the other `cameras` named, and its depth if asked for.

        Faults of images are those of cam0 alone, whose images LEXIS sees; faults of the world are seen by all.

        Raises `GraphicsError` where there is no off-screen OpenGL.
        """
        walked, faults, seed = self.walk, self.config.faults, self.config.seed
        camera = self.cameras["cam0"]
        bent = self.distortion
        session = Session(walked.house, walked.tour, walked.odometry, camera, faults, seed, distortion=bent)
        # A staging of its own: the session renders in another thread.
        rendered = rendered_camera(camera, bent) if bent else camera
        staging = WorldStates(walked.house, walked.tour, rendered, faults, seed)
        with ExitStack() as stack:
            painters = {
                name: stack.enter_context(closing(FrameRenderer(staging, self.cameras[name], bent))) for name in cameras
            }
            ranging = stack.enter_context(closing(FrameRenderer(staging, camera, bent))) if depth else None
            pairs = stack.enter_context(closing(iter(session)))
            for k, (observation, truth) in enumerate(pairs):
                images = {name: painter.rgb(truth.index, truth.T_W_B) for name, painter in painters.items()}
                frame = RecordedFrame(
                    stamp_ns(observation.stamp),
                    observation,
                    truth,
                    MappingProxyType({"cam0": pixels(observation), **images}),
                    None if ranging is None else ranging.depth(truth.index, truth.T_W_B),
                )
                yield from self._at_rest(frame) if k == 0 else [frame]

    def _at_rest(self, first: RecordedFrame) -> Iterator[RecordedFrame]:
        """The first frame as often as the rest lasts, then once more; nothing moves, so the odometry makes no error."""
        still = replace(first.observation, increment_covariance=np.zeros((6, 6)))
        for k in range(-self.rest_frames, 1):
            stamp = first.observation.stamp + k * self.frame_s
            yield replace(first, stamp_ns=stamp_ns(stamp), observation=replace(still, stamp=stamp))


def prepare(config: RunConfig, imu_config: ImuConfig | None = None, distortion: Distortion | None = None) -> Take:
    """Plan what `config` describes; nothing is rendered yet. Raises what `sim.harness.run` raises, and what `Lens` does.

    The cameras are the pinholes of the config's rig; beside a single one, another to the right of it. All have the same
    `distortion`, by default none.
    """
    imu_config, distortion = imu_config or ImuConfig(), distortion or Distortion()
    pinholes = tuple(config.rig.cameras.values())
    cameras = (*pinholes, stereo_partner(config.rig.front)) if len(pinholes) == 1 else pinholes
    _check_places(cameras)
    if distortion:
        rendered_camera(config.rig.front, distortion)  # refuses what cannot be rendered, before the work
    walked = walk(config)
    # A stream of the IMU's own, so that it leaves those of the run alone.
    rng = np.random.default_rng(np.random.SeedSequence(config.seed, spawn_key=(crc32(b"imu"),)))
    imu = corrupted(_with_rest(ideal_imu(walked.tour.motion, imu_config.rate_hz), imu_config.rate_hz), imu_config, rng)
    return Take(config, walked, {f"cam{k}": camera for k, camera in enumerate(cameras)}, imu_config, distortion, imu)


def _check_places(cameras: Sequence[Camera]) -> None:
    """Raise SimError for a camera outside of the space that is kept free around the body."""
    for k, camera in enumerate(cameras):
        if (distance_m := float(np.linalg.norm(camera.T_B_C[:2, 3]))) > FREE_M:
            raise SimError(
                f"rig: cam{k} is {distance_m:.2f} m beside the IMU, where furniture or walls may be; "
                f"valid: up to {FREE_M} m, with a smaller lever arm"
            )


def stereo_partner(camera: Camera) -> Camera:
    """The same camera to the right of it, parallel."""
    step = np.eye(4)
    step[0, 3] = STEREO_BASELINE_M
    return Camera(camera.intrinsics, camera.T_B_C @ step)


def stamp_ns(seconds: float) -> int:
    """The stamp of a time that counts from the start of the walk [ns]."""
    return EPOCH_NS + round((seconds + REST_S) * 1e9)


def _with_rest(imu: Imu, rate_hz: float) -> Imu:
    """The measurements with rest before and after them: the motion begins and ends with it, upright."""
    before, after = round((REST_S + _MARGIN_S) * rate_hz), round(_MARGIN_S * rate_hz)
    stamps = np.arange(-before, len(imu.stamps) + after) / rate_hz
    pad = ((before, after), (0, 0))
    force = np.pad(imu.specific_force, pad)
    for rest in (slice(None, before), slice(len(force) - after, None)):
        force[rest] = [0.0, 0.0, GRAVITY_M_S2]
    zero = np.zeros_like(force)
    return Imu(stamps, np.pad(imu.angular_velocity, pad), force, zero, zero)
