"""Recorded runs in the format of the TUM RGB-D benchmark.

    rgb.txt                    lines of "stamp file"; # begins a comment
    odometry.tum               lines of "stamp tx ty tz qx qy qz qw": T_O_B, at any rate over the time of the images
    camera.json                width, height, fx, fy, cx, cy [px] and T_B_C, row by row; optionally distortion, the
                               radial-tangential coefficients k1, k2, p1, p2, by which the images are undistorted
    odometry_covariance.txt    optional: per image, "stamp" and the 36 numbers of the covariance of the odometry's increment
                               since the previous image, rotation first [rad², m²]

Images are 8-bit PNG or JPEG.
"""

import math
from collections.abc import Iterable, Sequence
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float64

from lexis.datasets.camera_tracks import CameraTrack, joined
from lexis.datasets.recorded import DatasetConfig, OdometryTrack, Recorded, check_calibration, image_file, images_in
from lexis.errors import DatasetError
from lexis.files.camera import CameraData
from lexis.files.reading import FileKind, numbered_lines, read_model
from lexis.files.replace import replaced_folder
from lexis.files.tum_trajectory import read_tum
from lexis.inputs import pixels, usable_covariances
from lexis.maths.quaternions import pose_rows
from lexis.types import Camera, Covariance, Observation

IMAGE_LIST, ODOMETRY, CAMERA, COVARIANCE = "rgb.txt", "odometry.tum", "camera.json", "odometry_covariance.txt"
_CAMERA_FILE = FileKind("a camera as JSON", 1_000_000, DatasetError, unusable="no camera")
_LIST_FILE = FileKind("lines of 'stamp file'", 200_000_000, DatasetError)
_COVARIANCE_FILE = FileKind("lines of a stamp and 36 numbers", 200_000_000, DatasetError)


def read_tum_dataset(directory: Path, config: DatasetConfig) -> Recorded:
    """Read a dataset in TUM RGB-D format. Raises LexisError, with file and line, if it is incomplete or inconsistent."""
    camera, distortion = _read_camera(directory / (config.camera or CAMERA))
    stamps, paths = _read_image_list(directory)
    odometry = directory / (config.odometry or ODOMETRY)
    seen = joined([CameraTrack(str(directory / IMAGE_LIST), camera, stamps, images_in(paths, camera, distortion))])
    track = OdometryTrack(str(odometry), *read_tum(odometry))
    # The file of covariances belongs to the default odometry and describes no other odometry.
    covariances = _read_covariances(directory / COVARIANCE, stamps) if config.odometry in (None, ODOMETRY) else None
    return Recorded(seen, track, covariances)


def write_dataset(directory: Path, camera: Camera, observations: Iterable[Observation]) -> None:
    """Write observations as a dataset with PNG images; the folder appears complete or not at all. Raises LexisError.

    The format holds one camera, so only the images of the first camera are written.
    """
    with replaced_folder(directory, IMAGE_LIST) as folder:
        (folder / "rgb").mkdir()
        write_camera(folder / CAMERA, camera)
        with (
            open(folder / IMAGE_LIST, "w", encoding="utf-8") as images,
            open(folder / ODOMETRY, "w", encoding="utf-8") as odometry,
            open(folder / COVARIANCE, "w", encoding="utf-8") as covariances,
        ):
            images.write("# stamp [s], file\n")
            covariances.write("# stamp [s], 6x6 row by row\n")
            for i, observation in enumerate(observations):
                stamp, name = f"{observation.stamp:.6f}", f"rgb/{i:06d}.png"
                (folder / name).write_bytes(cv2.imencode(".png", pixels(observation)[0][..., ::-1])[1].tobytes())
                images.write(f"{stamp} {name}\n")
                odometry.write(odometry_line(stamp, observation))
                covariances.write(covariance_line(stamp, observation))


