"""Code shared by the readers of recorded runs: their result type, decoding of images, and interpolation of the odometry."""

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Annotated

import cv2
import numpy as np
from annotated_types import Ge, Gt
from jaxtyping import Bool, Float64, UInt8
from scipy.spatial.transform import Rotation, Slerp

from lexis.datasets.camera_tracks import RigTrack
from lexis.datasets.image_header import image_size
from lexis.errors import DatasetError, LexisError, one_line
from lexis.files.reading import FileKind, read_bytes
from lexis.inputs import MAX_POSITION_M, check_camera
from lexis.settings import Settings
from lexis.types import Camera, Image, Poses

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg")
_IMAGE_FILE = FileKind("a PNG or JPEG", 200_000_000, DatasetError)
_COEFFICIENTS = (0, 4, 5, 8, 12, 14)
"""Numbers of coefficients that a distortion model of OpenCV can have."""
_MAX_COEFFICIENT = 1e4


@dataclass(frozen=True)
class DatasetConfig(Settings, place="dataset", error=DatasetError):
    """Settings for reading a dataset: which contents to use, and assumptions where the dataset states nothing."""

    odometry: str | None = None
    """The odometry: a file (TUM), a sensor's folder (EuRoC) or a topic (ROS 2). None: the default name."""
    camera: str | None = None
    """The camera: a file (TUM), a sensor's folder (EuRoC) or the namespace of topics (ROS 2). None: the default name. A list
    of names, separated by commas, makes a rig of several cameras (EuRoC and ROS 2)."""
    max_odometry_gap_s: Annotated[float, Gt(0)] = 0.5
    """Longest gap between odometry poses that is interpolated [s]."""
    rotation_sigma: Annotated[float, Ge(0)] = 0.003
    """Standard deviation to assume for the drift of the orientation after one metre of path, if the dataset has no
    covariances [rad/√m]."""
    translation_sigma: Annotated[float, Ge(0)] = 0.015
    """Standard deviation to assume for the drift of the position after one metre of path, if the dataset has no covariances
    [m/√m]."""

    def cameras(self, usual: str) -> tuple[str, ...]:
        """Return the names of all cameras, or `usual` if none is named; slashes around a name do not count.

        Raises DatasetError for a name that occurs twice.
        """
        names = tuple(name.strip().strip("/") for name in (self.camera or usual).split(","))
        if len(set(names)) < len(names) or not all(names):
            raise DatasetError(f"cameras {self.camera!r}; valid: different names, separated by commas")
        return names


@dataclass(frozen=True, eq=False)
class OdometryTrack:
    """Odometry poses with their own stamps, which may differ from the stamps of the images."""

    source: str
    """File or topic of the odometry, for messages."""
    stamps: Float64[np.ndarray, "n"]
    """Stamps of the poses, ascending [s]."""
    T_O_B: Poses


@dataclass(frozen=True, eq=False)
class Recorded:
    """The contents of a dataset's files, before the odometry is interpolated."""

    seen: RigTrack
    """The images of all cameras."""
    odometry: OdometryTrack
    increment_covariances: Float64[np.ndarray, "n 6 6"] | None
    """Covariances of the odometry's increments from image to image [rad², m²]. None if the dataset states no covariances, or
    states them for other increments, because the odometry has other stamps than the images."""

    @classmethod
    def of(cls, seen: RigTrack, odometry: OdometryTrack, covariances: Float64[np.ndarray, "n 6 6"] | None) -> "Recorded":
        """Return images and odometry, with the covariances of the increments between odometry poses [rad², m²], if any.

        The covariances are kept only if the odometry has the same stamps as the images, because only then are the increments
        between odometry poses the increments between images.
        """
        at_images = covariances is not None and np.array_equal(odometry.stamps, seen.stamps)
        return cls(seen, odometry, covariances if at_images else None)


def odometry_at(track: OdometryTrack, at: Float64[np.ndarray, "n"], max_gap_s: float) -> Poses:
    """Interpolate T_O_B to the stamps `at` of images [s], linearly for positions and by slerp for orientations.

    A pose with exactly the stamp of an image is used unchanged. Raises DatasetError if an image is outside the time of the
    odometry, or within a gap longer than `max_gap_s`.
    """
    stamps, poses = track.stamps, track.T_O_B
    check_poses(track)
    after = np.searchsorted(stamps, at)
    exact = np.take(stamps, after, mode="clip") == at
    before = np.where(exact, after, after - 1)
    outside = (before < 0) | (after >= len(stamps))
    if outside.any():
        image = int(np.flatnonzero(outside)[0])
        found = f"covers {stamps[0]} s to {stamps[-1]} s, but image {image} is at {at[image]} s"
        raise DatasetError(f"{track.source}: {found}; valid: odometry over the time of all images, of the same clock")
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


def check_poses(track: OdometryTrack) -> None:
    """Raise DatasetError unless all position coordinates of the odometry are within +-`MAX_POSITION_M`."""
    far = ~(np.abs(track.T_O_B[:, :3, 3]) <= MAX_POSITION_M).all(axis=1)
    if far.any():
        k = int(np.argmax(far))
        raise DatasetError(
            f"{track.source}: pose {k} at {track.stamps[k]} s lies beyond {MAX_POSITION_M:g} m; valid: positions on Earth"
        )


