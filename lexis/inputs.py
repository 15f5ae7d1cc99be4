"""What LEXIS is given is checked at the door, so that the stages behind need not."""

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64

from lexis.errors import LexisError, ObservationError
from lexis.se3 import is_rigid
from lexis.types import Camera, Image, Observation, Percept

MAX_ROOM_NAMES = 1000
"""In a vocabulary."""
MAX_NAME_LENGTH = 200
"""Of a room name, in characters."""

MAX_POSITION_M = 1e8
"""Farthest place from the origin along an axis: any frame on Earth fits, and squares and cubes of it stay exact enough."""

_RIGID = "valid: 4x4 with an orthonormal, right-handed rotation and 0 0 0 1 as last row"


def check_camera(camera: Camera) -> None:
    """Raise LexisError unless the image has an extent, focal lengths and centre are usable and ``T_B_C`` is rigid."""
    k = camera.intrinsics
    finite = all(map(math.isfinite, (k.fx, k.fy, k.cx, k.cy)))
    if not finite or min(k.width, k.height) < 1 or min(k.fx, k.fy) <= 0:
        raise LexisError(
            f"intrinsics {k} are unusable; valid: width, height >= 1 px, fx, fy > 0 px, and fx, fy, cx, cy finite"
        )
    if not _is_pose(camera.T_B_C):
        raise LexisError(f"T_B_C of the camera is not a rigid motion: {camera.T_B_C.tolist()}; {_RIGID}")


def check_room_names(names: Sequence[str]) -> None:
    """Raise LexisError unless there is at least one name, each can be told from the others, and all can be stored.

    Names are asked for without regard to case and outer blanks, so they may not differ in these alone.
    """
    if isinstance(names, str):
        raise LexisError(f"room names are the one text {names!r}; valid: a sequence of names, such as ({names!r},)")
    if not 1 <= len(names) <= MAX_ROOM_NAMES:
        raise LexisError(f"{len(names)} room names; valid: 1 to {MAX_ROOM_NAMES}")
    unusable = [name[:80] for name in names if not (name.strip() and name.isprintable() and len(name) <= MAX_NAME_LENGTH)]
    if unusable:
        raise LexisError(
            f"room names {unusable} are unusable; valid: names of printable characters, not blank, up to {MAX_NAME_LENGTH}"
        )
    count = Counter(name.strip().lower() for name in names)
    twice = sorted(name for name, times in count.items() if times > 1)
    if twice:
        raise LexisError(f"room names {twice} occur more than once; valid: every name once, case and outer blanks aside")


def check_observation(observation: Observation, camera: Camera, previous: Observation | None) -> None:
    """Raise ObservationError unless image, pose and covariance are usable and time moves on."""
    where = f"observation {observation.index}"
    if isinstance(observation.image, Percept):
        _check_percept(observation.image, where)
    else:
        _check_image(observation.image, camera, where)
    if not _is_pose(observation.T_O_B):
        raise ObservationError(f"{where}: T_O_B is not a rigid motion: {observation.T_O_B.tolist()}; {_RIGID}")
    covariance = observation.increment_covariance
    if covariance.shape != (6, 6) or not np.isfinite(covariance).all() or not np.allclose(covariance, covariance.T):
        raise ObservationError(
            f"{where}: increment_covariance {covariance.shape} is not finite and symmetric; valid: a 6x6 one"
        )
    if np.linalg.eigvalsh(covariance).min() < -1e-12:
        raise ObservationError(f"{where}: increment_covariance has a negative eigenvalue; valid: none")
    if not np.isfinite(observation.stamp):
        raise ObservationError(f"{where}: stamp {observation.stamp} s is not finite; valid: a time in seconds")
    if previous is not None and observation.stamp <= previous.stamp:
        raise ObservationError(
            f"{where}: stamp {observation.stamp} s is not after {previous.stamp} s, the one before; valid: ascending stamps"
        )


def pixels(observation: Observation) -> Image:
    """The image of an observation. Raises `ObservationError` where there is only what was seen in it."""
    if isinstance(observation.image, Percept):
        raise ObservationError(f"observation {observation.index} brings no image, only what was seen in it; valid: an image")
    return observation.image


def _check_image(image: Image, camera: Camera, where: str) -> None:
    expected = (camera.intrinsics.height, camera.intrinsics.width, 3)
    if image.shape != expected or image.dtype != np.uint8:
        found = f"{image.dtype} {image.shape}"
        raise ObservationError(f"{where}: the image is {found}; valid: uint8 {expected}, as the camera makes them")


def _check_percept(percept: Percept, where: str) -> None:
    length = float(np.linalg.norm(percept.embedding))
    if percept.embedding.ndim != 1 or not math.isclose(length, 1.0, abs_tol=1e-3):
        shape = percept.embedding.shape
        raise ObservationError(f"{where}: the embedding {shape} is {length:.3g} long; valid: a finite vector of unit norm")
    points, descriptors = percept.features.keypoints, percept.features.descriptors
    if len(points) != len(descriptors) or not np.isfinite(points).all():
        found = f"{len(points)} key points and {len(descriptors)} descriptors"
        raise ObservationError(f"{where}: {found}; valid: one descriptor for each key point, and finite places")


def _is_pose(T: Float64[np.ndarray, "..."]) -> bool:
    return T.shape == (4, 4) and bool(is_rigid(T))
