"""Recordings replay to the map of the live run in every format; their sensors agree with each other and with the truth."""

import csv
import errno
import json
import shutil
import sqlite3
from dataclasses import fields, replace
from itertools import islice

import cv2
import numpy as np
import pytest
import yaml
from evo.tools import file_interface
from scipy.spatial.transform import Rotation

from lexis.cli import main as lexis
from lexis.datasets.dataset import DatasetConfig, open_dataset
from lexis.encoder.open_clip_encoder import load_encoder
from lexis.errors import LexisError
from lexis.map.folder import load_map
from lexis.maths.projection import rays
from lexis.maths.quaternions import poses_of
from sim.cli import main
from sim.errors import SimError
from sim.faults.delivery import Dropped, Late, OutOfOrder
from sim.faults.images import Noise
from sim.faults.poses import Kidnap, OdometryNaN
from sim.faults.stamps import StampJitter, StampJump, StampOffset
from sim.harness import Lexis, Scenario, run
from sim.odometry.imu import ImuConfig
from sim.record import record
from sim.record.recording import FORMATS
from sim.record.ros2 import write_bag
from sim.record.settings import write_settings
from sim.record.stamps import EPOCH_NS, MAX_DAY, REST_S, stamp_ns
from sim.record.take import Take, prepare
from sim.render.lens import Distortion
from sim.render.rig import RigConfig, build_rig
from sim.world_states import FrameRenderer
from worlds.presets import sample_from_rooms
from worlds.spec import HouseSpec

CONFIG = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom"), seed=31), seed=5, length_m=13.0, rig=RigConfig("wide", 200, 150, 80.0)
)
"""The shortest walk that has loops."""
REST = 20
"""Number of frames at rest at the start."""
TRUTH = ("house.json", "rooms.json", "groundtruth.txt", "state_groundtruth_estimate0", "depth*")
LOSSLESS = [("euroc", "png"), ("tum", "png"), ("ros2", "raw"), ("mcap", "png")]
SILENT, SLOW = ImuConfig(200.0, 0.0, 0.0, 0.0, 0.0), ImuConfig(20.0)
IMUS = {("euroc", "jpg"): SILENT, ("ros2", "raw"): SLOW, ("mcap", "png"): SLOW}
"""Settings of recordings whose IMU differs from that of EuRoC."""


@pytest.fixture(scope="module")
def encoder():
    return load_encoder("mini")


@pytest.fixture(scope="module")
def live(encoder):
    slam = Lexis(encoder)
    run(CONFIG, slam)
    return slam.map


@pytest.fixture(scope="module")
def frames():
    """The contents of every format, rendered once."""
    return list(prepare(CONFIG).frames(("cam1",), depth=True))


@pytest.fixture(scope="module")
def recordings(frames, tmp_path_factory):
    """Folders of recordings by format and kind of images, each recorded once."""
    root, made = tmp_path_factory.mktemp("recordings"), {}

    def make(form, images):
        if (form, images) not in made:
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(Take, "frames", lambda *_: (frame for frame in frames))
                record(CONFIG, root / f"{form}-{images}", form, images, imu_config=IMUS.get((form, images)))
        made[form, images] = root / f"{form}-{images}"
        return made[form, images]

    return make


ARM = replace(CONFIG.rig, lever_arm_m=(0.05, -0.08, 0.03), lever_arm_rpy_deg=(4.0, -3.0, 90.0))
FRONT = build_rig(CONFIG.rig).front
LENS = Distortion(-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05)
BIASED = replace(SILENT, gyroscope_turn_on=0.01, accelerometer_turn_on=0.2)


@pytest.fixture(scope="module")
def on_an_arm(tmp_path_factory):
    """Recordings by format, with distorted cameras away from the IMU and an IMU with turn-on biases; and their frames."""
    config, root = replace(CONFIG, rig=ARM), tmp_path_factory.mktemp("arm")
    frames = list(prepare(config, distortion=LENS).frames(("cam1",), depth=True))[::FEWER]

    def make(form):
        if not (root / form).exists():
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(Take, "frames", lambda *_: (frame for frame in frames))
                record(config, root / form, form, "png", imu_config=BIASED, distortion=LENS)
        return root / form

    return make


FEWER = 5
"""Every this-many-th frame is kept where a test looks only at images and calibrations."""


@pytest.fixture(scope="module")
def replay(encoder, tmp_path_factory):
    """The map that `lexis run` makes of a recording, without the files that contain the truth."""

    def run_command(folder):
        root = tmp_path_factory.mktemp("replay")
        blind = shutil.copytree(folder, root / "recording", ignore=shutil.ignore_patterns(*TRUTH))
        labels = json.loads((folder / "rooms.json").read_text())["labels"]
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(
                "lexis.encoder.open_clip_encoder.load_encoder", lambda name, options: encoder
            )  # which takes seconds
            assert lexis(["run", str(blind), "--rooms", ",".join(labels), "-o", str(root / "map")]) == 0
        return load_map(root / "map")

    return run_command


