"""What the readers of recorded runs share: what they give, images decoded and checked, odometry at the images' stamps."""

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import cv2
import numpy as np
from jaxtyping import Float64, UInt8
from scipy.spatial.transform import Rotation, Slerp

from lexis.datasets.image_header import image_size
from lexis.errors import DatasetError, one_line
from lexis.files.reading import FileKind, read_bytes
from lexis.inputs import MAX_POSITION_M
from lexis.types import Camera, Image, Poses

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg")
_IMAGE_FILE = FileKind("a PNG or JPEG", 200_000_000, DatasetError)
_COEFFICIENTS = (0, 4, 5, 8, 12, 14)
"""How many coefficients the models of OpenCV have."""
_MAX_COEFFICIENT = 1e4


@dataclass(frozen=True)
class DatasetConfig:
    """What a dataset leaves unsaid, or leaves to choose."""

    odometry: str | None = None
    """Which odometry: a file (TUM), a sensor's folder (EuRoC) or a topic (ROS 2). None: where LEXIS-sim writes it."""
    camera: str | None = None
    """Which camera, where there are several: a sensor's folder or the namespace of topics. None: cam0."""
    max_odometry_gap_s: float = 0.5
    """Longest time over which the odometry is interpolated to an image's stamp [s]."""
    rotation_sigma: float = 0.003
    """Without covariances: drift of orientation per square root of path [rad/√m]."""
    translation_sigma: float = 0.015
    """Without covariances: drift of position per square root of path [m/√m]."""


@dataclass(frozen=True, eq=False)
class Track:
    """An odometry at its own stamps."""

    source: str
    """File or topic, for messages."""
    stamps: Float64[np.ndarray, "n"]
    """Ascending [s]."""
    T_O_B: Poses


@dataclass(frozen=True, eq=False)
class Recorded:
    """A dataset as its files have it."""

    camera: Camera
    stamps: Float64[np.ndarray, "n"]
    """Of the images, ascending [s]."""
    images: Callable[[], Iterator[Image]]
    """All of them in that order, one at a time. Raises DatasetError where one is unreadable or of another size."""
    odometry: Track
    increment_covariances: Float64[np.ndarray, "n 6 6"] | None
    """Of the odometry's error since the image before; None where the dataset does not say."""


def odometry_at(track: Track, at: Float64[np.ndarray, "n"], max_gap_s: float) -> Poses:
    """T_O_B at the images' stamps [s]: straight between positions, at constant rate between orientations.

    A pose with exactly an image's stamp is taken as it is. Raises DatasetError where the odometry does not reach an image,
    or has a gap of more than `max_gap_s` around one.
    """
    stamps, poses = track.stamps, track.T_O_B
    check_poses(track)
    after = np.searchsorted(stamps, at)
    exact = np.take(stamps, after, mode="clip") == at
    before = np.where(exact, after, after - 1)
    outside = (before < 0) | (after >= len(stamps))
    if outside.any():
        image = int(np.flatnonzero(outside)[0])
        raise DatasetError(f"{track.source}: covers {stamps[0]} s to {stamps[-1]} s, but image {image} is of {at[image]} s")
    gap = stamps[after] - stamps[before]
    if gap.max() > max_gap_s:
        image = int(gap.argmax())
        raise DatasetError(
            f"{track.source}: a gap of {gap[image]:.3f} s around image {image} at {at[image]} s; valid: up to {max_gap_s} s"
        )
    result = poses[after]
    if not exact.all():
        between = at[~exact]
        result[~exact, :3, :3] = Slerp(stamps, Rotation.from_matrix(poses[:, :3, :3]))(between).as_matrix()
        result[~exact, :3, 3] = np.stack([np.interp(between, stamps, poses[:, axis, 3]) for axis in range(3)], axis=1)
    return result


def check_poses(track: Track) -> None:
    """Raise DatasetError unless all poses of an odometry lie at places that can be on Earth."""
    far = ~(np.abs(track.T_O_B[:, :3, 3]) <= MAX_POSITION_M).all(axis=1)
    if far.any():
        k = int(np.argmax(far))
        raise DatasetError(
            f"{track.source}: pose {k} at {track.stamps[k]} s lies beyond {MAX_POSITION_M:g} m; valid: places on Earth"
        )