def check_ascending(where: str, stamps: Float64[np.ndarray, "n"]) -> None:
    """Raise DatasetError unless there is at least one stamp and the stamps ascend."""
    if not len(stamps):
        raise DatasetError(f"{where}: is empty; valid: at least one entry")
    if (np.diff(stamps) <= 0).any():
        k = int(np.flatnonzero(np.diff(stamps) <= 0)[0]) + 1
        raise DatasetError(f"{where}: stamp {stamps[k]} follows {stamps[k - 1]}; valid: ascending stamps")


def image_file(folder: Path, where: str, name: str) -> Path:
    """Return the path of the image `name`, an entry of a dataset's list of images, which is relative to `folder`.

    Raises DatasetError, with the place `where` of the entry, if `name` leads out of `folder`, has no image suffix, or does
    not exist.
    """
    relative = PurePosixPath(name)
    if relative.is_absolute() or ".." in relative.parts or relative.suffix.lower() not in IMAGE_SUFFIXES:
        raise DatasetError(f"{where}: {name!r} is not an image inside the dataset; valid: {', '.join(IMAGE_SUFFIXES)}")
    path = folder / relative
    if not os.path.isfile(path):
        raise DatasetError(f"{where}: there is no file {path}; valid: the path of an image, relative to {folder}")
    return path


def images_in(
    paths: Sequence[Path], camera: Camera, distortion: Float64[np.ndarray, "k"]
) -> Callable[[Bool[np.ndarray, "n"]], Iterator[Image]]:
    """Return the function `CameraTrack.images` of a camera whose images are the files `paths`.

    The function removes the distortion of the images. It raises DatasetError as `read_image` does.
    """
    rectified = rectifier(camera, distortion)

    def images(wanted: Bool[np.ndarray, "n"]) -> Iterator[Image]:
        return (rectified(read_image(paths[i], camera)) for i in np.flatnonzero(wanted).tolist())

    return images


def read_image(path: Path, camera: Camera) -> Image:
    """Read an RGB image from a file. Raises DatasetError if it is unreadable or does not have the camera's size."""
    return decode_image(np.frombuffer(read_bytes(path, _IMAGE_FILE), np.uint8), str(path), camera)


def decode_image(content: UInt8[np.ndarray, "n"], where: str, camera: Camera) -> Image:
    """Decode the bytes of a PNG or JPEG to an RGB image. Raises DatasetError as `read_image` does.

    The size in the header is checked first, because a few bytes can decode to gigabytes of pixels.
    """
    size = image_size(content.tobytes())
    if size is None:
        raise DatasetError(f"{where}: is not a readable PNG or JPEG")
    # Width and height are sorted, because an image may state that it is rotated by 90 degrees; decoding then turns it.
    if sorted(size) != sorted((camera.intrinsics.width, camera.intrinsics.height)):
        raise DatasetError(_size_message(where, size, camera))
    try:
        pixels = cv2.imdecode(content, cv2.IMREAD_COLOR)
    except cv2.error:
        pixels = None
    if pixels is None:
        raise DatasetError(f"{where}: is not a readable PNG or JPEG")
    return check_image_size(np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB), np.uint8), where, camera)


def check_image_size(image: Image, where: str, camera: Camera) -> Image:
    """Return the image unchanged. Raises DatasetError if it does not have the camera's size."""
    height, width = image.shape[:2]
    if (width, height) != (camera.intrinsics.width, camera.intrinsics.height):
        raise DatasetError(_size_message(where, (width, height), camera))
    return image


def _size_message(where: str, size: tuple[int, int], camera: Camera) -> str:
    k = camera.intrinsics
    return f"{where}: is {size[0]}x{size[1]} px; valid: {k.width}x{k.height} px, as in the camera's calibration"


def check_calibration(where: str, camera: Camera, distortion: Float64[np.ndarray, "k"]) -> None:
    """Raise DatasetError unless the camera and the coefficients of its distortion are usable.

    The coefficients must be finite, of plausible size, and as many as a distortion model of OpenCV has.
    """
    try:
        check_camera(camera)
    except LexisError as error:
        raise DatasetError(f"{where}: {error}") from None
    if len(distortion) not in _COEFFICIENTS or not (np.abs(distortion) <= _MAX_COEFFICIENT).all():
        raise DatasetError(
            f"{where}: distortion {one_line(distortion.tolist(), 80)}; "
            f"valid: {', '.join(map(str, _COEFFICIENTS))} finite coefficients, at most {_MAX_COEFFICIENT:g}"
        )


def rectifier(camera: Camera, distortion: Float64[np.ndarray, "k"]) -> Callable[[Image], Image]:
    """Return a function that removes the distortion of images; without distortion, the function changes no image."""
    if not distortion.any():
        return lambda image: image
    size = camera.intrinsics.width, camera.intrinsics.height
    matrix = camera.intrinsics.matrix
    maps = cv2.initUndistortRectifyMap(matrix, distortion, np.eye(3), matrix, size, cv2.CV_16SC2)
    return lambda image: np.asarray(cv2.remap(image, maps[0], maps[1], cv2.INTER_LINEAR), np.uint8)
