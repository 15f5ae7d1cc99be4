"""Recorded runs as EuRoC's micro aerial vehicle datasets lay them out (ASL).

    mav0/cam0/data.csv, data/, sensor.yaml    images by their stamp [ns], pinhole with radial-tangential distortion, T_BS
    mav0/odom0/data.csv, sensor.yaml          the odometry: stamp [ns], position [m], quaternion w x y z; then, optionally,
                                              the 36 numbers of the covariance of its increment since the line before,
                                              rotation first [rad², m²]; T_BS is optional

Any sensor that reports poses in these columns can be the odometry: `vicon0`, or even `state_groundtruth_estimate0`.
"""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from jaxtyping import Float64

from lexis.dataset_files import (
    DatasetConfig,
    Recorded,
    Track,
    check_ascending,
    image_file,
    read_image,
    rectifier,
    usable_covariance,
)
from lexis.errors import DatasetError, LexisError
from lexis.files import numbered_lines
from lexis.inputs import check_camera
from lexis.quaternions import poses_of
from lexis.se3 import inverse
from lexis.types import Camera, Image, Intrinsics, Pose

SENSORS, CAMERA, ODOMETRY = "mav0", "cam0", "odom0"
_WITH_COVARIANCE = 8 + 36


def is_euroc(directory: Path) -> bool:
    """Whether a folder looks like a dataset of this form."""
    return (directory / SENSORS).is_dir()


def read_euroc(directory: Path, config: DatasetConfig) -> Recorded:
    """A dataset of this form. Raises LexisError, naming file and line, where it is incomplete or contradicts itself."""
    folder = directory / SENSORS / (config.camera or CAMERA)
    camera, distortion = _read_camera(folder / "sensor.yaml")
    listed = folder / "data.csv"
    rows = _rows(listed, 2)
    stamps = np.array([_stamp(listed, *row) for row in rows])
    check_ascending(str(listed), stamps)
    paths = [image_file(folder / "data", f"{listed}:{number}", words[1]) for number, words in rows]
    rectified = rectifier(camera, distortion)

    def images() -> Iterator[Image]:
        return (rectified(read_image(path, camera)) for path in paths)

    track, covariances = _read_odometry(directory / SENSORS / (config.odometry or ODOMETRY))
    at_images = covariances is not None and np.array_equal(track.stamps, stamps)
    return Recorded(camera, stamps, images, track, covariances if at_images else None)


def _read_camera(path: Path) -> tuple[Camera, Float64[np.ndarray, "k"]]:
    """The pinhole and its distortion coefficients."""
    data = _read_yaml(path)
    try:
        if data["camera_model"] != "pinhole" or data.get("distortion_model") not in (None, "radial-tangential"):
            raise DatasetError(f"{path}: valid: camera_model pinhole, distortion_model radial-tangential")
        width, height = (int(value) for value in data["resolution"])
        fx, fy, cx, cy = (float(value) for value in data["intrinsics"])
        camera = Camera(Intrinsics(width, height, fx, fy, cx, cy), _extrinsics(data))
        check_camera(camera)
        return camera, np.array([float(value) for value in data.get("distortion_coefficients", ())])
    except LexisError as error:
        raise DatasetError(f"{path}: {error}") from None
    except (KeyError, TypeError, ValueError) as error:
        raise DatasetError(
            f"{path}: {error}; valid: resolution, intrinsics [fu, fv, cu, cv] and T_BS of 16 numbers"
        ) from None


def _read_odometry(folder: Path) -> tuple[Track, Float64[np.ndarray, "n 6 6"] | None]:
    path = folder / "data.csv"
    rows = np.array([_numbers(path, *row) for row in _rows(path, 8)])
    check_ascending(str(path), rows[:, 0])
    T_O_B = poses_of(rows[:, [1, 2, 3, 5, 6, 7, 4]])
    if (folder / "sensor.yaml").exists():
        try:
            T_B_S = _extrinsics(_read_yaml(folder / "sensor.yaml"))
        except (KeyError, TypeError, ValueError) as error:
            raise DatasetError(f"{folder / 'sensor.yaml'}: {error}; valid: T_BS of 16 numbers") from None
        if not np.array_equal(T_B_S, np.eye(4)):
            T_O_B = T_O_B @ inverse(T_B_S)
    covariances = None
    if rows.shape[1] == _WITH_COVARIANCE:
        covariances = rows[:, 8:].reshape(-1, 6, 6)
        if bad := [k for k, matrix in enumerate(covariances) if not usable_covariance(matrix)]:
            raise DatasetError(f"{path}: pose {bad[0]}: valid: a positive semi-definite 6x6 matrix as covariance")
    return Track(str(path), rows[:, 0], T_O_B), covariances


def _rows(path: Path, columns: int) -> list[tuple[int, list[str]]]:
    rows = [(number, [word.strip() for word in line.split(",")]) for number, line in numbered_lines(path)]
    for number, words in rows:
        if len(words) < columns or len(words) != len(rows[0][1]):
            raise DatasetError(f"{path}:{number}: {len(words)} columns; valid: at least {columns}, as many in every line")
    return rows


def _stamp(path: Path, number: int, words: list[str]) -> float:
    if not (words[0].isdecimal() and int(words[0]) < 2**63):
        raise DatasetError(f"{path}:{number}: stamp {words[0][:40]!r}; valid: whole nanoseconds")
    return int(words[0]) / 1e9


def _numbers(path: Path, number: int, words: list[str]) -> list[float]:
    try:
        values = [_stamp(path, number, words), *map(float, words[1:])]
    except ValueError as error:
        raise DatasetError(f"{path}:{number}: {error}") from None
    if not all(map(math.isfinite, values)) or abs(math.hypot(*values[4:8]) - 1.0) > 1e-3:
        raise DatasetError(f"{path}:{number}: valid: finite numbers, columns 5 to 8 a unit quaternion w x y z")
    return values


def _extrinsics(data: Mapping[str, Any]) -> Pose:
    return np.array([float(value) for value in data["T_BS"]["data"]]).reshape(4, 4)


def _read_yaml(path: Path) -> Mapping[str, Any]:
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8").removeprefix("%YAML:1.0"))
    except OSError as error:
        raise DatasetError(f"{path}: cannot be read: {error.strerror}; valid: a sensor's calibration") from None
    except (UnicodeDecodeError, yaml.YAMLError):
        raise DatasetError(f"{path}: is not YAML; valid: a sensor's calibration") from None
    if not isinstance(data, Mapping):
        raise DatasetError(f"{path}: holds no keys; valid: a sensor's calibration")
    return data