def check_ascending(where: str, stamps: Float64[np.ndarray, "n"]) -> None:
    """Raise DatasetError unless there are stamps and they ascend."""
    if not len(stamps):
        raise DatasetError(f"{where}: is empty; valid: at least one entry")
    if (np.diff(stamps) <= 0).any():
        k = int(np.flatnonzero(np.diff(stamps) <= 0)[0]) + 1
        raise DatasetError(f"{where}: stamp {stamps[k]} follows {stamps[k - 1]}; valid: ascending stamps")


def image_file(folder: Path, where: str, name: str) -> Path:
    """The image that a list names, seen from `folder`. Raises DatasetError unless it is a file inside."""
    relative = PurePosixPath(name)
    if relative.is_absolute() or ".." in relative.parts or relative.suffix.lower() not in IMAGE_SUFFIXES:
        raise DatasetError(f"{where}: {name!r} is not an image inside the dataset; valid: {', '.join(IMAGE_SUFFIXES)}")
    path = folder / relative
    if not os.path.isfile(path):
        raise DatasetError(f"{where}: there is no file {path}; valid: the name of an image, from its list's folder")
    return path


def read_image(path: Path, camera: Camera) -> Image:
    """The RGB image of a file. Raises DatasetError where it is unreadable or of another size than the camera's."""
    return decode_image(np.frombuffer(read_bytes(path, _IMAGE_FILE), np.uint8), str(path), camera)


def decode_image(content: UInt8[np.ndarray, "n"], where: str, camera: Camera) -> Image:
    """The RGB image of the bytes of a PNG or JPEG. Raises DatasetError as `read_image` does.

    The size that the content states is looked at first: a few bytes can state gigabytes of pixels.
    """
    size = image_size(content.tobytes())
    if size is None:
        raise DatasetError(f"{where}: is not a readable PNG or JPEG")
    # Sorted, because an image may say that it lies on its side, and is then turned when it is decoded.
    if sorted(size) != sorted((camera.intrinsics.width, camera.intrinsics.height)):
        raise DatasetError(_misfit(where, size, camera))
    try:
        pixels = cv2.imdecode(content, cv2.IMREAD_COLOR)
    except cv2.error:
        pixels = None
    if pixels is None:
        raise DatasetError(f"{where}: is not a readable PNG or JPEG")
    return fitting(np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB), np.uint8), where, camera)


def fitting(image: Image, where: str, camera: Camera) -> Image:
    """The image itself. Raises DatasetError where it is of another size than the camera's."""
    height, width = image.shape[:2]
    if (width, height) != (camera.intrinsics.width, camera.intrinsics.height):
        raise DatasetError(_misfit(where, (width, height), camera))
    return image


def _misfit(where: str, size: tuple[int, int], camera: Camera) -> str:
    k = camera.intrinsics
    return f"{where}: is {size[0]}x{size[1]} px; the calibrated camera makes {k.width}x{k.height} px"


def check_distortion(where: str, distortion: Float64[np.ndarray, "k"]) -> None:
    """Raise DatasetError unless the coefficients are none, or as many as OpenCV has models for, and plausible."""
    if len(distortion) not in _COEFFICIENTS or not (np.abs(distortion) <= _MAX_COEFFICIENT).all():
        raise DatasetError(
            f"{where}: distortion {one_line(distortion.tolist(), 80)}; "
            f"valid: {', '.join(map(str, _COEFFICIENTS))} finite coefficients, at most {_MAX_COEFFICIENT:g}"
        )


def rectifier(camera: Camera, distortion: Float64[np.ndarray, "k"]) -> Callable[[Image], Image]:
    """Takes the radial-tangential distortion out of images; without distortion it leaves every bit alone."""
    if not distortion.any():
        return lambda image: image
    size = camera.intrinsics.width, camera.intrinsics.height
    matrix = camera.intrinsics.matrix
    maps = cv2.initUndistortRectifyMap(matrix, distortion, np.eye(3), matrix, size, cv2.CV_16SC2)
    return lambda image: np.asarray(cv2.remap(image, maps[0], maps[1], cv2.INTER_LINEAR), np.uint8)
