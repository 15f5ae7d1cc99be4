"""Checks of everything that users of LEXIS pass to it.

The checks are made once, where the data come in, so that the stages need no checks of their own.
"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from numbers import Integral, Real
from typing import TypeGuard

import numpy as np
from jaxtyping import Bool, Float, Float64, Shaped

from lexis.errors import LexisError, ObservationError, one_line
from lexis.maths.se3 import is_rigid
from lexis.types import DESCRIPTOR_BYTES, Camera, Image, Observation, Percept

MAX_ROOM_NAMES = 1000
"""Largest number of room names in a vocabulary."""
MAX_NAME_LENGTH = 200
"""Largest length of a room name, in characters."""

MAX_INDEX = 2**62
"""Largest index of an observation. Maps store indices as 64-bit integers."""
MAX_POSITION_M = 1e8
"""Largest coordinate of a position [m]. Every place on Earth fits, and squares and cubes of coordinates stay accurate."""
MAX_STAMP_S = 1e12
"""Largest stamp of an observation [s]. No clock shows a later time, and a float still resolves a millisecond there."""
MAX_VARIANCE = 1e12
"""Largest entry of a pose covariance [rad², m²]; it stands for an error of a thousand kilometres."""
_ROUNDING = 1e-9
"""Tolerance for rounding errors in a covariance (asymmetry, negative eigenvalues), as a share of the largest entry."""
MAX_PIXELS = 50_000_000
"""Largest number of pixels in an image."""
MAX_CAMERAS = 16
"""Largest number of cameras of a rig."""
MIN_FOCAL_PX, MAX_FOCAL_PX = 1e-3, 1e6
"""Bounds of focal lengths [px]; the upper one also bounds the coordinates of principal points and key points."""
NORM_TOLERANCE = 1e-3
"""Largest deviation of an embedding's norm from 1."""

_RIGID = "valid: 4x4 with an orthonormal, right-handed rotation and 0 0 0 1 as last row"


def check_camera(camera: Camera) -> None:
    """Raise LexisError unless the intrinsics are within their bounds and ``T_B_C`` is a rigid motion, in all of the rig."""
    k = camera.intrinsics
    sizes, lengths = (k.width, k.height), (k.fx, k.fy, k.cx, k.cy)
    if not all(isinstance(size, Integral) for size in sizes) or not all(isinstance(length, Real) for length in lengths):
        raise LexisError(f"intrinsics {k} are unusable; valid: whole numbers as width and height, numbers as fx, fy, cx, cy")
    finite = all(abs(value) <= MAX_FOCAL_PX for value in lengths)
    if not finite or min(k.width, k.height) < 1 or k.width * k.height > MAX_PIXELS or min(k.fx, k.fy) < MIN_FOCAL_PX:
        raise LexisError(
            f"intrinsics {k} are unusable; valid: width, height >= 1 px, at most {MAX_PIXELS // 10**6} megapixels, "
            f"fx, fy > 0 px, and fx, fy, cx, cy of at most {MAX_FOCAL_PX:g} px"
        )
    _check_pose(camera.T_B_C, "T_B_C of the camera", LexisError)
    if len(camera.others) >= MAX_CAMERAS or any(other.others for other in camera.others):
        raise LexisError(
            f"a rig of {len(camera.rig)} cameras, or one whose further cameras have others themselves; "
            f"valid: up to {MAX_CAMERAS} cameras, with `others` at the first camera alone"
        )
    for other in camera.others:
        check_camera(other)


def check_room_names(names: object) -> None:
    """Raise LexisError unless there are 1 to `MAX_ROOM_NAMES` unique names, all of them printable and short enough.

    A room is looked up without regard to case and outer blanks. Names may therefore not differ in case alone, and may not
    begin or end with a blank.
    """
    if isinstance(names, str):
        raise LexisError(f"room names are a single string {names!r}; valid: a sequence of names, such as ({names!r},)")
    if not isinstance(names, Sequence):
        found = f"room names are {type_of(names)}"
        raise LexisError(f"{found}; valid: a sequence of names, because labels are indices into them")
    if others := [name for name in names if not isinstance(name, str)]:
        raise LexisError(f"the room name {others[0]!r:.80} is no text; valid: texts, such as 'kitchen'")
    if not 1 <= len(names) <= MAX_ROOM_NAMES:
        raise LexisError(f"{len(names)} room names; valid: 1 to {MAX_ROOM_NAMES}")
    unusable = [name[:80] for name in names if not (name.strip() and name.isprintable() and len(name) <= MAX_NAME_LENGTH)]
    if unusable:
        raise LexisError(
            f"room names {unusable} are unusable; valid: names of printable characters, not blank, up to {MAX_NAME_LENGTH}"
        )
    padded = [name for name in names if name != name.strip()]
    if padded:
        raise LexisError(f"room names {padded} begin or end with a blank; valid: names without blanks at their ends")
    count = Counter(name.lower() for name in names)
    twice = sorted(name for name, times in count.items() if times > 1)
    if twice:
        raise LexisError(f"room names {twice} occur more than once; valid: unique names, ignoring case")


