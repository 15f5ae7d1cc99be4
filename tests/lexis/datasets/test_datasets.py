"""Recorded runs: reading inverts writing, odometry at other rates is interpolated, defects are reported with their line."""

import errno
import shutil

import cv2
import numpy as np
import pytest

from lexis.datasets.dataset import DatasetConfig, assumed_covariances, open_dataset, write_dataset
from lexis.errors import DatasetError, LexisError
from lexis.files.tum_trajectory import read_tum, write_tum
from lexis.maths.se3 import between, exp
from lexis.types import Camera, Intrinsics, Observation

T_B_C = np.array([[0, 0, 1, 0.1], [-1, 0, 0, 0], [0, -1, 0, 0.3], [0, 0, 0, 1.0]])
CAMERA = Camera(Intrinsics(32, 24, 20.0, 20.0, 15.5, 11.5), T_B_C)


def observations(rng, n=6):
    pose = np.eye(4)
    for i in range(n):
        root = rng.normal(0.0, 0.01, (6, 6))
        image = rng.integers(0, 256, (24, 32, 3), dtype=np.uint8)
        yield Observation(i, 100.0 + 0.1 * i, image, pose, root @ root.T)
        pose = pose @ exp(np.array([0.0, 0.02, 0.1, 0.2, 0.0, 0.0]))


@pytest.fixture
def recorded(rng, tmp_path):
    """The folder of a dataset, and the observations that were written to it."""
    written = list(observations(rng))
    write_dataset(tmp_path / "run", CAMERA, written)
    return tmp_path / "run", written


def test_reading_gives_back_what_was_recorded(recorded):
    folder, written = recorded
    dataset = open_dataset(folder)
    assert len(dataset) == len(written)
    assert dataset.camera.intrinsics == CAMERA.intrinsics
    np.testing.assert_array_equal(dataset.camera.T_B_C, CAMERA.T_B_C)
    for read, expected in zip(dataset, written, strict=True):
        assert (read.index, read.stamp) == (expected.index, pytest.approx(expected.stamp))
        np.testing.assert_array_equal(read.image, expected.image)
        np.testing.assert_allclose(read.T_O_B, expected.T_O_B, atol=1e-11)
        np.testing.assert_array_equal(read.increment_covariance, expected.increment_covariance)


def test_a_folder_may_be_named_by_a_string(recorded):
    folder = recorded[0]
    by_string = open_dataset(str(folder))
    assert by_string.directory == folder and len(list(by_string)) == len(list(open_dataset(folder)))


def test_what_a_slam_writes_into_an_observation_does_not_change_the_recording(recorded):
    dataset = open_dataset(recorded[0])
    first = [(observation.T_O_B.copy(), observation.increment_covariance.copy()) for observation in dataset]
    for observation in dataset:
        observation.T_O_B[:], observation.increment_covariance[:] = 7.0, 7.0
    for (T_O_B, covariance), observation in zip(first, dataset, strict=True):
        np.testing.assert_array_equal(observation.T_O_B, T_O_B)
        np.testing.assert_array_equal(observation.increment_covariance, covariance)


def test_odometry_of_another_rate_is_interpolated(recorded):
    """For motion at constant rate, the poses in between are known exactly and positions lie on a straight line."""
    folder, _ = recorded
    stamps, poses = read_tum(folder / "odometry.tum")
    write_tum(folder / "odometry.tum", np.append(stamps - 0.05, stamps[-1] + 0.05), np.concatenate([poses, poses[-1:]]))
    middle = list(open_dataset(folder))[2].T_O_B
    np.testing.assert_allclose(
        between(poses[2], middle)[:3, :3], exp(np.array([0.0, 0.01, 0.05, 0, 0, 0]))[:3, :3], atol=1e-6
    )
    np.testing.assert_allclose(middle[:3, 3], (poses[2] + poses[3])[:3, 3] / 2, atol=1e-6)


def test_without_covariances_drift_grows_with_the_root_of_the_path(recorded):
    folder, _ = recorded
    (folder / "odometry_covariance.txt").unlink()
    assumed = np.array([observation.increment_covariance for observation in open_dataset(folder)])
    np.testing.assert_array_equal(assumed, assumed_covariances(open_dataset(folder).T_O_B, DatasetConfig()))
    assert (assumed[0] == 0).all()
    far = assumed_covariances(np.stack([np.eye(4), exp(np.array([0, 0, 0, 4.0, 0, 0]))]), DatasetConfig())
    np.testing.assert_allclose(np.sqrt(np.diag(far[1])), [0.006] * 3 + [0.03] * 3)


@pytest.mark.parametrize("setting", ["max_odometry_gap_s", "rotation_sigma", "translation_sigma"])
def test_a_setting_for_reading_is_refused_by_name(setting):
    with pytest.raises(DatasetError, match=f"dataset.{setting} is -1.0; valid: >"):
        DatasetConfig(**{setting: -1.0})


