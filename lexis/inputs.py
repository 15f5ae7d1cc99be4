"""What LEXIS is given is checked at the door, so that the stages behind need not."""

from collections.abc import Sequence

import numpy as np

from lexis.errors import LexisError, ObservationError
from lexis.se3 import is_rigid
from lexis.types import Camera, Observation


def check_camera(camera: Camera) -> None:
    """Raise LexisError unless the image has an extent, the focal lengths are positive and ``T_B_C`` is rigid."""
    k = camera.intrinsics
    if min(k.width, k.height) < 1 or min(k.fx, k.fy) <= 0:
        raise LexisError(f"intrinsics {k} are unusable; valid: width, height >= 1 px and fx, fy > 0 px")
    if not is_rigid(camera.T_B_C):
        raise LexisError(f"T_B_C of the camera is not a rigid motion: {camera.T_B_C.tolist()}")


def check_room_names(names: Sequence[str]) -> None:
    """Raise LexisError unless there is at least one name, none is blank and none occurs twice."""
    if not names or any(not name.strip() for name in names):
        raise LexisError(f"room names {list(names)} are unusable; valid: one or more names, none of them blank")
    twice = sorted({name for name in names if list(names).count(name) > 1})
    if twice:
        raise LexisError(f"room names {twice} occur more than once; valid: every name once")


def check_observation(observation: Observation, camera: Camera, previous: Observation | None) -> None:
    """Raise ObservationError unless image, pose and covariance are usable and time moves on."""
    where = f"observation {observation.index}"
    expected = (camera.intrinsics.height, camera.intrinsics.width, 3)
    if observation.image.shape != expected or observation.image.dtype != np.uint8:
        found = f"{observation.image.dtype} {observation.image.shape}"
        raise ObservationError(f"{where}: the image is {found}; the camera makes uint8 {expected}")
    if not is_rigid(observation.T_O_B):
        raise ObservationError(f"{where}: T_O_B is not a rigid motion: {observation.T_O_B.tolist()}")
    covariance = observation.increment_covariance
    if not np.isfinite(covariance).all() or not np.allclose(covariance, covariance.T):
        raise ObservationError(f"{where}: increment_covariance is not finite and symmetric")
    if np.linalg.eigvalsh(covariance).min() < -1e-12:
        raise ObservationError(f"{where}: increment_covariance has a negative eigenvalue; valid: none")
    if not np.isfinite(observation.stamp):
        raise ObservationError(f"{where}: stamp {observation.stamp} s is not finite")
    if previous is not None and observation.stamp <= previous.stamp:
        raise ObservationError(f"{where}: stamp {observation.stamp} s is not after {previous.stamp} s, the one before")
