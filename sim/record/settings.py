"""Calibration in the words of the systems that are to run on a recording: ORB-SLAM3, VINS-Fusion, Kalibr and OpenVINS.

Tuning parameters are those that the systems ship for EuRoC; the noise of the IMU is what it has.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from jaxtyping import Float64

from lexis.se3 import inverse
from lexis.types import Camera
from sim.imu import GRAVITY_M_S2, ImuConfig
from sim.record.take import Take

_YAML = "%YAML:1.0\n---\n"


def write_settings(folder: Path, take: Take) -> None:
    """Write the settings of all systems, if cam0 and cam1 look the same way, as a stereo pair does. Raises OSError."""
    left, right = take.cameras["cam0"], take.cameras["cam1"]
    if not np.allclose(left.T_B_C[:3, :3], right.T_B_C[:3, :3]):
        return
    folder.mkdir()
    texts = {
        "orb_slam3.yaml": _orb_slam3(left, right, 1.0 / take.frame_s, take.imu_config),
        "vins_fusion.yaml": _vins_fusion(left, right, take.imu_config),
        "vins_cam0.yaml": _vins_camera("cam0", left),
        "vins_cam1.yaml": _vins_camera("cam1", right),
        "kalibr_imucam_chain.yaml": _kalibr_cameras({"cam0": left, "cam1": right}),
        "kalibr_imu_chain.yaml": _kalibr_imu(take.imu_config),
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")


def _orb_slam3(left: Camera, right: Camera, rate_hz: float, imu: ImuConfig) -> str:
    cameras = "".join(
        f"Camera{i}.fx: {k.fx}\nCamera{i}.fy: {k.fy}\nCamera{i}.cx: {k.cx}\nCamera{i}.cy: {k.cy}\n"
        f"Camera{i}.k1: 0.0\nCamera{i}.k2: 0.0\nCamera{i}.p1: 0.0\nCamera{i}.p2: 0.0\n"
        for i, k in enumerate((left.intrinsics, right.intrinsics), 1)
    )
    size = left.intrinsics
    return (
        f'{_YAML}File.version: "1.0"\nCamera.type: "PinHole"\n{cameras}'
        f"Camera.width: {size.width}\nCamera.height: {size.height}\nCamera.fps: {rate_hz:.0f}\nCamera.RGB: 0\n"
        f"Stereo.ThDepth: 60.0\nStereo.T_c1_c2: {_matrix(inverse(left.T_B_C) @ right.T_B_C, 'f')}"
        f"IMU.T_b_c1: {_matrix(left.T_B_C, 'f')}IMU.InsertKFsWhenLost: 0\n"
        f"IMU.NoiseGyro: {imu.gyroscope_noise}\nIMU.NoiseAcc: {imu.accelerometer_noise}\n"
        f"IMU.GyroWalk: {imu.gyroscope_walk}\nIMU.AccWalk: {imu.accelerometer_walk}\nIMU.Frequency: {imu.rate_hz}\n"
        "ORBextractor.nFeatures: 1200\nORBextractor.scaleFactor: 1.2\nORBextractor.nLevels: 8\n"
        "ORBextractor.iniThFAST: 20\nORBextractor.minThFAST: 7\n"
        "Viewer.KeyFrameSize: 0.05\nViewer.KeyFrameLineWidth: 1.0\nViewer.GraphLineWidth: 0.9\nViewer.PointSize: 2.0\n"
        "Viewer.CameraSize: 0.08\nViewer.CameraLineWidth: 3.0\nViewer.ViewpointX: 0.0\nViewer.ViewpointY: -0.7\n"
        "Viewer.ViewpointZ: -1.8\nViewer.ViewpointF: 500.0\n"
    )


def _vins_fusion(left: Camera, right: Camera, imu: ImuConfig) -> str:
    size = left.intrinsics
    return (
        f'{_YAML}imu: 1\nnum_of_cam: 2\nimu_topic: "/imu0"\n'
        'image0_topic: "/cam0/image_raw"\nimage1_topic: "/cam1/image_raw"\noutput_path: "."\n'
        'cam0_calib: "vins_cam0.yaml"\ncam1_calib: "vins_cam1.yaml"\n'
        f"image_width: {size.width}\nimage_height: {size.height}\nestimate_extrinsic: 0\n"
        f"body_T_cam0: {_matrix(left.T_B_C, 'd')}body_T_cam1: {_matrix(right.T_B_C, 'd')}"
        "multiple_thread: 1\nmax_cnt: 150\nmin_dist: 30\nfreq: 10\nF_threshold: 1.0\nshow_track: 0\nflow_back: 1\n"
        "max_solver_time: 0.04\nmax_num_iterations: 8\nkeyframe_parallax: 10.0\n"
        f"acc_n: {_discrete(imu.accelerometer_noise, imu)}\ngyr_n: {_discrete(imu.gyroscope_noise, imu)}\n"
        f"acc_w: {_discrete(imu.accelerometer_walk, imu)}\ngyr_w: {_discrete(imu.gyroscope_walk, imu)}\n"
        f"g_norm: {GRAVITY_M_S2}\n"
        'estimate_td: 0\ntd: 0.0\nload_previous_pose_graph: 0\npose_graph_save_path: "."\nsave_image: 0\n'
    )


def _vins_camera(name: str, camera: Camera) -> str:
    k = camera.intrinsics
    return (
        f"{_YAML}model_type: PINHOLE\ncamera_name: {name}\nimage_width: {k.width}\nimage_height: {k.height}\n"
        "distortion_parameters:\n   k1: 0.0\n   k2: 0.0\n   p1: 0.0\n   p2: 0.0\n"
        f"projection_parameters:\n   fx: {k.fx}\n   fy: {k.fy}\n   cx: {k.cx}\n   cy: {k.cy}\n"
    )


def _kalibr_cameras(cameras: Mapping[str, Camera]) -> str:
    text = _YAML
    for i, (name, camera) in enumerate(cameras.items()):
        k = camera.intrinsics
        text += (
            f"{name}:\n  T_imu_cam:\n{_rows(camera.T_B_C)}  cam_overlaps: [{1 - i}]\n  camera_model: pinhole\n"
            "  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]\n  distortion_model: radtan\n"
            f"  intrinsics: [{k.fx}, {k.fy}, {k.cx}, {k.cy}]\n  resolution: [{k.width}, {k.height}]\n"
            f"  rostopic: /{name}/image_raw\n  timeshift_cam_imu: 0.0\n"
        )
    return text


def _kalibr_imu(imu: ImuConfig) -> str:
    identity, zero = _rows(np.eye(3)), _rows(np.zeros((3, 3)))
    return (
        f"{_YAML}imu0:\n  T_i_b:\n{_rows(np.eye(4))}"
        f"  accelerometer_noise_density: {imu.accelerometer_noise}\n"
        f"  accelerometer_random_walk: {imu.accelerometer_walk}\n"
        f"  gyroscope_noise_density: {imu.gyroscope_noise}\n  gyroscope_random_walk: {imu.gyroscope_walk}\n"
        f"  rostopic: /imu0\n  time_offset: 0.0\n  update_rate: {imu.rate_hz}\n  model: calibrated\n"
        f"  Tw:\n{identity}  R_IMUtoGYRO:\n{identity}  Ta:\n{identity}  R_IMUtoACC:\n{identity}  Tg:\n{zero}"
    )


def _discrete(density: float, imu: ImuConfig) -> float:
    """Noise per sample, as VINS-Fusion takes it, that of the rate of the biases too: it multiplies all by the time step."""
    return float(density * np.sqrt(imu.rate_hz))


def _matrix(T: Float64[np.ndarray, "4 4"], kind: str) -> str:
    values = ", ".join(map(repr, T.ravel().tolist()))
    return f"!!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: {kind}\n   data: [{values}]\n"


def _rows(matrix: Float64[np.ndarray, "m n"]) -> str:
    return "".join(f"    - [{', '.join(map(repr, row))}]\n" for row in matrix.tolist())