def check_observation(
    observation: Observation, camera: Camera, previous: Observation | None, embedding_size: int | None = None
) -> None:
    """Raise ObservationError unless images, pose and covariance are usable and the stamp is later than the previous one.

    No later stage fails on an observation that passes these checks. `embedding_size` is the length of the encoder's
    embeddings; the embedding of a percept must have the same length.
    """
    where = f"observation {observation.index!r:.40}"
    if not isinstance(observation.index, int | np.integer):
        raise ObservationError(f"{where}: the index is no whole number; valid: a whole number up to {MAX_INDEX}")
    if abs(int(observation.index)) > MAX_INDEX:
        raise ObservationError(f"{where}: the index is too large; valid: a whole number up to {MAX_INDEX}")
    images = (observation.image, *observation.others)
    if len(images) != len(camera.rig):
        raise ObservationError(
            f"{where}: has the images of {len(images)} cameras; valid: of {len(camera.rig)}, one for each camera of the "
            "rig, in `image` and `others`"
        )
    for image, taken_by in zip(images, camera.rig, strict=True):
        if isinstance(image, Percept):
            _check_percept(image, embedding_size, where)
        else:
            _check_image(image, taken_by, where)
    _check_pose(observation.T_O_B, f"{where}: T_O_B", ObservationError)
    _check_covariance(observation.increment_covariance, where)
    _check_stamp(observation, where)
    if previous is not None and observation.stamp <= previous.stamp:
        raise ObservationError(
            f"{where}: stamp {observation.stamp} s is not after {previous.stamp} s of the previous; valid: ascending stamps"
        )


def with_copied_geometry(observation: Observation) -> Observation:
    """Return the observation with copies of its pose, covariance and points, in double precision.

    Its index and its stamp become numbers of Python, because JSON knows no numbers of numpy.

    The copies are needed because the caller may reuse the original arrays. Images are not copied: LEXIS reads no pixel after
    the observation is processed. It keeps the observations of a few recent frames with their images, which the caller may
    overwrite (`lexis.keyframe_window`).
    """
    T_O_B, covariance = observation.T_O_B.astype(np.float64), observation.increment_covariance.astype(np.float64)
    index, stamp = int(observation.index), float(observation.stamp)
    return replace(observation, index=index, stamp=stamp, T_O_B=T_O_B, increment_covariance=covariance).with_images(
        replace(image, points=image.points.copy()) if isinstance(image, Percept) else image for image in observation.images
    )


def is_pose(T: object) -> bool:
    """Whether an object is a 4x4 array that holds a rigid motion with coordinates up to `MAX_POSITION_M`."""
    if not _is_numbers(T, (4, 4)):
        return False
    return bool(is_rigid(T.astype(np.float64))) and bool(np.abs(T[:3, 3]).max() <= MAX_POSITION_M)


def usable_covariances(matrices: Float64[np.ndarray, "*batch 6 6"]) -> Bool[np.ndarray, "*batch"]:
    """Whether each matrix is symmetric and positive semi-definite up to rounding, with entries up to `MAX_VARIANCE`."""
    largest = np.abs(matrices).max(axis=(-1, -2))
    bounded = largest <= MAX_VARIANCE
    matrices = np.where(bounded[..., None, None], matrices, 0.0)
    rounding = _ROUNDING * np.where(bounded, largest, 0.0)
    symmetric = np.abs(matrices - np.swapaxes(matrices, -1, -2)).max(axis=(-1, -2)) <= rounding
    return np.asarray(bounded & symmetric & (np.linalg.eigvalsh(matrices).min(axis=-1) >= -rounding))


def is_invertible(covariances: Float64[np.ndarray, "*batch 6 6"]) -> Bool[np.ndarray, "*batch"]:
    """Whether each covariance is positive definite, so that errors can be weighted by its inverse."""
    return np.asarray(np.linalg.eigvalsh(covariances).min(axis=-1) > 0.0)


def pixels(observation: Observation) -> tuple[Image, ...]:
    """Return the images of all cameras. Raises ObservationError if the observation holds percepts instead."""
    images = tuple(image for image in observation.images if not isinstance(image, Percept))
    if len(images) < len(observation.images):
        raise ObservationError(f"observation {observation.index} has a percept but no image; valid: an image")
    return images


def type_of(value: object) -> str:
    """The type of a value or, for an array, the type of its numbers and its shape, as text for messages."""
    if isinstance(value, np.ndarray) and not isinstance(value, np.ma.MaskedArray):
        return f"{value.dtype} {value.shape}"
    return f"a {type(value).__name__}"


