"""The files of a recorded run, each read into what LEXIS uses and checked on the way."""

import math
import os
from pathlib import Path, PurePosixPath

import cv2
import numpy as np
from jaxtyping import Float64
from pydantic import ValidationError
from scipy.spatial.transform import Rotation, Slerp

from lexis.camera_io import CameraData
from lexis.errors import DatasetError, LexisError
from lexis.files import numbered_lines
from lexis.inputs import check_camera
from lexis.tum import read_tum
from lexis.types import Camera, Covariance, Image, Poses

IMAGE_LIST, ODOMETRY, CAMERA, COVARIANCE = "rgb.txt", "odometry.tum", "camera.json", "odometry_covariance.txt"
IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg")


def read_camera(path: Path) -> Camera:
    """The camera of `camera.json`. Raises DatasetError."""
    try:
        camera = CameraData.model_validate_json(path.read_bytes()).camera()
        check_camera(camera)
    except OSError as error:
        raise DatasetError(f"{path}: cannot be read: {error.strerror}; valid: a camera as JSON") from None
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise DatasetError(f"{path}: {'.'.join(map(str, first['loc'])) or 'camera'}: {first['msg']}") from None
    except LexisError as error:
        raise DatasetError(f"{path}: {error}") from None
    return camera


def read_image_list(directory: Path) -> tuple[Float64[np.ndarray, "n"], tuple[Path, ...]]:
    """Stamps [s] and paths of the images that `rgb.txt` lists. Raises DatasetError."""
    path = directory / IMAGE_LIST
    stamps: list[float] = []
    images: list[Path] = []
    for number, line in numbered_lines(path):
        stamp, name = _stamp_and_rest(path, number, line)
        if stamps and stamp <= stamps[-1]:
            raise DatasetError(f"{path}:{number}: stamp {stamp} follows {stamps[-1]}; valid: ascending stamps")
        stamps.append(stamp)
        images.append(_image_path(directory, f"{path}:{number}", name))
    if not images:
        raise DatasetError(f"{path}: lists no image; valid: lines of 'stamp file'")
    return np.array(stamps), tuple(images)


def _image_path(directory: Path, where: str, name: str) -> Path:
    relative = PurePosixPath(name)
    if relative.is_absolute() or ".." in relative.parts or relative.suffix.lower() not in IMAGE_SUFFIXES:
        raise DatasetError(f"{where}: {name!r} is not an image inside the dataset; valid: {', '.join(IMAGE_SUFFIXES)}")
    path = directory / relative
    if not os.path.isfile(path):
        raise DatasetError(f"{where}: there is no file {path}; valid: the name of an image, from the folder of {IMAGE_LIST}")
    return path


def odometry_at(path: Path, at: Float64[np.ndarray, "n"], max_gap_s: float) -> Poses:
    """T_O_B at the images' stamps [s]: straight between positions, at constant rate between orientations.

    Raises LexisError where the odometry does not reach an image, or has a gap of more than `max_gap_s` around one.
    """
    stamps, poses = read_tum(path)
    after = np.searchsorted(stamps, at)
    exact = np.take(stamps, after, mode="clip") == at
    before = np.where(exact, after, after - 1)
    outside = (before < 0) | (after >= len(stamps))
    if outside.any():
        image = int(np.flatnonzero(outside)[0])
        raise DatasetError(f"{path}: covers {stamps[0]} s to {stamps[-1]} s, but image {image} is of {at[image]} s")
    gap = stamps[after] - stamps[before]
    if gap.max() > max_gap_s:
        image = int(gap.argmax())
        raise DatasetError(
            f"{path}: a gap of {gap[image]:.3f} s around image {image} at {at[image]} s; valid: up to {max_gap_s} s"
        )
    if len(stamps) == 1:
        return poses[after]
    result = np.tile(np.eye(4), (len(at), 1, 1))
    result[:, :3, :3] = Slerp(stamps, Rotation.from_matrix(poses[:, :3, :3]))(at).as_matrix()
    result[:, :3, 3] = np.stack([np.interp(at, stamps, poses[:, axis, 3]) for axis in range(3)], axis=1)
    return result


def read_covariances(path: Path, stamps: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "n 6 6"] | None:
    """Covariances of the odometry's increments, one per image; None without the file. Raises DatasetError."""
    if not path.exists():
        return None
    lines = numbered_lines(path)
    if len(lines) != len(stamps):
        raise DatasetError(f"{path}: {len(lines)} covariances; valid: one for each of the {len(stamps)} images")
    return np.array([_covariance(path, *line, stamp) for line, stamp in zip(lines, stamps.tolist(), strict=True)])


def _covariance(path: Path, number: int, line: str, expected: float) -> Covariance:
    stamp, rest = _stamp_and_rest(path, number, line)
    try:
        matrix = np.array([float(word) for word in rest.split()]).reshape(6, 6)
        usable = np.isfinite(matrix).all() and np.allclose(matrix, matrix.T) and np.linalg.eigvalsh(matrix).min() >= -1e-12
    except ValueError:
        usable = False
    if not usable or abs(stamp - expected) > 1e-6:
        raise DatasetError(f"{path}:{number}: valid: the image's stamp {expected} and a positive semi-definite 6x6 matrix")
    return matrix


def _stamp_and_rest(path: Path, number: int, line: str) -> tuple[float, str]:
    first, _, rest = line.strip().partition(" ")
    try:
        stamp = float(first)
    except ValueError:
        stamp = math.nan
    if not math.isfinite(stamp) or not rest.strip():
        raise DatasetError(f"{path}:{number}: {line[:80]!r}; valid: a stamp in seconds, a blank, and what belongs to it")
    return stamp, rest.strip()


def read_image(path: Path, camera: Camera) -> Image:
    """The RGB image of a file. Raises DatasetError where it is unreadable or of another size than the camera's."""
    pixels = cv2.imread(os.fspath(path), cv2.IMREAD_COLOR)
    if pixels is None:
        raise DatasetError(f"{path}: is not a readable PNG or JPEG")
    expected = (camera.intrinsics.height, camera.intrinsics.width)
    if pixels.shape[:2] != expected:
        height, width = pixels.shape[:2]
        raise DatasetError(f"{path}: is {width}x{height} px; the camera of {CAMERA} makes {expected[1]}x{expected[0]} px")
    return np.asarray(cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB), np.uint8)


def write_image(path: Path, image: Image) -> None:
    """Write an RGB image. Raises OSError."""
    if not cv2.imwrite(os.fspath(path), cv2.cvtColor(image, cv2.COLOR_RGB2BGR)):
        raise OSError(None, "the image was not written")
