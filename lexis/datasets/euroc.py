"""Recorded runs in the ASL format of EuRoC's micro aerial vehicle datasets.

    mav0/cam0/data.csv, data/, sensor.yaml    images by their stamp [ns], pinhole with radial-tangential distortion, T_BS;
                                              further cameras of a rig: cam1 and so on, with equal stamps
    mav0/odom0/data.csv                       the odometry: stamp [ns], position [m], quaternion w x y z; then, optionally,
                                              the 36 numbers of the covariance of its increment since the previous line,
                                              rotation first [rad², m²]
    mav0/odom0/sensor.yaml                    optional: T_BS of the odometry; without this file, the odometry is of the body

Any sensor that reports poses in these columns can be used as the odometry, for example `vicon0` or even
`state_groundtruth_estimate0`, whose velocities and biases are ignored. The covariances are used only if the odometry has the
same stamps as the images.
"""

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float64

from lexis.datasets.camera_tracks import CameraTrack, joined
from lexis.datasets.recorded import (
    DatasetConfig,
    OdometryTrack,
    Recorded,
    check_ascending,
    check_calibration,
    image_file,
    images_in,
)
from lexis.errors import DatasetError, one_line
from lexis.files.reading import FileKind, numbered_lines, read_yaml
from lexis.inputs import is_pose, usable_covariances
from lexis.maths.quaternions import UNIT_TOLERANCE, poses_of
from lexis.maths.se3 import adjoint, inverse
from lexis.types import Camera, Intrinsics, Pose

SENSORS, CAMERA, ODOMETRY = "mav0", "cam0", "odom0"
_POSES, _STATES, _WITH_COVARIANCE = 8, 17, 8 + 36
"""Numbers of columns that a file of poses may have: poses alone, EuRoC's ground truth, and poses with covariances."""
_NANOSECONDS = re.compile(r"[0-9]{1,19}")
_DISTORTION_MODELS = ("radial-tangential", "", "~", "null")
"""Supported distortion models: radial-tangential, and the spellings of "no distortion"."""
_CAMERA_FILE = FileKind(
    "a camera's calibration with resolution, intrinsics [fu, fv, cu, cv] and T_BS of 16 numbers", 100_000, DatasetError
)
_SENSOR_FILE = FileKind("a sensor's calibration with T_BS of 16 numbers", 100_000, DatasetError)
_DATA_FILE = FileKind("lines of numbers separated by commas", 200_000_000, DatasetError)


def is_euroc(directory: Path) -> bool:
    """Whether a folder looks like a dataset in EuRoC's ASL format."""
    return (directory / SENSORS).is_dir()


def read_euroc(directory: Path, config: DatasetConfig) -> Recorded:
    """Read a dataset in EuRoC's ASL format. Raises LexisError, with file and line, if it is incomplete or inconsistent."""
    seen = joined([_read_images(directory / SENSORS / name) for name in config.cameras(CAMERA)])
    track, covariances = _read_odometry(directory / SENSORS / (config.odometry or ODOMETRY))
    return Recorded.of(seen, track, covariances)


def _read_images(folder: Path) -> CameraTrack:
    """Read the calibration and the list of images of one camera."""
    camera, distortion = _read_camera(folder / "sensor.yaml")
    listed = folder / "data.csv"
    rows = _rows(listed, 2)
    stamps = np.array([_stamp(listed, *row) for row in rows])
    check_ascending(str(listed), stamps)
    paths = [image_file(folder / "data", f"{listed}:{number}", words[1]) for number, words in rows]
    return CameraTrack(str(listed), camera, stamps, images_in(paths, camera, distortion))


def _read_camera(path: Path) -> tuple[Camera, Float64[np.ndarray, "k"]]:
    """Return the camera and its distortion coefficients."""
    data = read_yaml(path, _CAMERA_FILE)
    if data.get("camera_model") != "pinhole" or data.get("distortion_model", "") not in _DISTORTION_MODELS:
        names = ("camera_model", "distortion_model")
        found = ", ".join(f"{name} {one_line(data.get(name, 'missing'), 40)}" for name in names)
        raise DatasetError(f"{path}: {found}; valid: camera_model pinhole, distortion_model radial-tangential")
    try:
        width, height = map(int, _float_list(_entry(data, "resolution")))
        fx, fy, cx, cy = _float_list(_entry(data, "intrinsics"))
        camera = Camera(Intrinsics(width, height, fx, fy, cx, cy), _extrinsics(data))
        distortion = np.array(_float_list(data.get("distortion_coefficients") or []))
    except (TypeError, ValueError, OverflowError) as error:
        raise _CAMERA_FILE.refusal(path, error) from None
    check_calibration(str(path), camera, distortion)
    return camera, distortion


