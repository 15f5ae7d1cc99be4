"""Recorded runs in three formats: TUM RGB-D, EuRoC ASL, and ROS 2 bags. The format is recognised by the folder's contents.

`lexis.datasets.tum_rgbd`, `lexis.datasets.euroc` and `lexis.datasets.ros2` document which files and topics are read.
Everything but the pixels is checked when a dataset is opened.
"""

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from jaxtyping import Float64

from lexis.datasets.euroc import SENSORS, is_euroc, read_euroc
from lexis.datasets.recorded import DatasetConfig, Recorded, odometry_at
from lexis.datasets.ros2 import METADATA, is_bag, read_bag
from lexis.datasets.tum_rgbd import CAMERA, IMAGE_LIST, ODOMETRY, read_tum_dataset, write_dataset
from lexis.errors import DatasetError
from lexis.files.temporary_folder import recover
from lexis.maths.se3 import between, rotation_angle
from lexis.types import Camera, Observation, Poses

__all__ = ["Dataset", "DatasetConfig", "assumed_covariances", "open_dataset", "write_dataset"]

TURNING_M = 0.3
"""In assumed odometry covariances, a rotation by one radian counts as much as this length of path [m/rad]."""


@dataclass(frozen=True, eq=False)
class Dataset:
    """A recorded run. Iteration over the run yields observations; each image is read only when its observation is due.

    The arrays of an observation are copies, so that a SLAM may write into them.
    """

    directory: Path
    recorded: Recorded = field(repr=False)
    T_O_B: Poses = field(repr=False)
    """Odometry poses at the stamps of the images."""
    increment_covariances: Float64[np.ndarray, "n 6 6"] = field(repr=False)

    @property
    def camera(self) -> Camera:
        """The camera that took the images, with the others of its rig."""
        return self.recorded.seen.camera

    @property
    def stamps(self) -> Float64[np.ndarray, "n"]:
        """Stamps of the images [s]."""
        return self.recorded.seen.stamps

    def __len__(self) -> int:
        return len(self.stamps)

    def __iter__(self) -> Iterator[Observation]:
        for i, (image, *others) in enumerate(self.recorded.seen.images()):
            stamp, covariance = float(self.stamps[i]), self.increment_covariances[i].copy()
            yield Observation(i, stamp, image, self.T_O_B[i].copy(), covariance, tuple(others))


def open_dataset(directory: Path | str, config: DatasetConfig | None = None) -> Dataset:
    """Open a recorded run. Raises LexisError, with file and line, if it is incomplete or inconsistent."""
    directory, config = Path(directory), config or DatasetConfig()
    recover(directory)
    _check_contents(directory, config)
    if is_euroc(directory):
        recorded = read_euroc(directory, config)
    elif is_bag(directory):
        recorded = read_bag(directory, config)
    else:
        recorded = read_tum_dataset(directory, config)
    poses = odometry_at(recorded.odometry, recorded.seen.stamps, config.max_odometry_gap_s)
    covariances = recorded.increment_covariances
    return Dataset(directory, recorded, poses, assumed_covariances(poses, config) if covariances is None else covariances)


def _check_contents(directory: Path, config: DatasetConfig) -> None:
    """Raise DatasetError unless `directory` is a folder with the files by which one of the formats is recognised."""
    valid = (
        f"valid: a folder with {IMAGE_LIST}, {ODOMETRY} and {CAMERA} (TUM RGB-D), with {SENSORS} (EuRoC), or with "
        f"{METADATA} (ROS 2 bag); see lexis run --help"
    )
    needed = (IMAGE_LIST, config.odometry or ODOMETRY, config.camera or CAMERA)
    try:
        empty = not os.listdir(directory)
        other = is_euroc(directory) or is_bag(directory)
        missing = [name for name in needed if not (directory / name).exists()]
    except NotADirectoryError:
        raise DatasetError(f"{directory}: is a file and not a dataset; {valid}") from None
    except OSError as error:
        raise DatasetError(f"{directory}: no dataset there: {error.strerror}; {valid}") from None
    if other or not missing:
        return
    for setting, name, usual in (("odometry", config.odometry, ODOMETRY), ("camera", config.camera, CAMERA)):
        if name in missing and IMAGE_LIST not in missing:
            raise DatasetError(
                f"{directory}: holds no {name}; valid: the {setting}'s one file in TUM RGB-D, such as {usual}"
            )
    what = "is empty" if empty else f"holds no {', no '.join(missing)}"
    raise DatasetError(f"{directory}: {what}; {valid}")


def assumed_covariances(T_O_B: Poses, config: DatasetConfig) -> Float64[np.ndarray, "n 6 6"]:
    """Return covariances to assume for the odometry's increments between images, if the dataset has none.

    The drift of the odometry is modelled as a random walk, so the covariances grow in proportion to the path length and the
    rotation. The covariance of the first image is 0.
    """
    increments = between(T_O_B[:-1], T_O_B[1:])
    path = np.linalg.norm(increments[:, :3, 3], axis=1) + rotation_angle(increments) * TURNING_M
    variances = np.repeat([config.rotation_sigma**2, config.translation_sigma**2], 3)
    scaled = np.concatenate([[0.0], path])[:, None] * variances
    return np.asarray(scaled[:, :, None] * np.eye(6))
