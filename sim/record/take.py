"""`Take`: the sensor data of one walk. It has images of several cameras, depth, IMU and odometry, with ground truth.

A take begins with two seconds at rest, during which visual-inertial systems estimate the direction of gravity. This does not
change LEXIS's map, since LEXIS adds no keyframe while the odometry does not move.
"""

from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, fields, replace
from functools import cached_property
from types import MappingProxyType
from zlib import crc32

import numpy as np
from jaxtyping import Float32, Float64, Int64

from lexis.inputs import pixels
from lexis.types import Camera, Image, Observation
from sim.errors import SimError
from sim.faults.delivery import Dropped, Duplicated, Late, OutOfOrder
from sim.faults.fault import Fault, StreamFault
from sim.faults.poses import Kidnap, OdometryNaN
from sim.faults.stamps import StampJitter, StampJump, StampOffset
from sim.harness.scenario import Scenario
from sim.harness.walk import Walk, walk
from sim.number_checks import check_count
from sim.odometry.imu import GRAVITY_M_S2, Imu, ImuConfig, ideal_imu, with_noise
from sim.record.stamps import MAX_DAY, REST_S, stamp_ns
from sim.render.lens import Distortion, rendered_camera
from sim.render.rig import FREE_M, STEREO_BASELINE_M, build_rig
from sim.session import Session
from sim.truth import Truth
from sim.world_states import FrameRenderer, WorldStates

_CHANGES_TIMES = Dropped, Duplicated, Late, OutOfOrder, StampOffset, StampJitter, StampJump
"""Faults that change which frames arrive, their order or their stamps."""
_MARGIN_S = 0.1
"""Time that the IMU measures before the first frame, and again after the end of the walk [s]."""


@dataclass(frozen=True, eq=False)
class RecordedFrame:
    """All data that are recorded with one camera frame."""

    stamp_ns: int
    observation: Observation
    """Input of LEXIS, with the images of the rig."""
    truth: Truth
    images: Mapping[str, Image]
    """Images of cam0 and the other recorded cameras, by camera name."""
    depth: Float32[np.ndarray, "h w"] | None
    """Depth along the optical axis of cam0 [m]; None if it was not requested."""