def _read_odometry(folder: Path) -> tuple[OdometryTrack, Float64[np.ndarray, "n 6 6"] | None]:
    path = folder / "data.csv"
    lines = _rows(path, _POSES)
    if (columns := len(lines[0][1])) not in (_POSES, _STATES, _WITH_COVARIANCE):
        valid = f"{_POSES}, {_STATES} as in EuRoC's ground truth, or {_WITH_COVARIANCE} with the 36 numbers of a covariance"
        raise DatasetError(f"{path}:{lines[0][0]}: {columns} columns; valid: {valid}")
    rows = np.array([_numbers(path, *line) for line in lines])
    check_ascending(str(path), rows[:, 0])
    poses, T_B_S = poses_of(rows[:, [1, 2, 3, 5, 6, 7, 4]]), _sensor_pose(folder)
    is_body = np.array_equal(T_B_S, np.eye(4))
    track = OdometryTrack(str(path), rows[:, 0], poses if is_body else poses @ inverse(T_B_S))
    if columns != _WITH_COVARIANCE:
        return track, None
    covariances = rows[:, 8:].reshape(-1, 6, 6)
    if len(bad := np.flatnonzero(~usable_covariances(covariances))):
        raise DatasetError(
            f"{path}: pose {bad[0]}: its 36 numbers are no covariance; valid: a positive semi-definite 6x6 matrix"
        )
    return track, covariances if is_body else _of_body(covariances, T_B_S)


def _of_body(covariances: Float64[np.ndarray, "n 6 6"], T_B_S: Pose) -> Float64[np.ndarray, "n 6 6"]:
    """Convert covariances of a sensor's increments to those of the body's increments, T_B_S @ increment @ T_S_B."""
    Ad = adjoint(T_B_S)
    result = Ad @ covariances @ Ad.T
    return np.asarray((result + result.swapaxes(1, 2)) / 2.0)  # rounding makes the product slightly asymmetric


def _sensor_pose(folder: Path) -> Pose:
    """Return T_B_S of a sensor that reports poses; without a calibration file, the sensor frame is the body frame."""
    path = folder / "sensor.yaml"
    if not path.exists():
        return np.eye(4)
    sensor = read_yaml(path, _SENSOR_FILE)
    try:
        T_B_S = _extrinsics(sensor)
    except (TypeError, ValueError) as error:
        raise _SENSOR_FILE.refusal(path, error) from None
    if not is_pose(T_B_S):
        raise _SENSOR_FILE.refusal(path, "T_BS is not a rigid motion")
    return T_B_S


def _rows(path: Path, columns: int) -> list[tuple[int, list[str]]]:
    rows = [(number, [word.strip() for word in line.split(",")]) for number, line in numbered_lines(path, _DATA_FILE)]
    if not rows:
        raise DatasetError(f"{path}: is empty; valid: at least one line of {_DATA_FILE.valid}")
    for number, words in rows:
        if len(words) < columns or len(words) != len(rows[0][1]):
            raise DatasetError(f"{path}:{number}: {len(words)} columns; valid: at least {columns}, the same in every line")
    return rows


def _stamp(path: Path, number: int, words: list[str]) -> float:
    if not (_NANOSECONDS.fullmatch(words[0]) and int(words[0]) < 2**63):
        raise DatasetError(f"{path}:{number}: stamp {words[0][:40]!r}; valid: whole nanoseconds")
    return int(words[0]) / 1e9


def _numbers(path: Path, number: int, words: list[str]) -> list[float]:
    stamp = _stamp(path, number, words)
    try:
        values = [stamp, *map(float, words[1:])]
    except ValueError as error:
        raise DatasetError(f"{path}:{number}: {one_line(error, 80)}; valid: numbers separated by commas") from None
    if not all(map(math.isfinite, values)) or abs(math.hypot(*values[4:8]) - 1.0) > UNIT_TOLERANCE:
        found = f"{one_line(','.join(words[1:8]), 80)} is no pose"
        raise DatasetError(f"{path}:{number}: {found}; valid: finite numbers, columns 5 to 8 a unit quaternion w x y z")
    return values


def _extrinsics(data: Mapping[str, Any]) -> Pose:
    """Return T_BS of a calibration. Raises TypeError or ValueError if there is none or it is not 16 numbers."""
    return np.array(_float_list(_entry(_entry(data, "T_BS"), "data"))).reshape(4, 4)


def _entry(data: object, name: str) -> object:
    """Return an entry of a mapping. Raises TypeError for anything but a mapping, and ValueError without the entry."""
    if not isinstance(data, Mapping):
        raise TypeError(f"{one_line(data, 40)} has no entry {name}")
    if name not in data:
        raise ValueError(f"there is no {name}")
    return data[name]


def _float_list(values: object) -> list[float]:
    """Convert a list of texts to numbers. Raises TypeError or ValueError for anything else."""
    if not isinstance(values, list):
        raise TypeError(f"{one_line(values, 40)} is not a list of numbers")
    return [float(value) for value in values]