def _is_numbers(value: object, shape: tuple[int, ...]) -> TypeGuard[np.ndarray]:
    """Whether an object is an array of integers or floats with the given shape."""
    return isinstance(value, np.ndarray) and value.shape == shape and value.dtype.kind in "fi"


def _check_pose(T: object, what: str, error: type[LexisError]) -> None:
    if not _is_numbers(T, (4, 4)):
        raise error(f"{what} is {type_of(T)}; valid: a 4x4 array of numbers")
    if not is_pose(T):
        raise error(f"{what} is not a rigid motion: {_as_text(T)}; {_RIGID}")


def _check_stamp(observation: Observation, where: str) -> None:
    stamp: object = observation.stamp
    if isinstance(stamp, np.integer | np.floating):
        stamp = stamp.item()  # the lowest number of numpy's has no absolute value there; durations do not become numbers
    if not isinstance(stamp, int | float):
        raise ObservationError(f"{where}: stamp {_as_text(stamp)} is no number; valid: a time in seconds")
    if not abs(stamp) < math.inf:
        raise ObservationError(f"{where}: stamp {_as_text(stamp)} s is not finite; valid: a time up to {MAX_STAMP_S:g} s")
    if abs(stamp) > MAX_STAMP_S:
        raise ObservationError(f"{where}: stamp {_as_text(stamp)} s is too large; valid: a time up to {MAX_STAMP_S:g} s")


def _check_covariance(covariance: object, where: str) -> None:
    if not _is_numbers(covariance, (6, 6)):
        raise ObservationError(f"{where}: increment_covariance is {type_of(covariance)}; valid: a 6x6 array of numbers")
    if not usable_covariances(covariance.astype(np.float64)):
        raise ObservationError(
            f"{where}: increment_covariance is not finite, symmetric and without negative eigenvalues; "
            f"valid: a covariance with values up to {MAX_VARIANCE:g}"
        )


def _check_image(image: object, camera: Camera, where: str) -> None:
    expected = (camera.intrinsics.height, camera.intrinsics.width, 3)
    if not isinstance(image, np.ndarray) or image.shape != expected or image.dtype != np.uint8:
        raise ObservationError(f"{where}: the image is {type_of(image)}; valid: uint8 {expected}, the camera's size")


def wrong_norm(embedding: Shaped[np.ndarray, "d"]) -> float | None:
    """Return the norm of an embedding that has no unit norm; None if it has."""
    norm = float(np.linalg.norm(embedding.astype(np.float64)))
    return None if math.isclose(norm, 1.0, abs_tol=NORM_TOLERANCE) else norm


def _check_percept(percept: Percept, size: int | None, where: str) -> None:
    embedding = percept.embedding
    if not isinstance(embedding, np.ndarray) or embedding.dtype.kind != "f" or embedding.ndim != 1:
        raise ObservationError(f"{where}: the embedding is {type_of(embedding)}; valid: float32 (d,)")
    if (norm := wrong_norm(embedding)) is not None:
        shape = embedding.shape
        raise ObservationError(f"{where}: the embedding {shape} has norm {norm:.3g}; valid: a finite vector of unit norm")
    if size is not None and len(embedding) != size:
        raise ObservationError(f"{where}: the embedding has {len(embedding)} numbers; valid: {size}, as the encoder's")
    points, descriptors = percept.features.keypoints, percept.features.descriptors
    if not (_is_rows(points, 2, "f4", "f8") and _is_rows(descriptors, DESCRIPTOR_BYTES, "u1")):
        found = f"key points are {type_of(points)} and descriptors {type_of(descriptors)}"
        raise ObservationError(f"{where}: {found}; valid: float32 (n, 2) and uint8 (n, {DESCRIPTOR_BYTES})")
    if len(points) != len(descriptors):
        found = f"{len(points)} key points and {len(descriptors)} descriptors"
        raise ObservationError(f"{where}: {found}; valid: one descriptor per key point")
    if not _is_rows(percept.points, 3, "f8"):
        raise ObservationError(f"{where}: points are {type_of(percept.points)}; valid: float64 (m, 3)")
    _check_coordinates(points, f"{where}: a key point", MAX_FOCAL_PX, "px")
    _check_coordinates(percept.points, f"{where}: a point", MAX_POSITION_M, "m")


def _check_coordinates(points: Float[np.ndarray, "n d"], whose: str, most: float, unit: str) -> None:
    beyond = points[~(np.abs(points) <= most)]
    if len(beyond):
        found = f"{whose} has the coordinate {beyond[0]:g} {unit}"
        raise ObservationError(f"{found}; valid: finite positions up to {most:g} {unit}")


def _is_rows(array: object, columns: int, *dtypes: str) -> bool:
    return isinstance(array, np.ndarray) and array.ndim == 2 and array.shape[1] == columns and array.dtype in dtypes


def _as_text(value: object) -> str:
    """A value or an array as one line of text, for messages."""
    return one_line(value.tolist() if isinstance(value, np.ndarray) else value)
