"""EuRoC recordings: defects are reported in one line, before any image is read."""

import os
import shutil
import zlib

import numpy as np
import pytest
from helpers.small_inputs import CAMERA, FRAMES, write_euroc_run, write_tum_run

from lexis.datasets.dataset import DatasetConfig, open_dataset
from lexis.datasets.image_header import image_size
from lexis.errors import LexisError
from lexis.maths.se3 import between, exp, inverse, log


@pytest.fixture
def folder(tmp_path):
    write_euroc_run(tmp_path / "run")
    return tmp_path / "run"


def edited(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def test_the_whole_recording_is_read(folder):
    dataset = open_dataset(folder)
    assert [seen.image.shape for seen in dataset] == [(24, 32, 3)] * FRAMES
    np.testing.assert_allclose(dataset.camera.T_B_C, CAMERA.T_B_C)


def with_second_camera(folder, skipped=()):
    """Add a camera cam1 that looks back and lacks the images `skipped`."""
    sensors = folder / "mav0"
    shutil.copytree(sensors / "cam0", sensors / "cam1")
    lines = (sensors / "cam1" / "data.csv").read_text().splitlines(keepends=True)
    images = [line for line in lines if not line.startswith("#")]
    kept = [line for line in lines if line not in [images[i] for i in skipped]]
    (sensors / "cam1" / "data.csv").write_text("".join(kept))
    (sensors / "cam1" / "sensor.yaml").write_text((sensors / "cam1" / "sensor.yaml").read_text().replace("0.3", "0.4"))


def test_cameras_that_are_named_make_a_rig(folder):
    with_second_camera(folder)
    dataset = open_dataset(folder, DatasetConfig(camera="cam0, cam1"))
    assert [camera.T_B_C[2, 3] for camera in dataset.camera.rig] == [0.3, 0.4]
    assert [len(seen.images) for seen in dataset] == [2] * FRAMES
    assert len(open_dataset(folder).camera.rig) == 1


def test_an_image_that_another_camera_lacks_is_left_out(folder):
    with_second_camera(folder, skipped=[1])
    alone, both = open_dataset(folder), open_dataset(folder, DatasetConfig(camera="cam0,cam1"))
    np.testing.assert_array_equal(both.stamps, np.delete(alone.stamps, 1))
    kept = [seen.image for i, seen in enumerate(alone) if i != 1]
    assert all(np.array_equal(seen.image, image) for seen, image in zip(both, kept, strict=True))


def test_cameras_without_a_common_time_or_named_twice_are_refused(folder):
    with_second_camera(folder)
    image = next((folder / "mav0" / "cam1" / "data").iterdir()).name
    (folder / "mav0" / "cam1" / "data.csv").write_text(f"1,{image}\n")
    with pytest.raises(LexisError, match=r"cam1.*: have no stamp in common"):
        open_dataset(folder, DatasetConfig(camera="cam0,cam1"))
    with pytest.raises(LexisError, match="valid: different names, separated by commas"):
        open_dataset(folder, DatasetConfig(camera="cam0,cam0"))


def test_poses_and_covariances_of_a_sensor_beside_the_body_are_converted_to_the_body(folder):
    T_B_S = exp(np.array([0.2, -0.5, 1.0, 0.6, -0.3, 0.4]))
    covariance = np.diag([1e-4, 4e-4, 9e-4, 1e-2, 4e-2, 9e-2])
    path = folder / "mav0" / "odom0" / "data.csv"
    lines = [line.split(",")[:8] for line in path.read_text().splitlines()[1:]]
    path.write_text("".join(",".join([*line, *map(repr, covariance.ravel().tolist())]) + "\n" for line in lines))
    of_sensor = list(open_dataset(folder))
    (folder / "mav0" / "odom0" / "sensor.yaml").write_text(f"T_BS:\n  data: {T_B_S.ravel().tolist()}\n")
    of_body = list(open_dataset(folder))
    for i in range(1, FRAMES):
        increment = between(of_sensor[i - 1].T_O_B, of_sensor[i].T_O_B)
        body_increment = between(of_body[i - 1].T_O_B, of_body[i].T_O_B)
        np.testing.assert_allclose(body_increment, T_B_S @ increment @ inverse(T_B_S), atol=1e-12)
        # Small errors of the sensor's increment, one in each direction, and the errors of the body's increment they lead to.
        disturbed = T_B_S @ increment @ exp(1e-6 * np.eye(6)) @ inverse(T_B_S)
        errors = log(inverse(body_increment) @ disturbed).T / 1e-6
        np.testing.assert_allclose(of_body[i].increment_covariance, errors @ covariance @ errors.T, atol=1e-6)


def sensor(old, new):
    return lambda folder: edited(folder / "mav0" / "cam0" / "sensor.yaml", old, new)


def listed(old, new):
    return lambda folder: edited(folder / "mav0" / "cam0" / "data.csv", old, new)


def odometry(old, new):
    return lambda folder: edited(folder / "mav0" / "odom0" / "data.csv", old, new)


def cut(columns):
    """Leave so many columns of the odometry, or add columns of zeros."""

    def damage(folder):
        path = folder / "mav0" / "odom0" / "data.csv"
        lines = [[*line.split(","), "0", "0"][:columns] for line in path.read_text().splitlines()]
        path.write_text("\n".join(map(",".join, lines)))

    return damage


def far_away(folder):
    path = folder / "mav0" / "odom0" / "data.csv"
    lines = [line.split(",") for line in path.read_text().splitlines()]
    lines[2][1] = "1e155"
    path.write_text("\n".join(map(",".join, lines)))


def only_comments(folder, name):
    (folder / "mav0" / name / "data.csv").write_text("#timestamp\n# nothing\n")


def piped(folder, path):
    (folder / "mav0" / path).unlink()
    os.mkfifo(folder / "mav0" / path)


K, RESOLUTION, STAMP = "[0.1, 0.01, 0.0, 0.0]", "[32, 24]", "100100000000"
MERGES = "".join(f"m{i}: &m{i} {{<<: [{', '.join([f'*m{i - 1}'] * 9)}]}}\n" for i in range(1, 12))


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda folder: only_comments(folder, "cam0"), r"cam0/data\.csv: is empty"),
        (lambda folder: only_comments(folder, "odom0"), r"odom0/data\.csv: is empty"),
        (listed(f"{STAMP},", "9" * 5000 + ","), r"cam0/data\.csv:3: stamp '99.*; valid: whole nanoseconds"),
        (odometry(STAMP, "9" * 5000), r"odom0/data\.csv:3: stamp '99.*; valid: whole nanoseconds"),
        (odometry(STAMP, "٣" * 12), r"odom0/data\.csv:3: stamp"),
        (cut(7), r"odom0/data\.csv:2: 7 columns; valid: at least 8"),
        (cut(29), r"odom0/data\.csv:2: 29 columns; valid: 8, 17 as in EuRoC's ground truth, or 44 with"),
        (cut(43), r"odom0/data\.csv:2: 43 columns; valid: 8, 17"),
        (cut(46), r"odom0/data\.csv:2: 46 columns; valid: 8, 17"),
        (far_away, r"odom0/data\.csv: pose 1 at 100\.1 s lies beyond 1e\+08 m"),
        (sensor(RESOLUTION, "[.inf, 24]"), "could not convert string to float"),
        (sensor(RESOLUTION, "[inf, 24]"), "cannot convert float infinity"),
        (sensor(RESOLUTION, "[1000000, 1000000]"), "at most 50 megapixels"),
        (sensor(RESOLUTION, "32"), "not a list of numbers"),
        (sensor(RESOLUTION, "[[32, 24], {a: b}]"), "sensor.yaml: cannot be used"),
        (sensor(RESOLUTION, "[" * 3000), "is not YAML"),
        (sensor(RESOLUTION, f"{RESOLUTION}\nm0: &m0 {{k: v}}\n{MERGES}"), "aliases are not read"),
        (sensor(K, "[0.1, 0.01, 0.0]"), "distortion .*; valid: 0, 4, 5, 8, 12, 14 finite coefficients"),
        (sensor(K, "[nan, 0.01, 0.0, 0.0]"), "distortion .*; valid: .* finite coefficients"),
        (sensor(K, "[1e300, 0.01, 0.0, 0.0]"), "distortion .*; valid: .* finite coefficients"),
        (lambda folder: piped(folder, "cam0/sensor.yaml"), "is a device or a pipe"),
        (lambda folder: piped(folder, "odom0/data.csv"), "is a device or a pipe"),
        (sensor("intrinsics", "intrinsic"), "cam0/sensor.yaml: cannot be used: there is no intrinsics; valid: a camera's"),
        (sensor("T_BS:", "T_BS: none\nT_SB:"), "cannot be used: none has no entry data; valid: a camera's"),
        (sensor("T_BS", "T_SB"), r"cam0/sensor\.yaml: cannot be used: there is no T_BS; valid: a camera's calibration"),
        (lambda folder: edited(folder / "mav0/odom0/sensor.yaml", "T_BS", "T_SB"), "there is no T_BS; valid: a sensor's"),
        (lambda folder: edited(folder / "mav0/odom0/sensor.yaml", "[1.0,", "[7.0,"), "T_BS is not a rigid motion"),
    ],
)
def test_defects_are_named(folder, damage, says):
    damage(folder)
    with pytest.raises(LexisError, match=says) as error:
        open_dataset(folder)
    assert "\n" not in str(error.value)


def test_an_image_that_states_gigapixels_is_not_decoded(tmp_path, monkeypatch):
    write_tum_run(tmp_path / "run")
    path = tmp_path / "run" / "rgb" / "000001.png"
    content, head = path.read_bytes(), b"IHDR" + (40_000).to_bytes(4) * 2 + b"\x08\x02\x00\x00\x00"
    path.write_bytes(content[:12] + head + zlib.crc32(head).to_bytes(4) + content[33:])
    assert image_size(path.read_bytes()) == (40_000, 40_000)
    images = iter(open_dataset(tmp_path / "run"))
    next(images)
    monkeypatch.setattr("cv2.imdecode", lambda *_: pytest.fail("decoded"))
    with pytest.raises(LexisError, match=r"000001\.png: is 40000x40000 px; valid: 32x24 px"):
        next(images)


@pytest.mark.parametrize("columns", [8, 17])
def test_without_covariances_they_are_assumed(folder, columns):
    cut(columns)(folder)
    assert open_dataset(folder).recorded.increment_covariances is None