def content(lexis_map):
    """A map as nested plain data, without stamps, frame numbers and times."""
    skipped = {"stamp", "observation_index", "stage_seconds"}

    def plain(value):
        if hasattr(value, "__dataclass_fields__"):
            return {f.name: plain(getattr(value, f.name)) for f in fields(value) if f.name not in skipped}
        if isinstance(value, tuple):
            return [plain(item) for item in value]
        return value.tolist() if isinstance(value, np.ndarray) else value

    return plain(lexis_map)


@pytest.mark.parametrize(("form", "images"), LOSSLESS)
def test_replay_gives_the_map_of_the_live_run_bit_by_bit(form, images, recordings, live, replay):
    replayed = replay(recordings(form, images))
    assert len(live.keyframes) > 20 and live.loops
    assert content(replayed) == content(live)
    for ours, theirs in zip(live.keyframes, replayed.keyframes, strict=True):
        assert theirs.observation_index == (ours.observation_index + REST if ours.id else 0)
        moved = REST_S if ours.id else 0.0
        assert theirs.stamp == pytest.approx(EPOCH_NS / 1e9 + ours.stamp + moved, abs=1e-6)


def test_another_day_moves_all_stamps_and_nothing_else():
    today, later = prepare(CONFIG), prepare(CONFIG, day=3)
    assert set((later.imu_ns - today.imu_ns).tolist()) == {3 * 24 * 3600 * 10**9}
    assert stamp_ns(5.0, 3) - stamp_ns(5.0) == 3 * 24 * 3600 * 10**9
    np.testing.assert_array_equal(later.imu.specific_force, today.imu.specific_force)
    assert prepare(CONFIG, day=MAX_DAY).imu_ns[-1] < 2**31 * 10**9
    with pytest.raises(SimError, match="day is -1; valid: a whole number from 0 to 10000"):
        prepare(CONFIG, day=-1)


def test_jpeg_changes_pixels_and_little_else(recordings, live, replay):
    """Keyframes follow from the odometry, which is exact; labels follow from the images, which are not."""
    replayed = replay(recordings("euroc", "jpg"))
    assert [k.T_O_B.tobytes() for k in replayed.keyframes] == [k.T_O_B.tobytes() for k in live.keyframes]
    assert (replayed.labels == live.labels).mean() > 0.8
    assert np.linalg.norm(replayed.T_W_B[:, :3, 3] - live.T_W_B[:, :3, 3], axis=1).max() < 0.3