@dataclass(frozen=True, eq=False)
class Take:
    """One walk with its sensors and their data. Images are rendered only when `frames` is iterated."""

    scenario: Scenario
    walk: Walk
    rig: Camera
    """The first pinhole camera of the rig with the others, whose images LEXIS receives."""
    cameras: Mapping[str, Camera]
    """All recorded cameras by name: cam0 and the others of the rig, or cam0 and a second camera for stereo."""
    imu_config: ImuConfig
    distortion: Distortion
    """Distortion of the lens of every camera."""
    imu: Imu
    """IMU data. Stamps count from the start of the walk [s]; they are negative during the rest before the walk."""
    walk_s: Float64[np.ndarray, "n"]
    """Time in the walk at which the IMU measured [s]. It differs from the stamps where a kidnapping cuts a part out."""
    with_truth: bool = True
    """Whether recordings contain the ground truth: true poses, rooms and the house."""
    day: int = 0
    """Number of days by which all stamps are later than those of other recordings."""

    @cached_property
    def session(self) -> Session:
        """The walk as a session, which yields the images of the rig with the odometry, and the truth of every frame."""
        return self._session(self.rig)

    def _session(self, camera: Camera) -> Session:
        walked, scenario = self.walk, self.scenario
        faults, bent = scenario.faults, self.distortion
        return Session(walked.house, walked.tour, walked.odometry, camera, faults, scenario.seed, distortion=bent)

    @property
    def rest_frames(self) -> int:
        """Number of frames at rest before the walk begins."""
        return round(REST_S / self.frame_s)

    @property
    def frame_s(self) -> float:
        """Time between consecutive frames [s]."""
        return 1.0 / self.scenario.frame_rate_hz

    def __len__(self) -> int:
        return self.rest_frames + len(self.walk.tour.stamps)

    @cached_property
    def imu_ns(self) -> Int64[np.ndarray, "n"]:
        """Stamps of the IMU and of the true poses [ns]."""
        return np.array([stamp_ns(t, self.day) for t in self.imu.stamps.tolist()], np.int64)

    @property
    def T_W_B(self) -> Float64[np.ndarray, "n 4 4"]:
        """True poses of the body at the stamps of the IMU."""
        return self.walk.tour.motion.poses_at(self.walk_s, self.walk.tour.eye_height_m)

    @property
    def velocity(self) -> Float64[np.ndarray, "n 3"]:
        """True velocities in W at the stamps of the IMU [m/s]."""
        moving = (self.walk_s > 0.0) & (self.walk_s < self.walk.tour.motion.duration_s)
        return np.where(moving[:, None], self.walk.tour.motion.velocity(self.walk_s), 0.0)

    def frames(self, cameras: tuple[str, ...] = (), depth: bool = False) -> Generator[RecordedFrame, None, None]:
        """Render and yield the frames in order, beginning with the frames at rest before the walk.

        A frame has the images of cam0 and of the further `cameras`. With `depth`, it also has the depth of cam0. Faults of
        images and frozen images affect the cameras of the rig, but neither the depth nor a second camera that is added to a
        single one for stereo. Faults of the world are visible to all cameras.

        Raises `GraphicsError` if off-screen OpenGL is not available, and `SimError` if faults lose every frame of the walk.
        """
        walked, faults, seed = self.walk, self.scenario.faults, self.scenario.seed
        camera = self.cameras["cam0"]
        bent = self.distortion
        # The session renders in another thread, so the other cameras need world states of their own.
        rendered = rendered_camera(camera, bent) if bent else camera
        states = WorldStates(walked.house, walked.tour, rendered, faults, seed)
        rig = self.rig if cameras else camera
        session, of_rig = self.session if cameras else self._session(camera), [f"cam{k}" for k in range(len(rig.rig))]
        with ExitStack() as stack:
            painters = {
                name: stack.enter_context(closing(FrameRenderer(states, self.cameras[name], bent)))
                for name in cameras
                if name not in of_rig
            }
            ranging = stack.enter_context(closing(FrameRenderer(states, camera, bent))) if depth else None

            def recorded(observation: Observation, truth: Truth) -> RecordedFrame:
                images = {name: painter.rgb(truth.index, truth.T_W_B) for name, painter in painters.items()}
                return RecordedFrame(
                    stamp_ns(observation.stamp, self.day),
                    observation,
                    truth,
                    MappingProxyType({**dict(zip(of_rig, pixels(observation), strict=True)), **images}),
                    None if ranging is None else ranging.depth(truth.index, truth.T_W_B),
                )

            pairs = stack.enter_context(closing(iter(session)))
            k = -1
            for k, (observation, truth) in enumerate(pairs):
                frame = recorded(observation, truth)
                if k == 0:
                    yield from self._at_rest(_still(frame if truth.index == 0 else recorded(*self._start(rig))))
                yield _still(frame) if k == truth.index == 0 else frame
            if k < 0:
                raise SimError("recording: the faults lose every frame of the walk; valid: a longer walk, or fewer faults")

    def _start(self, camera: Camera) -> tuple[Observation, Truth]:
        """Return the first frame of the walk as it is without faults of the stream, which may have lost or delayed it."""
        of_images = tuple(fault for fault in self.scenario.faults if not isinstance(fault, StreamFault))
        of_world = replace(self, scenario=replace(self.scenario, faults=of_images))
        with closing(iter(of_world._session(camera))) as pairs:
            return next(pairs)

    def _at_rest(self, start: RecordedFrame) -> Iterator[RecordedFrame]:
        """Yield copies of the first frame of the walk during the rest before it."""
        for k in range(-self.rest_frames, 0):
            stamp = start.observation.stamp + k * self.frame_s
            yield replace(start, stamp_ns=stamp_ns(stamp, self.day), observation=replace(start.observation, stamp=stamp))


def _still(frame: RecordedFrame) -> RecordedFrame:
    """Return the frame with odometry that has not moved: the covariance of its increment is zero."""
    return replace(frame, observation=replace(frame.observation, increment_covariance=np.zeros((6, 6))))


