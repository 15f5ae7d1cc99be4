"""Writes runs in the ASL folder layout of EuRoC: stereo images, 200 Hz IMU, true states, and odometry as a sensor.

Body and IMU share one frame, so the `T_BS` of every camera equals `T_B_C`.
"""

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float64

from lexis.datasets.euroc import ODOMETRY, SENSORS
from lexis.maths.quaternions import pose_rows
from lexis.types import Camera
from sim.odometry.imu import ImuConfig
from sim.record.image_names import unused
from sim.record.settings import write_settings
from sim.record.take import RecordedFrame, Take
from sim.render.image_files import SUFFIXES, encoded

IMAGE_COLUMNS = ("#timestamp [ns]", "filename")
IMU_COLUMNS = (
    "#timestamp [ns]",
    *(f"w_RS_S_{axis} [rad s^-1]" for axis in "xyz"),
    *(f"a_RS_S_{axis} [m s^-2]" for axis in "xyz"),
)
POSE_COLUMNS = (*(f"p_RS_R_{axis} [m]" for axis in "xyz"), *(f"q_RS_{axis} []" for axis in "wxyz"))
STATE_COLUMNS = (
    "#timestamp",
    *(f" {column}" for column in POSE_COLUMNS),
    *(f" v_RS_R_{axis} [m s^-1]" for axis in "xyz"),
    *(f" b_w_RS_S_{axis} [rad s^-1]" for axis in "xyz"),
    *(f" b_a_RS_S_{axis} [m s^-2]" for axis in "xyz"),
)
ODOMETRY_COLUMNS = ("#timestamp [ns]", *POSE_COLUMNS, *(f"cov_{row}{column}" for row in range(6) for column in range(6)))


def write_euroc(folder: Path, take: Take, frames: Iterable[RecordedFrame], images: str) -> None:
    """Write a take (the sensor data of one walk) to `folder`. Raises OSError.

    The folder gets the data in `mav0`, a list of image stamps for ORB-SLAM3, and settings files for other SLAM systems.
    `images` is the kind of images, png or jpg.
    """
    sensors = folder / SENSORS
    sensors.mkdir()
    (sensors / "body.yaml").write_text("comment: simulated by LEXIS-sim; the body frame is that of imu0\n", encoding="utf-8")
    write_settings(folder / "settings", take)
    _write_imu(sensors / "imu0", take)
    if take.with_truth:
        _write_states(sensors / "state_groundtruth_estimate0", take)
    _write_frames(folder, take, frames, SUFFIXES[images])


def _write_frames(folder: Path, take: Take, frames: Iterable[RecordedFrame], suffix: str) -> None:
    """Write images and odometry together, since `frames` can be read only once."""
    sensors = folder / SENSORS
    files: dict[str, int] = {}
    odometry: list[list[float]] = []
    for name, camera in take.cameras.items():
        (sensors / name / "data").mkdir(parents=True)
        (sensors / name / "sensor.yaml").write_text(_camera_yaml(name, camera, take), encoding="utf-8")
    for frame in frames:
        file = unused(str(frame.stamp_ns), suffix, files)
        files[file] = frame.stamp_ns
        for name, image in frame.images.items():
            (sensors / name / "data" / file).write_bytes(encoded(image, suffix))
        seen = frame.observation
        odometry.append([*_state_rows(seen.T_O_B[None])[0].tolist(), *seen.increment_covariance.ravel().tolist()])
    for name in take.cameras:
        _write_csv(sensors / name / "data.csv", IMAGE_COLUMNS, ([stamp, file] for file, stamp in files.items()))
    (folder / "timestamps.txt").write_text("".join(f"{stamp}\n" for stamp in files.values()), encoding="utf-8")
    (sensors / ODOMETRY).mkdir()
    (sensors / ODOMETRY / "sensor.yaml").write_text(_ODOMETRY_YAML + _extrinsics(np.eye(4)), encoding="utf-8")
    rows = ([stamp, *row] for stamp, row in zip(files.values(), odometry, strict=True))
    _write_csv(sensors / ODOMETRY / "data.csv", ODOMETRY_COLUMNS, rows)


def _write_imu(folder: Path, take: Take) -> None:
    folder.mkdir()
    (folder / "sensor.yaml").write_text(_imu_yaml(take.imu_config), encoding="utf-8")
    measured = np.hstack([take.imu.angular_velocity, take.imu.specific_force])
    _write_csv(folder / "data.csv", IMU_COLUMNS, _stamped(take, measured))


def _write_states(folder: Path, take: Take) -> None:
    folder.mkdir()
    (folder / "sensor.yaml").write_text(
        "sensor_type: visual-inertial\ncomment: the truth\n" + _extrinsics(np.eye(4)), encoding="utf-8"
    )
    biases = take.imu.gyroscope_bias, take.imu.accelerometer_bias
    states = np.hstack([_state_rows(take.T_W_B), take.velocity, *biases])
    _write_csv(folder / "data.csv", STATE_COLUMNS, _stamped(take, states))


def _stamped(take: Take, rows: Float64[np.ndarray, "n k"]) -> Iterable[list[float]]:
    return ([stamp, *row] for stamp, row in zip(take.imu_ns.tolist(), rows.tolist(), strict=True))


def _state_rows(poses: Float64[np.ndarray, "n 4 4"]) -> Float64[np.ndarray, "n 7"]:
    """Return a row of position and quaternion (w, x, y, z) for each pose."""
    return pose_rows(poses)[:, [0, 1, 2, 6, 3, 4, 5]]


def _write_csv(path: Path, columns: Iterable[str], rows: Iterable[Sequence[object]]) -> None:
    """Write rows as CSV. Floats have so many digits that a reader gets exactly the same values."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        file.write(",".join(columns) + "\n")
        csv.writer(file, lineterminator="\n").writerows(rows)


def _camera_yaml(name: str, camera: Camera, take: Take) -> str:
    k = camera.intrinsics
    return (
        f"sensor_type: camera\ncomment: simulated {name}\n{_extrinsics(camera.T_B_C)}"
        f"rate_hz: {1.0 / take.frame_s:g}\nresolution: [{k.width}, {k.height}]\ncamera_model: pinhole\n"
        f"intrinsics: [{k.fx}, {k.fy}, {k.cx}, {k.cy}] # fu, fv, cu, cv\n"
        "distortion_model: radial-tangential\n"
        f"distortion_coefficients: [{', '.join(take.distortion.decimals)}]\n"
    )


def _imu_yaml(imu: ImuConfig) -> str:
    return (
        f"sensor_type: imu\ncomment: simulated ADIS16448\n{_extrinsics(np.eye(4))}rate_hz: {imu.rate_hz:g}\n"
        f"gyroscope_noise_density: {imu.gyroscope_noise} # [rad/s/sqrt(Hz)]\n"
        f"gyroscope_random_walk: {imu.gyroscope_walk} # [rad/s^2/sqrt(Hz)]\n"
        f"accelerometer_noise_density: {imu.accelerometer_noise} # [m/s^2/sqrt(Hz)]\n"
        f"accelerometer_random_walk: {imu.accelerometer_walk} # [m/s^3/sqrt(Hz)]\n"
    )


_ODOMETRY_YAML = (
    "sensor_type: odometry\n"
    "comment: drifts; covariances are of the increment since the line before, rotation first [rad^2, m^2], on the right\n"
)


def _extrinsics(T_B_S: Float64[np.ndarray, "4 4"]) -> str:
    rows = ",\n         ".join(", ".join(map(repr, row)) for row in T_B_S.tolist())
    return f"T_BS:\n  cols: 4\n  rows: 4\n  data: [{rows}]\n"