def csv_rows(path):
    with open(path, encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    return header, rows


def test_euroc_is_laid_out_as_its_readers_expect(recordings):
    """File names are stamps, which the lists repeat; headers are EuRoC's; the IMU covers all frames and the rest before."""
    folder = recordings("euroc", "png")
    stamps = (folder / "timestamps.txt").read_text().split()
    for camera in ("cam0", "cam1"):
        header, rows = csv_rows(folder / "mav0" / camera / "data.csv")
        assert header == ["#timestamp [ns]", "filename"]
        assert rows == [[stamp, f"{stamp}.png"] for stamp in stamps]
        assert sorted(p.name for p in (folder / "mav0" / camera / "data").iterdir()) == [name for _, name in rows]
    header, rows = csv_rows(folder / "mav0" / "imu0" / "data.csv")
    assert header[:2] == ["#timestamp [ns]", "w_RS_S_x [rad s^-1]"] and header[-1] == "a_RS_S_z [m s^-2]"
    imu = np.array([row[0] for row in rows], np.int64)
    assert (np.diff(imu) == 5_000_000).all() and imu[0] < int(stamps[0]) and imu[-1] > int(stamps[-1])
    resting = np.array([row[1:] for row in rows], float)[imu < EPOCH_NS + REST_S * 1e9]
    np.testing.assert_allclose(resting.mean(axis=0), [0, 0, 0, 0, 0, 9.81], atol=0.02)
    header, rows = csv_rows(folder / "mav0" / "state_groundtruth_estimate0" / "data.csv")
    assert len(header) == 17 and header[1] == " p_RS_R_x [m]" and header[4] == " q_RS_w []" and len(rows) == len(imu)
    assert all(len(stamp) == 19 for stamp in stamps) and int(stamps[0]) == EPOCH_NS
    sensor = yaml.safe_load((folder / "mav0" / "cam1" / "sensor.yaml").read_text())
    assert sensor["distortion_model"] == "radial-tangential" and sensor["distortion_coefficients"] == [0.0] * 4
    assert sensor["rate_hz"] == 10 and sensor["resolution"] == [200, 150]
    noise = yaml.safe_load((folder / "mav0" / "imu0" / "sensor.yaml").read_text())
    assert noise["gyroscope_noise_density"] == 1.6968e-4 and noise["accelerometer_random_walk"] == 3.0e-3


@pytest.mark.parametrize("rig", ["in the IMU", "on an arm"])
def test_integrating_the_files_of_a_noise_free_imu_gives_the_walk_back(rig, recordings, on_an_arm):
    """The IMU is integrated by the midpoint rule over the whole walk, from rest, after the biases are subtracted."""
    mav = (recordings("euroc", "jpg") if rig == "in the IMU" else on_an_arm("euroc")) / "mav0"
    imu = np.array(csv_rows(mav / "imu0" / "data.csv")[1], float)
    state = np.array(csv_rows(mav / "state_groundtruth_estimate0" / "data.csv")[1], float)
    gyro, force = imu[:, 1:4] - state[:, 11:14], imu[:, 4:7] - state[:, 14:17]
    dt, mean = 0.005, (gyro[1:] + gyro[:-1]) / 2
    turns = Rotation.from_rotvec(mean * dt + np.cross(gyro[:-1], gyro[1:]) * dt**2 / 12)
    R = [Rotation.from_quat(state[0, [5, 6, 7, 4]])]
    for turn in turns:
        R.append(R[-1] * turn)
    acceleration = Rotation.concatenate(R).apply(force) - [0.0, 0.0, 9.81]
    velocity = np.vstack([np.zeros(3), np.cumsum((acceleration[1:] + acceleration[:-1]) / 2 * dt, axis=0)])
    position = state[0, 1:4] + np.vstack([np.zeros(3), np.cumsum((velocity[1:] + velocity[:-1]) / 2 * dt, axis=0)])
    assert np.linalg.norm(np.diff(state[:, 1:4], axis=0), axis=1).sum() > 12.0
    np.testing.assert_allclose(velocity, state[:, 8:11], atol=2e-3)
    np.testing.assert_allclose(position, state[:, 1:4], atol=2e-2)
    truth = Rotation.from_quat(state[:, [5, 6, 7, 4]])
    assert np.degrees((Rotation.concatenate(R).inv() * truth).magnitude().max()) < 1e-2


def test_noise_and_biases_of_the_files_are_what_they_say(recordings):
    """The measurements minus those of a noise-free IMU and minus the stated biases are white noise."""
    given, silent = (recordings("euroc", images) / "mav0" for images in ("png", "jpg"))
    imu, ideal = (np.array(csv_rows(mav / "imu0" / "data.csv")[1], float)[:, 1:] for mav in (given, silent))
    biases = np.array(csv_rows(given / "state_groundtruth_estimate0" / "data.csv")[1], float)[:, 11:]
    noise = imu - ideal - biases
    np.testing.assert_allclose(noise.std(axis=0), np.sqrt(200) * np.repeat([1.6968e-4, 2.0e-3], 3), rtol=0.05)
    assert np.abs(np.mean(noise[1:] * noise[:-1], axis=0) / noise.var(axis=0)).max() < 0.05
    assert biases[-1].all() and not biases[0].any()


def test_stereo_images_and_depth_agree(recordings):
    """The right image, warped to the left one with the depth of another recording and both calibrations, looks the same."""
    euroc, tum = recordings("euroc", "png"), recordings("tum", "png")
    left, right = (
        np.array(yaml.safe_load((euroc / "mav0" / name / "sensor.yaml").read_text())["T_BS"]["data"]).reshape(4, 4)
        for name in ("cam0", "cam1")
    )
    stamps = (euroc / "timestamps.txt").read_text().split()
    depth_files = [line.split()[1] for line in (tum / "depth.txt").read_text().splitlines() if line[0] != "#"]
    k, errors = FRONT.intrinsics, []
    v, u = np.mgrid[: k.height, : k.width]
    for frame in range(REST, len(stamps), 40):
        images = [cv2.imread(str(euroc / f"mav0/cam{i}/data/{stamps[frame]}.png")) for i in (0, 1)]
        depth = cv2.imread(str(tum / depth_files[frame]), cv2.IMREAD_UNCHANGED)
        assert depth.dtype == np.uint16
        direction = rays(np.stack([u, v], axis=-1).astype(float), k)
        points = direction / direction[..., 2:] * (depth / 5000.0)[..., None]
        seen = (points - (np.linalg.inv(left) @ right)[:3, 3]).astype(np.float32)
        with np.errstate(divide="ignore", invalid="ignore"):
            maps = k.fx * seen[..., 0] / seen[..., 2] + k.cx, k.fy * seen[..., 1] / seen[..., 2] + k.cy
        fetched = cv2.remap(images[1], *(m.astype(np.float32) for m in maps), cv2.INTER_LINEAR)
        inside = (depth > 0) & (maps[0] > 0) & (maps[0] < k.width - 1)
        errors.append(np.abs(fetched.astype(int) - images[0])[inside].mean(axis=1))
    assert np.median(np.concatenate(errors)) < 4.0


def test_tum_is_read_by_evo_and_true_for_the_camera(recordings):
    folder = recordings("tum", "png")
    truth = file_interface.read_tum_trajectory_file(str(folder / "groundtruth.txt"))
    take = prepare(CONFIG)
    np.testing.assert_allclose(np.array(truth.poses_se3), take.T_W_B @ FRONT.T_B_C, atol=1e-6)
    images = (folder / "rgb.txt").read_text().splitlines()[2:]
    assert len(images) == len(take) and images[0] == "1000000010.000000 rgb/1000000010.000000.png"
    accelerations = np.loadtxt(folder / "accelerometer.txt")
    np.testing.assert_allclose(accelerations[:400, 1:].mean(axis=0), [0.0, 0.0, 9.81], atol=0.02)


def test_a_bag_says_the_same_as_euroc(recordings):
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    folder, mav = recordings("mcap", "png"), recordings("euroc", "png") / "mav0"
    of = {}
    with AnyReader([folder / "bag"], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        last = 0
        for connection, stamp, raw in reader.messages():
            assert stamp >= last
            last = stamp
            of.setdefault(connection.topic, []).append(reader.deserialize(raw, connection.msgtype))
    imu = prepare(CONFIG, imu_config=SLOW).imu
    np.testing.assert_array_equal([m.angular_velocity.x for m in of["/imu0"]], imu.angular_velocity[:, 0])
    np.testing.assert_array_equal([m.linear_acceleration.z for m in of["/imu0"]], imu.specific_force[:, 2])
    info = of["/cam1/camera_info"][0]
    assert info.p.reshape(3, 4)[0, 3] == pytest.approx(-0.11 * FRONT.intrinsics.fx)
    assert {t.child_frame_id for t in of["/tf_static"][0].transforms} == {"imu0", "cam0", "cam1"}
    odometry = np.array(csv_rows(mav / "odom0" / "data.csv")[1], float)
    assert len(of["/odom"]) == len(of["/odom/increment_covariance"]) == len(odometry)
    spread = [np.trace(m.pose.covariance.reshape(6, 6)) for m in of["/odom"]]
    assert spread[0] == 0.0 and spread[-1] > spread[len(spread) // 2] > 0.0


def test_settings_say_what_the_sensors_are(recordings):
    """Settings are parsed as ORB-SLAM3, VINS-Fusion and OpenVINS do it; ORB-SLAM3 needs integers where it expects them."""
    folder = recordings("euroc", "png") / "settings"
    files = {path.stem: cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ) for path in folder.iterdir()}
    left, right = (prepare(CONFIG).cameras[name].T_B_C for name in ("cam0", "cam1"))
    orb, vins, cameras = files["orb_slam3"], files["vins_fusion"], files["kalibr_imucam_chain"]
    np.testing.assert_allclose(orb.getNode("IMU.T_b_c1").mat(), left, atol=1e-6)
    np.testing.assert_allclose(orb.getNode("Stereo.T_c1_c2").mat(), np.linalg.inv(left) @ right, atol=1e-6)
    np.testing.assert_array_equal(vins.getNode("body_T_cam1").mat(), right)
    rows = cameras.getNode("cam1").getNode("T_imu_cam")
    assert [[rows.at(i).at(j).real() for j in range(4)] for i in range(4)] == right.tolist()
    assert orb.getNode("File.version").string() == "1.0"
    for name in ("Camera.width", "Camera.height", "Camera.fps", "Camera.RGB", "ORBextractor.nFeatures"):
        assert orb.getNode(name).isInt(), name
    k = FRONT.intrinsics
    own = files[vins.getNode("cam1_calib").string().removesuffix(".yaml")].getNode("projection_parameters")
    assert own.getNode("fx").real() == k.fx == orb.getNode("Camera2.fx").real()
    assert files["kalibr_imu_chain"].getNode("imu0").getNode("update_rate").real() == 200.0
    # VINS-Fusion multiplies the noise of a sample by the time step; over one second that gives the density.
    for name, density in (("acc_n", 2.0e-3), ("acc_w", 3.0e-3), ("gyr_n", 1.6968e-4), ("gyr_w", 1.9393e-5)):
        assert np.sqrt(200) * vins.getNode(name).real() / 200 == pytest.approx(density)


def test_settings_say_what_a_lens_and_a_lever_arm_are(on_an_arm):
    folder, expected = on_an_arm("euroc"), list(LENS.coefficients)
    files = {path.stem: cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ) for path in (folder / "settings").iterdir()}
    orb, vins, kalibr = files["orb_slam3"], files["vins_cam1"], files["kalibr_imucam_chain"]
    names = ("k1", "k2", "p1", "p2")
    assert [orb.getNode(f"Camera2.{name}").real() for name in names] == expected
    assert [vins.getNode("distortion_parameters").getNode(name).real() for name in names] == expected
    assert [kalibr.getNode("cam0").getNode("distortion_coeffs").at(i).real() for i in range(4)] == expected
    T_B_C = build_rig(ARM).front.T_B_C
    np.testing.assert_allclose(orb.getNode("IMU.T_b_c1").mat(), T_B_C, atol=1e-6)
    assert np.linalg.norm(T_B_C[:3, 3]) == pytest.approx(np.linalg.norm([0.05, -0.08, 0.03]))
    sensor = yaml.safe_load((folder / "mav0" / "cam1" / "sensor.yaml").read_text())
    assert sensor["distortion_coefficients"] == expected
    rgbd = on_an_arm("tum") / "settings" / "orb_slam3_rgbd.yaml"
    rgbd = cv2.FileStorage(str(rgbd), cv2.FILE_STORAGE_READ)
    assert rgbd.getNode("Camera1.k2").real() == LENS.k2 and rgbd.getNode("RGBD.DepthMapFactor").real() == 5000.0


def test_openvins_is_given_its_two_other_files(recordings):
    folder = recordings("euroc", "png") / "settings"
    settings = cv2.FileStorage(str(folder / "estimator_config.yaml"), cv2.FILE_STORAGE_READ)
    for name in ("relative_config_imu", "relative_config_imucam"):
        assert (folder / settings.getNode(name).string()).is_file()
    assert settings.getNode("init_imu_thresh").real() == 0.2 and settings.getNode("track_frequency").real() == 11.0
    assert settings.getNode("gravity_mag").real() == 9.81 and settings.getNode("init_window_time").real() <= REST_S


@pytest.mark.parametrize("form", ["euroc", "tum", "mcap"])
def test_lexis_reads_distorted_recordings_as_a_pinhole_s(form, on_an_arm):
    """LEXIS rectifies the images, so they equal those of the live run up to the blur of two interpolations."""
    given, k = list(open_dataset(on_an_arm(form))), FRONT.intrinsics
    live = list(prepare(replace(CONFIG, rig=ARM)).frames())[::FEWER]
    known = cv2.undistort(np.full((k.height, k.width), 255, np.uint8), k.matrix, np.array(LENS.coefficients)) == 255
    inside = cv2.erode(known.astype(np.uint8), np.ones((5, 5))).astype(bool)
    assert len(given) == len(live) and inside.mean() > 0.6
    for observation, frame in zip(given, live, strict=True):
        error = np.abs(observation.image.astype(int) - frame.images["cam0"])[inside]
        assert np.median(error) <= 2 and error.mean() < 6


def test_the_camera_s_path_is_an_arm_away_from_the_imu_s(on_an_arm):
    """The true states are those of the IMU, whose measurements integrate to them; the truth of TUM is that of the camera."""
    states = np.array(csv_rows(on_an_arm("euroc") / "mav0" / "state_groundtruth_estimate0" / "data.csv")[1], float)
    camera = np.array(file_interface.read_tum_trajectory_file(str(on_an_arm("tum") / "groundtruth.txt")).poses_se3)
    np.testing.assert_allclose(camera, poses_of(states[:, [1, 2, 3, 5, 6, 7, 4]]) @ build_rig(ARM).front.T_B_C, atol=1e-6)
    aside = camera[:, :3, 3] - states[:, 1:4]
    assert np.linalg.norm(aside.max(axis=0) - aside.min(axis=0)) > 0.1  # the offset rotates with the body


def test_associations_are_pairs_of_files_of_one_instant(recordings):
    folder = recordings("tum", "png")
    pairs = [line.split() for line in (folder / "associations.txt").read_text().splitlines()]
    assert len(pairs) == len(list((folder / "rgb").iterdir()))
    for colour_stamp, colour, depth_stamp, depth in pairs:
        assert colour_stamp == depth_stamp and colour_stamp in colour and depth_stamp in depth
        assert (folder / colour).is_file() and (folder / depth).is_file()


def test_a_distortion_that_folds_is_refused_before_the_work(tmp_path):
    with pytest.raises(SimError, match="valid: weaker coefficients"):
        record(CONFIG, tmp_path / "out", distortion=Distortion(-0.8))
    assert not list(tmp_path.iterdir())


def test_settings_are_of_stereo_pairs_only(tmp_path):
    for name, written in (("stereo", True), ("front-rear", False)):
        write_settings(tmp_path / name, prepare(replace(CONFIG, rig=RigConfig(name, 160, 120))))
        assert (tmp_path / name).exists() == written


def test_rooms_of_frames_are_true_and_the_house_is_beside(recordings):
    folder = recordings("tum", "png")
    rooms = json.loads((folder / "rooms.json").read_text())
    house = HouseSpec.load(folder / "house.json")
    assert house == CONFIG.house and tuple(rooms["labels"]) == house.room_labels
    truth = file_interface.read_tum_trajectory_file(str(folder / "groundtruth.txt"))
    at = np.searchsorted(np.round(truth.timestamps * 1e6), np.array(rooms["frames"]["stamp_ns"]) // 1000)
    polygon = {room["id"]: np.array(room["polygon_m"], np.float32) for room in rooms["rooms"]}
    for (x, y), room in zip(truth.positions_xyz[at, :2], rooms["frames"]["room"], strict=True):
        assert cv2.pointPolygonTest(polygon[room], (float(x), float(y)), True) > -0.05
    assert set(rooms["frames"]["storey"]) == {0}


@pytest.fixture
def unlit(monkeypatch):
    """Replaces rendering: frames are black and cost nothing."""
    size = FRONT.intrinsics.height, FRONT.intrinsics.width
    black = np.zeros((*size, 3), np.uint8)
    monkeypatch.setattr(FrameRenderer, "rgb", lambda *_: black.copy())
    monkeypatch.setattr(FrameRenderer, "rig", lambda self, *_: tuple(black.copy() for _ in self._camera.rig))
    monkeypatch.setattr(FrameRenderer, "depth", lambda *_: np.zeros(size, np.float32))


@pytest.mark.parametrize("form", ["euroc", "mcap"])
def test_a_recorded_rig_is_replayed_as_it_was_seen(form, tmp_path, unlit):
    """The noise of the images tells cameras and frames apart."""
    config = replace(CONFIG, rig=replace(ARM, name="front-rear"), faults=(Noise(20.0),), frame_rate_hz=2.0)
    take = prepare(config)
    record(config, tmp_path / "out", form, "png")
    dataset = open_dataset(tmp_path / "out", DatasetConfig(camera="cam0,cam1"))
    for read, made in zip(dataset.camera.rig, take.rig.rig, strict=True):
        assert read.intrinsics == made.intrinsics
        np.testing.assert_allclose(read.T_B_C, made.T_B_C, atol=1e-9)
    # The first frame is part of the rest, during which the covariance is zero.
    replayed, seen = list(dataset)[take.rest_frames + 1 :], [observation for observation, _ in take.session][1:]
    assert len(replayed) == len(seen)
    for one, other in zip(replayed, seen, strict=True):
        assert all(np.array_equal(a, b) for a, b in zip(one.images, other.images, strict=True))
        np.testing.assert_array_equal(one.increment_covariance, other.increment_covariance)
    assert [len(observation.images) for observation in islice(open_dataset(tmp_path / "out"), 3)] == [1, 1, 1]


def test_faults_are_recorded(tmp_path, unlit):
    faulty = replace(CONFIG, faults=(Dropped(share=0.3),))
    record(faulty, tmp_path / "out", "tum", "jpg")
    frames = json.loads((tmp_path / "out" / "rooms.json").read_text())["frames"]
    assert len(open_dataset(tmp_path / "out")) == len(frames["stamp_ns"]) < 0.85 * len(prepare(CONFIG))
    assert ["dropped"] in frames["faults"].values()


@pytest.mark.parametrize("kidnap", [Kidnap(5.0, 4.0), Kidnap(0.0, 3.0), Kidnap(8.0, 99.0), Kidnap(99.0)], ids=str)
def test_after_a_kidnapping_the_imu_and_the_truth_go_on_with_the_frames(kidnap, unlit):
    take = prepare(replace(CONFIG, faults=(kidnap,)))
    frames = list(take.frames())
    assert np.array_equal(np.unique(take.imu_ns), take.imu_ns)
    assert np.diff(take.imu_ns).max() < 1.5e9 / take.imu_config.rate_hz + 1e9 * take.frame_s
    at = np.searchsorted(take.imu_ns, [frame.stamp_ns for frame in frames])
    assert frames[-1].stamp_ns < take.imu_ns[-1] < frames[-1].stamp_ns + 0.3e9
    off = np.linalg.norm(take.T_W_B[at, :3, 3] - [frame.truth.T_W_B[:3, 3] for frame in frames], axis=1)
    assert off.max() < 0.01


def test_a_fault_that_no_recording_can_hold_is_refused_before_the_walk():
    with pytest.raises(SimError, match=r"fault odometry-nan: recordings hold finite poses only; valid: other faults"):
        prepare(replace(CONFIG, faults=(OdometryNaN(),)))


def test_a_kidnap_after_lost_frames_is_refused_and_before_them_is_not():
    kidnap, dropped = Kidnap(5.0, 4.0), Dropped(0.3)
    with pytest.raises(
        SimError, match=r"fault kidnap comes after dropped, so that IMU data would not fit; valid: before it"
    ):
        prepare(replace(CONFIG, faults=(dropped, kidnap)))
    prepare(replace(CONFIG, faults=(kidnap, dropped)))


@pytest.mark.parametrize("form", ["ros2", "mcap"])
@pytest.mark.parametrize(
    "fault", [OutOfOrder(0.5), Late(), StampJitter(sigma_s=0.2), StampJump(2.0, at_s=5.0)], ids=lambda f: f.name
)
def test_a_bag_is_read_in_the_order_in_which_the_frames_arrive(fault, form, tmp_path, unlit):
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    faulty = replace(CONFIG, faults=(fault,), frame_rate_hz=5.0)
    record(faulty, tmp_path / "out", form)
    with AnyReader([tmp_path / "out" / "bag"], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        odometry = [each for each in reader.connections if each.topic == "/odom"]
        headers = [reader.deserialize(raw, each.msgtype).header.stamp for each, _, raw in reader.messages(odometry)]
    stamps = [10**9 * stamp.sec + stamp.nanosec for stamp in headers]
    assert stamps == [frame.stamp_ns for frame in prepare(faulty).frames()] != sorted(stamps)


def test_the_body_rests_at_the_start_of_the_walk_whichever_frame_arrives_first(unlit):
    take = prepare(replace(CONFIG, faults=(OutOfOrder(1.0),), seed=9))
    frames = list(take.frames())
    rest, walked = frames[: take.rest_frames], frames[take.rest_frames :]
    assert {frame.truth.index for frame in rest} == {0} != {walked[0].truth.index}
    for frame in rest:
        np.testing.assert_allclose(frame.observation.T_O_B, take.walk.odometry.T_O_B[0], atol=1e-9)
        assert frame.stamp_ns < min(each.stamp_ns for each in walked)
    assert sorted(frame.truth.index for frame in walked) == list(range(len(take.walk.tour.stamps)))


@pytest.mark.parametrize(("form", "listed"), [("euroc", "mav0/cam0/data.csv"), ("tum", "rgb.txt")])
def test_frames_of_one_stamp_have_images_of_their_own(form, listed, tmp_path, unlit):
    faulty = replace(CONFIG, faults=(StampJump(2.0, at_s=5.0),))
    record(faulty, tmp_path / "out", form)
    lines = [line for line in (tmp_path / "out" / listed).read_text().splitlines() if not line.startswith("#")]
    names = [line.replace(",", " ").split()[1] for line in lines]
    stamps = [line.replace(",", " ").split()[0] for line in lines]
    assert len(set(names)) == len(names) == len(prepare(faulty)) > len(set(stamps))
    images = (tmp_path / "out" / listed).parent
    assert all((images / name).is_file() or (images / "data" / name).is_file() for name in names)


@pytest.mark.parametrize("fault", [StampJump(1.8e9, at_s=5.0), StampJump(9e9, at_s=5.0), StampJitter(1e9)], ids=str)
@pytest.mark.parametrize("form", FORMATS)
def test_a_stamp_that_not_every_format_can_hold_is_refused(form, fault, tmp_path, unlit):
    with pytest.raises(SimError, match=r"^recording: a frame has the stamp .*; valid: from 0 to below 2147483648 s"):
        record(replace(CONFIG, faults=(fault,), frame_rate_hz=2.0), tmp_path / "out", form)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("form", FORMATS)
def test_a_recording_without_a_single_frame_is_refused(form, tmp_path, unlit):
    with pytest.raises(SimError, match=r"^recording: the faults lose every frame of the walk; valid: a longer walk"):
        record(replace(CONFIG, faults=(StampOffset(100),), frame_rate_hz=2.0), tmp_path / "out", form)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("stamp", [0, 1, EPOCH_NS, 2**31 * 10**9 - 10**6])
def test_every_stamp_that_ros_can_hold_can_be_recorded(stamp):
    seconds = (stamp - EPOCH_NS) / 1e9 - REST_S
    assert abs(stamp_ns(seconds) - stamp) < 200


def fails_at_the_tenth(monkeypatch, error):
    count = []

    def encoded(image, suffix):
        count.append(1)
        if len(count) == 10:
            raise error
        return b"x"

    monkeypatch.setattr("sim.record.tum_rgbd.encoded", encoded)


def test_a_recording_that_fails_leaves_nothing(tmp_path, unlit, monkeypatch):
    fails_at_the_tenth(monkeypatch, RuntimeError("power cut"))
    with pytest.raises(RuntimeError, match="power cut"):
        record(CONFIG, tmp_path / "out", "tum")
    assert not list(tmp_path.iterdir())


@pytest.fixture(scope="module")
def command(tmp_path_factory):
    """The arguments of `lexis-sim record` except the output folder."""
    house = tmp_path_factory.mktemp("house") / "house.json"
    house.write_text(CONFIG.house.to_json())
    return ["record", "--house", str(house), "--length", "13", "--format", "tum", "-o"]


def test_a_full_disk_costs_one_line(command, tmp_path, unlit, monkeypatch, capsys):
    fails_at_the_tenth(monkeypatch, OSError(errno.ENOSPC, "No space left on device"))
    assert main([*command, str(tmp_path / "out")]) == 2
    printed = capsys.readouterr().err
    assert "No space left on device; valid: a place with room" in printed and printed.count("\n") == 1
    monkeypatch.setattr("shutil.disk_usage", lambda path: shutil._ntuple_diskusage(10**9, 10**9, 10**6))
    assert main([*command, str(tmp_path / "out")]) == 2
    assert "1 MB are free" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("storage", "writer", "error"),
    [
        ("sqlite3", "storage_sqlite3.Sqlite3Writer", sqlite3.OperationalError("database or disk is full")),
        ("mcap", "storage_mcap.McapWriter", OSError(errno.ENOSPC, "No space left on device")),
    ],
)
def test_a_bag_on_a_full_disk_is_an_error_of_sim(storage, writer, error, tmp_path, monkeypatch):
    def fails(*_):
        raise error

    monkeypatch.setattr(f"rosbags.rosbag2.{writer}.write", fails)
    with pytest.raises(SimError, match=r"bag: cannot be written: .*valid: a place with room"):
        write_bag(tmp_path, prepare(CONFIG), (), "png", storage)


def test_folders_of_others_are_kept(command, tmp_path, capsys):
    (tmp_path / "thesis.txt").write_text("years of work")
    assert main([*command, str(tmp_path)]) == 2
    assert "holds no rooms.json" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.txt"]


@pytest.mark.parametrize(("form", "images"), [("tum", "raw"), ("kitti", "png")])
def test_unknown_forms_name_the_valid_ones(form, images, tmp_path):
    with pytest.raises(SimError, match="valid: "):
        record(CONFIG, tmp_path / "out", form, images)
    assert not list(tmp_path.iterdir())


def edit(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda mav: (mav / "cam0" / "sensor.yaml").unlink(), r"sensor\.yaml: cannot be read"),
        (lambda mav: edit(mav / "cam0" / "sensor.yaml", "pinhole", "omni"), "camera_model pinhole"),
        (lambda mav: edit(mav / "cam0" / "sensor.yaml", "T_BS", "T_SB"), "T_BS"),
        (lambda mav: (mav / "cam0" / "sensor.yaml").write_text("{"), "is not YAML"),
        (lambda mav: edit(mav / "cam0" / "data.csv", "1000000010100000000", "soon"), r"data\.csv:3: stamp 'soon'"),
        (lambda mav: edit(mav / "cam0" / "data.csv", "1000000010100000000", "1000000010000000000"), "ascending"),
        (lambda mav: (mav / "cam0" / "data" / "1000000010200000000.png").unlink(), r"data\.csv:4: there is no file"),
        (lambda mav: shutil.rmtree(mav / "odom0"), r"odom0/data\.csv: cannot be read"),
        (lambda mav: (mav / "odom0" / "data.csv").write_text("1000000010000000000,1,2,3\n"), "4 columns"),
    ],
)
def test_defects_of_euroc_are_named(damage, says, recordings, tmp_path):
    shutil.copytree(recordings("euroc", "png") / "mav0", tmp_path / "mav0")
    damage(tmp_path / "mav0")
    with pytest.raises(LexisError, match=says) as error:
        open_dataset(tmp_path)
    assert "\n" not in str(error.value)