class _LensCameraData(CameraData):
    """The content of a camera file: a camera, and the distortion of its images."""

    distortion: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    """Radial-tangential coefficients k1, k2, p1, p2."""


def write_camera(path: Path, camera: Camera, distortion: Sequence[float] = ()) -> None:
    """Write a camera as JSON, with the distortion of its images if there is any. Raises OSError."""
    data = CameraData.of(camera)
    if any(distortion):
        data = _LensCameraData.model_validate({**data.model_dump(), "distortion": distortion})
    path.write_text(data.model_dump_json(indent=1) + "\n", encoding="utf-8")


def odometry_line(stamp: str, observation: Observation) -> str:
    """Return the observation's line in the odometry file, with all digits of the numbers; it begins with `stamp` [s]."""
    return f"{stamp} {' '.join(map(repr, pose_rows(observation.T_O_B[None])[0].tolist()))}\n"


def covariance_line(stamp: str, observation: Observation) -> str:
    """Return the observation's line in the covariance file, with all digits of the numbers; it begins with `stamp` [s]."""
    return f"{stamp} {' '.join(map(repr, observation.increment_covariance.ravel().tolist()))}\n"


def _read_camera(path: Path) -> tuple[Camera, Float64[np.ndarray, "4"]]:
    data = read_model(path, _CAMERA_FILE, _LensCameraData)
    camera, distortion = data.camera(), np.array(data.distortion)
    check_calibration(str(path), camera, distortion)
    return camera, distortion


def _read_image_list(directory: Path) -> tuple[Float64[np.ndarray, "n"], tuple[Path, ...]]:
    """Stamps [s] and paths of the images that `rgb.txt` lists."""
    path = directory / IMAGE_LIST
    stamps: list[float] = []
    images: list[Path] = []
    for number, line in numbered_lines(path, _LIST_FILE):
        stamp, name = _stamp_and_rest(path, number, line)
        if stamps and stamp <= stamps[-1]:
            raise DatasetError(f"{path}:{number}: stamp {stamp} follows {stamps[-1]}; valid: ascending stamps")
        stamps.append(stamp)
        images.append(image_file(directory, f"{path}:{number}", name))
    if not images:
        raise DatasetError(f"{path}: lists no image; valid: lines of 'stamp file'")
    return np.array(stamps), tuple(images)


def _read_covariances(path: Path, stamps: Float64[np.ndarray, "n"]) -> Float64[np.ndarray, "n 6 6"] | None:
    """Covariances of the odometry's increments, one per image; None if the file does not exist."""
    if not path.exists():
        return None
    lines = list(numbered_lines(path, _COVARIANCE_FILE))
    if len(lines) != len(stamps):
        raise DatasetError(f"{path}: {len(lines)} covariances; valid: one for each of the {len(stamps)} images")
    return np.array([_covariance(path, *line, stamp) for line, stamp in zip(lines, stamps.tolist(), strict=True)])


def _covariance(path: Path, number: int, line: str, expected: float) -> Covariance:
    stamp, rest = _stamp_and_rest(path, number, line)
    try:
        matrix = np.array([float(word) for word in rest.split()]).reshape(6, 6)
        usable = bool(usable_covariances(matrix)) and abs(stamp - expected) <= 1e-6
    except ValueError:
        usable = False
    if not usable:
        found = "its stamp is not that of the image, or it is no covariance"
        valid = f"the image's stamp {expected} and a positive semi-definite 6x6 matrix"
        raise DatasetError(f"{path}:{number}: {found}; valid: {valid}")
    return matrix


def _stamp_and_rest(path: Path, number: int, line: str) -> tuple[float, str]:
    first, _, rest = line.strip().partition(" ")
    try:
        stamp = float(first)
    except ValueError:
        stamp = math.nan
    if not math.isfinite(stamp) or not rest.strip():
        raise DatasetError(f"{path}:{number}: {line[:80]!r}; valid: a stamp in seconds, a blank, and its data")
    return stamp, rest.strip()