def edited(folder, name, old, new):
    text = (folder / name).read_text()
    assert old in text
    (folder / name).write_text(text.replace(old, new, 1))


def shuffle_stamps(folder):
    edited(folder, "rgb.txt", "100.200000", "100.050000")


def too_small(folder):
    cv2.imwrite(str(folder / "rgb" / "000003.png"), np.zeros((12, 16, 3), np.uint8))


def outside(folder):
    (folder / "odometry_covariance.txt").unlink()
    edited(folder, "rgb.txt", "100.500000", "107.000000")


def gap(folder):
    stamps, poses = read_tum(folder / "odometry.tum")
    write_tum(folder / "odometry.tum", stamps[[0, -1]] + [-0.1, 0.1], poses[[0, -1]])


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda f: shutil.rmtree(f), "no dataset there"),
        (lambda f: (f / "camera.json").unlink(), r"camera\.json"),
        (lambda f: edited(f, "camera.json", '"fx": 20.0', '"fx": -1'), "fx"),
        (lambda f: edited(f, "camera.json", '"fx": 20.0', '"distortion": [1e5, 0, 0, 0], "fx": 20.0'), "distortion"),
        (lambda f: (f / "rgb.txt").write_text("# nothing\n"), "lists no image"),
        (shuffle_stamps, r"rgb\.txt:4: .*ascending"),
        (lambda f: edited(f, "rgb.txt", "rgb/000001.png", "../../etc/passwd"), r"rgb\.txt:3: .*inside the dataset"),
        (lambda f: edited(f, "rgb.txt", "rgb/000001.png", "/etc/shadow.png"), "inside the dataset"),
        (lambda f: edited(f, "rgb.txt", "100.100000 ", "soon "), r"rgb\.txt:3: .*stamp"),
        (lambda f: (f / "rgb" / "000004.png").unlink(), r"rgb\.txt:6: there is no file"),
        (outside, "covers 100.0 s to 100.5 s, but image 5 is at 107.0 s"),
        (gap, "a gap of 0.700 s around image 0"),
        (lambda f: edited(f, "odometry_covariance.txt", "100.200000", "100.210000"), r"odometry_covariance\.txt:4"),
        (lambda f: edited(f, "odometry_covariance.txt", "\n100.5", "\n#"), "5 covariances"),
        (too_small, "16x12 px.*32x24 px"),
        (lambda f: (f / "rgb" / "000003.png").write_bytes(b"no image"), "not a readable"),
    ],
)
def test_defects_are_named(recorded, damage, says):
    folder, _ = recorded
    damage(folder)
    with pytest.raises(LexisError, match=says) as error:
        list(open_dataset(folder))
    assert "\n" not in str(error.value)


def empty(folder):
    shutil.rmtree(folder)
    folder.mkdir()


def a_file(folder):
    shutil.rmtree(folder)
    folder.write_text("no folder")


def forbidden(folder):
    raise PermissionError(errno.EACCES, "Permission denied", str(folder))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (shutil.rmtree, "run: no dataset there: No such file or directory; valid: a folder with rgb.txt, odometry.tum and"),
        (empty, r"run: is empty; valid: .* with mav0 \(EuRoC\), or with metadata.yaml \(ROS 2 bag\)"),
        (a_file, "run: is a file and not a dataset; valid: a folder with rgb.txt"),
        (lambda f: (f / "camera.json").unlink(), "run: holds no camera.json; valid: a folder with"),
        (lambda f: [(f / n).unlink() for n in ("rgb.txt", "odometry.tum")], "run: holds no rgb.txt, no odometry.tum; valid"),
    ],
)
def test_a_folder_that_is_no_dataset_is_told_what_one_must_hold(recorded, change, says):
    folder, _ = recorded
    change(folder)
    with pytest.raises(DatasetError, match=says) as error:
        open_dataset(folder)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(("setting", "usual"), [("camera", "camera.json"), ("odometry", "odometry.tum")])
@pytest.mark.parametrize("name", ["cam0", "cam0,cam1", "lost.txt"])
def test_a_name_that_a_folder_of_tum_rgbd_lacks_is_told_from_a_wrong_folder(recorded, setting, usual, name):
    says = f"run: holds no {name}; valid: the {setting}'s one file in TUM RGB-D, such as {usual}$"
    with pytest.raises(DatasetError, match=says):
        open_dataset(recorded[0], DatasetConfig(**{setting: name}))


def test_a_folder_that_may_not_be_read_is_named(recorded, monkeypatch):
    monkeypatch.setattr("os.listdir", forbidden)
    with pytest.raises(DatasetError, match="run: no dataset there: Permission denied; valid: a folder with"):
        open_dataset(recorded[0])


def test_a_recording_that_breaks_off_leaves_nothing(rng, tmp_path):
    def breaks_off():
        yield from observations(rng, 3)
        raise RuntimeError("the robot fell over")

    with pytest.raises(RuntimeError, match="fell over"):
        write_dataset(tmp_path / "run", CAMERA, breaks_off())
    assert not list(tmp_path.iterdir())