def test_another_odometry_is_read_by_name(recordings):
    """Uses the true states as odometry: any source of poses works."""
    folder = recordings("euroc", "png")
    dataset = open_dataset(folder, DatasetConfig(odometry="state_groundtruth_estimate0"))
    take = prepare(CONFIG)
    np.testing.assert_allclose(dataset.T_O_B[REST:], take.walk.tour.T_W_B, atol=2e-3)  # within one sample of the IMU
    assert open_dataset(folder, DatasetConfig(camera="cam1")).camera.T_B_C[1, 3] == pytest.approx(-0.11)


def test_distorted_images_are_rectified(recordings, tmp_path):
    """A distortion in the calibration is removed from the images, so that they become pinhole images."""
    shutil.copytree(recordings("euroc", "png") / "mav0", tmp_path / "mav0")
    edit(tmp_path / "mav0" / "cam0" / "sensor.yaml", "[0.0, 0.0, 0.0, 0.0]", "[-0.2, 0.05, 0.0, 0.0]")
    path = next((tmp_path / "mav0" / "cam0" / "data").iterdir())
    given = next(iter(open_dataset(tmp_path))).image
    k = FRONT.intrinsics
    expected = cv2.undistort(cv2.imread(str(min(path.parent.iterdir()))), k.matrix, np.array([-0.2, 0.05, 0.0, 0.0]))
    assert np.abs(given[..., ::-1].astype(int) - expected).mean() < 1.0


def test_bags_without_a_topic_or_that_are_none_are_named(recordings, tmp_path):
    with pytest.raises(LexisError, match="cameras 'cam0,/cam0'; valid: different names"):
        open_dataset(recordings("mcap", "png"), DatasetConfig(camera="cam0,/cam0"))
    with pytest.raises(LexisError, match="no topic /gps; it holds /cam0"):
        open_dataset(recordings("mcap", "png"), DatasetConfig(odometry="/gps"))
    (tmp_path / "metadata.yaml").write_text("rosbag2_bagfile_information: 3")
    with pytest.raises(LexisError, match="not a readable bag"):
        open_dataset(tmp_path)


def test_poses_of_files_are_the_session_s(recordings):
    odometry = np.array(csv_rows(recordings("euroc", "png") / "mav0" / "odom0" / "data.csv")[1], float)
    take = prepare(CONFIG)
    np.testing.assert_allclose(poses_of(odometry[REST:, [1, 2, 3, 5, 6, 7, 4]]), take.walk.odometry.T_O_B, atol=1e-11)