def prepare(
    scenario: Scenario,
    imu_config: ImuConfig | None = None,
    distortion: Distortion | None = None,
    with_truth: bool = True,
    day: int = 0,
) -> Take:
    """Plan the walk of the run `scenario`, and simulate odometry and IMU. Nothing is rendered yet.

    The cameras are the pinhole cameras of the scenario's rig. If there is only one, a second camera is added on its right.
    All cameras have the same `distortion`; by default, there is none. Stamps are `day` days later than usual.

    Raises the errors of `sim.harness.run` and `Lens`, and `SimError` for a `day` that is not valid, for a camera that is too
    far from the IMU, for faults that make poses NaN, which no format of recordings can hold, and for a kidnap after faults
    that change the stamps or the delivery of frames: which part of the IMU data it cuts out would depend on them.
    """
    if any(isinstance(fault, OdometryNaN) for fault in scenario.faults):
        raise SimError(f"fault {OdometryNaN.name}: recordings hold finite poses only; valid: other faults")
    check_count("day", day, 0, MAX_DAY)
    _check_order(scenario.faults)
    imu_config, distortion = imu_config or ImuConfig(), distortion or Distortion()
    rig = build_rig(scenario.rig)
    pinholes = tuple(rig.cameras.values())
    cameras = (*pinholes, stereo_partner(rig.front)) if len(pinholes) == 1 else pinholes
    _check_places(cameras)
    if distortion:
        rendered_camera(rig.front, distortion)  # raises before the walk is planned
    walked = walk(scenario)
    # The IMU has its own random stream, so that recording does not change the random numbers of the run.
    rng = np.random.default_rng(np.random.SeedSequence(scenario.seed, spawn_key=(crc32(b"imu"),)))
    imu = with_noise(_with_rest(ideal_imu(walked.tour.motion, imu_config.rate_hz), imu_config.rate_hz), imu_config, rng)
    imu, walk_s = _without_cuts(imu, walked.tour.stamps, scenario.faults)
    named = {f"cam{k}": camera for k, camera in enumerate(cameras)}
    return Take(scenario, walked, rig.front, named, imu_config, distortion, imu, walk_s, with_truth, day)


def _check_order(faults: Sequence[Fault]) -> None:
    """Raise `SimError` for a kidnap after a fault that changes which frames arrive, their order or their stamps."""
    kidnaps = [k for k, fault in enumerate(faults) if isinstance(fault, Kidnap)]
    before = [fault for fault in faults[: kidnaps[-1]] if isinstance(fault, _CHANGES_TIMES)] if kidnaps else []
    if before:
        raise SimError(f"fault {Kidnap.name} comes after {before[0].name}, so that IMU data would not fit; valid: before it")


def _without_cuts(
    imu: Imu, frames_s: Float64[np.ndarray, "k"], faults: Sequence[Fault]
) -> tuple[Imu, Float64[np.ndarray, "n"]]:
    """Cut the same parts out of IMU data that kidnappings cut out of the walk.

    Return the rest of the data, whose stamps continue without a gap, and the time in the walk of every measurement [s].
    """
    walk_s = imu.stamps
    for fault in faults:
        if isinstance(fault, Kidnap):
            start, end = fault.cut(frames_s)
            frames_s = _closed(frames_s[(frames_s <= start) | (frames_s > end)], start, end)
            kept = (imu.stamps <= start) | (imu.stamps > end)
            walk_s, imu = walk_s[kept], Imu(*(getattr(imu, each.name)[kept] for each in fields(imu)))
            imu = replace(imu, stamps=_closed(imu.stamps, start, end))
    return imu, walk_s


def _closed(stamps: Float64[np.ndarray, "n"], start: float, end: float) -> Float64[np.ndarray, "n"]:
    """Return stamps without the gap between `start` and `end` [s]."""
    return np.where(stamps > start, stamps - (end - start), stamps)


def _check_places(cameras: Sequence[Camera]) -> None:
    """Raise `SimError` for a camera outside of the space around the IMU that is always free of obstacles during a walk."""
    for k, camera in enumerate(cameras):
        if (distance_m := float(np.linalg.norm(camera.T_B_C[:2, 3]))) > FREE_M:
            raise SimError(
                f"rig: cam{k} is {distance_m:.2f} m beside the IMU, where furniture or walls may be; "
                f"valid: up to {FREE_M} m, with a smaller lever arm"
            )


def stereo_partner(camera: Camera) -> Camera:
    """Return the right camera of a stereo pair. It is parallel to `camera`, and `STEREO_BASELINE_M` to the right of it."""
    step = np.eye(4)
    step[0, 3] = STEREO_BASELINE_M
    return Camera(camera.intrinsics, camera.T_B_C @ step)


def _with_rest(imu: Imu, rate_hz: float) -> Imu:
    """Add measurements at rest before and after the walk, which itself starts and ends upright and at rest."""
    before, after = round((REST_S + _MARGIN_S) * rate_hz), round(_MARGIN_S * rate_hz)
    stamps = np.arange(-before, len(imu.stamps) + after) / rate_hz
    pad = ((before, after), (0, 0))
    force = np.pad(imu.specific_force, pad)
    for rest in (slice(None, before), slice(len(force) - after, None)):
        force[rest] = [0.0, 0.0, GRAVITY_M_S2]
    zero = np.zeros_like(force)
    return Imu(stamps, np.pad(imu.angular_velocity, pad), force, zero, zero)
