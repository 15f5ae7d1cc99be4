"""Writes settings files with which other SLAM systems run on a recording: ORB-SLAM3, VINS-Fusion and OpenVINS.

Calibrations and the IMU's noise are the true values of the recording. Tuning parameters have the values in the settings for
EuRoC that come with these systems.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float64

from lexis.maths.se3 import inverse
from lexis.types import Camera
from sim.odometry.imu import GRAVITY_M_S2, ImuConfig
from sim.record.stamps import REST_S
from sim.record.take import Take
from sim.render.image_files import DEPTH_FACTOR
from sim.render.lens import Distortion

_YAML = "%YAML:1.0\n---\n"
_OPENVINS_ACCELERATION_STD_M_S2 = 0.2
"""Standard deviation of accelerations above which OpenVINS takes the rest at the start to be over [m/s²]. It is lower than
in OpenVINS's settings for EuRoC, since a walker starts more gently than a drone."""


def write_settings(folder: Path, take: Take) -> None:
    """Write the settings files of other SLAM systems, such as ORB-SLAM3, for a recording. Raises OSError.

    Nothing is written unless cam0 and cam1 are parallel, as in a stereo pair.
    """
    left, right = take.cameras["cam0"], take.cameras["cam1"]
    if not np.allclose(left.T_B_C[:3, :3], right.T_B_C[:3, :3]):
        return
    folder.mkdir()
    texts = {
        "orb_slam3.yaml": _orb_slam3(left, right, take),
        "vins_fusion.yaml": _vins_fusion(left, right, take.imu_config),
        "vins_cam0.yaml": _vins_camera("cam0", left, take.distortion),
        "vins_cam1.yaml": _vins_camera("cam1", right, take.distortion),
        "kalibr_imucam_chain.yaml": _kalibr_cameras({"cam0": left, "cam1": right}, take.distortion),
        "kalibr_imu_chain.yaml": _kalibr_imu(take.imu_config),
        "estimator_config.yaml": _openvins(1.0 / take.frame_s),
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")


def write_rgbd_settings(folder: Path, take: Take) -> None:
    """Write the settings of ORB-SLAM3 for colour and depth images of cam0 to a new folder. Raises OSError."""
    folder.mkdir()
    (folder / "orb_slam3_rgbd.yaml").write_text(_orb_slam3_rgbd(take), encoding="utf-8")


def _orb_slam3_rgbd(take: Take) -> str:
    return (
        f"{_orb_cameras((take.cameras['cam0'],), take)}"
        f"Stereo.ThDepth: 40.0\nStereo.b: 0.07732\nRGBD.DepthMapFactor: {DEPTH_FACTOR}\n{_ORB_TUNING}"
    )


def _orb_cameras(cameras: Sequence[Camera], take: Take) -> str:
    k1, k2, p1, p2 = take.distortion.decimals
    each = "".join(
        f"Camera{i}.fx: {k.fx}\nCamera{i}.fy: {k.fy}\nCamera{i}.cx: {k.cx}\nCamera{i}.cy: {k.cy}\n"
        f"Camera{i}.k1: {k1}\nCamera{i}.k2: {k2}\nCamera{i}.p1: {p1}\nCamera{i}.p2: {p2}\n"
        for i, k in enumerate((camera.intrinsics for camera in cameras), 1)
    )
    size = cameras[0].intrinsics
    return (
        f'{_YAML}File.version: "1.0"\nCamera.type: "PinHole"\n{each}'
        f"Camera.width: {size.width}\nCamera.height: {size.height}\nCamera.fps: {1.0 / take.frame_s:.0f}\nCamera.RGB: 0\n"
    )


def _orb_slam3(left: Camera, right: Camera, take: Take) -> str:
    imu = take.imu_config
    return (
        f"{_orb_cameras((left, right), take)}"
        f"Stereo.ThDepth: 60.0\nStereo.T_c1_c2: {_matrix(inverse(left.T_B_C) @ right.T_B_C, 'f')}"
        f"IMU.T_b_c1: {_matrix(left.T_B_C, 'f')}IMU.InsertKFsWhenLost: 0\n"
        f"IMU.NoiseGyro: {imu.gyroscope_noise}\nIMU.NoiseAcc: {imu.accelerometer_noise}\n"
        f"IMU.GyroWalk: {imu.gyroscope_walk}\nIMU.AccWalk: {imu.accelerometer_walk}\nIMU.Frequency: {imu.rate_hz}\n"
        f"{_ORB_TUNING}"
    )


_ORB_TUNING = (
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


def _vins_camera(name: str, camera: Camera, distortion: Distortion) -> str:
    k = camera.intrinsics
    k1, k2, p1, p2 = distortion.decimals
    return (
        f"{_YAML}model_type: PINHOLE\ncamera_name: {name}\nimage_width: {k.width}\nimage_height: {k.height}\n"
        f"distortion_parameters:\n   k1: {k1}\n   k2: {k2}\n   p1: {p1}\n   p2: {p2}\n"
        f"projection_parameters:\n   fx: {k.fx}\n   fy: {k.fy}\n   cx: {k.cx}\n   cy: {k.cy}\n"
    )


def _kalibr_cameras(cameras: Mapping[str, Camera], distortion: Distortion) -> str:
    text, coefficients = _YAML, ", ".join(distortion.decimals)
    for i, (name, camera) in enumerate(cameras.items()):
        k = camera.intrinsics
        text += (
            f"{name}:\n  T_imu_cam:\n{_rows(camera.T_B_C)}  cam_overlaps: [{1 - i}]\n  camera_model: pinhole\n"
            f"  distortion_coeffs: [{coefficients}]\n  distortion_model: radtan\n"
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


def _openvins(rate_hz: float) -> str:
    """Return OpenVINS's settings for EuRoC, adapted to the rest at the start of recordings and to their frame rate.

    Settings that EuRoC does not need are left out. The settings refer to the two files in Kalibr's format.
    """
    return (
        f'{_YAML}verbosity: "INFO"\nuse_fej: true\nuse_imuavg: true\nuse_rk4int: true\n'
        "use_stereo: true\nmax_cameras: 2\n"
        "calib_cam_extrinsics: true\ncalib_cam_intrinsics: true\ncalib_cam_timeoffset: true\n"
        "max_clones: 11\nmax_slam: 50\nmax_slam_in_update: 25\nmax_msckf_in_update: 40\ndt_slam_delay: 1\n"
        f"gravity_mag: {GRAVITY_M_S2}\n"
        'feat_rep_msckf: "GLOBAL_3D"\nfeat_rep_slam: "ANCHORED_MSCKF_INVERSE_DEPTH"\n'
        'feat_rep_aruco: "ANCHORED_MSCKF_INVERSE_DEPTH"\n'
        "try_zupt: false\nzupt_chi2_multipler: 0\nzupt_max_velocity: 0.1\nzupt_noise_multiplier: 10\n"
        "zupt_max_disparity: 0.5\nzupt_only_at_beginning: false\n"
        f"init_window_time: {REST_S}\ninit_imu_thresh: {_OPENVINS_ACCELERATION_STD_M_S2}\ninit_max_disparity: 10.0\n"
        "init_max_features: 75\ninit_dyn_use: false\ninit_dyn_mle_opt_calib: false\ninit_dyn_mle_max_iter: 50\n"
        "init_dyn_mle_max_time: 0.05\ninit_dyn_mle_max_threads: 6\ninit_dyn_num_pose: 6\ninit_dyn_min_deg: 10.0\n"
        "init_dyn_inflation_ori: 10\ninit_dyn_inflation_vel: 100\ninit_dyn_inflation_bg: 10\n"
        "init_dyn_inflation_ba: 100\ninit_dyn_min_rec_cond: 1e-12\n"
        "init_dyn_bias_g: [0.0, 0.0, 0.0]\ninit_dyn_bias_a: [0.0, 0.0, 0.0]\n"
        'record_timing_information: false\nrecord_timing_filepath: "traj_timing.txt"\nsave_total_state: false\n'
        'filepath_est: "ov_estimate.txt"\nfilepath_std: "ov_estimate_std.txt"\nfilepath_gt: "ov_groundtruth.txt"\n'
        "use_klt: true\nnum_pts: 200\nfast_threshold: 20\ngrid_x: 5\ngrid_y: 5\nmin_px_dist: 10\nknn_ratio: 0.70\n"
        f"track_frequency: {rate_hz + 1.0:.1f}\n"
        'downsample_cameras: false\nnum_opencv_threads: 4\nhistogram_method: "HISTOGRAM"\n'
        "use_aruco: false\nnum_aruco: 1024\ndownsize_aruco: true\n"
        "up_msckf_sigma_px: 1\nup_msckf_chi2_multipler: 1\nup_slam_sigma_px: 1\nup_slam_chi2_multipler: 1\n"
        "up_aruco_sigma_px: 1\nup_aruco_chi2_multipler: 1\nuse_mask: false\n"
        'relative_config_imu: "kalibr_imu_chain.yaml"\nrelative_config_imucam: "kalibr_imucam_chain.yaml"\n'
    )


def _discrete(density: float, imu: ImuConfig) -> float:
    """Convert a noise density to the standard deviation of the noise of one sample, at the IMU's rate.

    VINS-Fusion expects noise per sample even for the random walks of the biases, because it multiplies all noise by the time
    step.
    """
    return float(density * np.sqrt(imu.rate_hz))


def _matrix(T: Float64[np.ndarray, "4 4"], kind: str) -> str:
    values = ", ".join(map(repr, T.ravel().tolist()))
    return f"!!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: {kind}\n   data: [{values}]\n"


def _rows(matrix: Float64[np.ndarray, "m n"]) -> str:
    return "".join(f"    - [{', '.join(map(repr, row))}]\n" for row in matrix.tolist())
