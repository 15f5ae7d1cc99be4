"""Recorded runs: a folder of images and an odometry, as TUM RGB-D datasets are laid out.

    rgb.txt                    lines of "stamp file"; # begins a comment
    odometry.tum               lines of "stamp tx ty tz qx qy qz qw": T_O_B, at any rate over the same time
    camera.json                width, height, fx, fy, cx, cy [px] and T_B_C, row by row
    odometry_covariance.txt    optional: per image, "stamp" and the 36 numbers of the covariance of the odometry's increment
                               since the image before, rotation first [rad², m²]

Images are 8-bit PNG or JPEG without distortion. Everything but the pixels is checked when the dataset is opened.
"""

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from jaxtyping import Float64

from lexis.camera_io import CameraData
from lexis.dataset_files import (
    CAMERA,
    COVARIANCE,
    IMAGE_LIST,
    ODOMETRY,
    odometry_at,
    read_camera,
    read_covariances,
    read_image,
    read_image_list,
    write_image,
)
from lexis.errors import DatasetError
from lexis.files import replaced_folder
from lexis.se3 import between, rotation_angle
from lexis.tum import write_tum
from lexis.types import Camera, Observation, Pose, Poses

TURNING_M = 0.3
"""Path that turning by one radian on the spot counts as [m/rad]."""


@dataclass(frozen=True)
class DatasetConfig:
    """What a dataset leaves unsaid."""

    max_odometry_gap_s: float = 0.5
    """Longest time over which the odometry is interpolated to an image's stamp [s]."""
    rotation_sigma: float = 0.003
    """Without covariances: drift of orientation per square root of path [rad/√m]."""
    translation_sigma: float = 0.015
    """Without covariances: drift of position per square root of path [m/√m]."""


@dataclass(frozen=True, eq=False)
class Dataset:
    """A recorded run; iterating reads one image at a time."""

    directory: Path
    camera: Camera
    stamps: Float64[np.ndarray, "n"]
    """Of the images [s]."""
    images: tuple[Path, ...] = field(repr=False)
    T_O_B: Poses = field(repr=False)
    """Odometry at the images' stamps."""
    increment_covariances: Float64[np.ndarray, "n 6 6"] = field(repr=False)

    def __len__(self) -> int:
        return len(self.images)

    def __iter__(self) -> Iterator[Observation]:
        for i, path in enumerate(self.images):
            image = read_image(path, self.camera)
            yield Observation(i, float(self.stamps[i]), image, self.T_O_B[i], self.increment_covariances[i])


def open_dataset(directory: Path, config: DatasetConfig | None = None) -> Dataset:
    """Open a recorded run. Raises LexisError, naming file and line, where it is incomplete or contradicts itself."""
    config = config or DatasetConfig()
    if not os.path.isdir(directory):
        raise DatasetError(f"{directory}: no dataset there; valid: a folder with {IMAGE_LIST}, {ODOMETRY} and {CAMERA}")
    camera = read_camera(directory / CAMERA)
    stamps, images = read_image_list(directory)
    poses = odometry_at(directory / ODOMETRY, stamps, config.max_odometry_gap_s)
    covariances = read_covariances(directory / COVARIANCE, stamps)
    if covariances is None:
        covariances = assumed_covariances(poses, config)
    return Dataset(directory, camera, stamps, images, poses, covariances)


def write_dataset(directory: Path, camera: Camera, observations: Iterable[Observation]) -> None:
    """Record observations, images as PNG; the folder appears whole or not at all. Raises LexisError."""
    with replaced_folder(directory, IMAGE_LIST) as folder:
        (folder / "rgb").mkdir()
        (folder / CAMERA).write_text(CameraData.of(camera).model_dump_json(indent=1) + "\n", encoding="utf-8")
        stamps: list[float] = []
        poses: list[Pose] = []
        with open(folder / IMAGE_LIST, "w") as images, open(folder / COVARIANCE, "w") as covariances:
            images.write("# stamp [s], file\n")
            covariances.write("# stamp [s], 6x6 row by row\n")
            for observation in observations:
                name = f"rgb/{len(stamps):06d}.png"
                write_image(folder / name, observation.image)
                images.write(f"{observation.stamp:.6f} {name}\n")
                row = " ".join(f"{value:.9e}" for value in observation.increment_covariance.ravel())
                covariances.write(f"{observation.stamp:.6f} {row}\n")
                stamps.append(observation.stamp)
                poses.append(observation.T_O_B)
        write_tum(folder / ODOMETRY, stamps, np.array(poses).reshape(-1, 4, 4))


def assumed_covariances(T_O_B: Poses, config: DatasetConfig) -> Float64[np.ndarray, "n 6 6"]:
    """Covariances of increments that grow with the path, as a random walk; turning on the spot counts as path too."""
    increments = between(T_O_B[:-1], T_O_B[1:])
    path = np.linalg.norm(increments[:, :3, 3], axis=1) + rotation_angle(increments) * TURNING_M
    variances = np.repeat([config.rotation_sigma**2, config.translation_sigma**2], 3)
    scaled = np.concatenate([[0.0], path])[:, None] * variances
    return np.asarray(scaled[:, :, None] * np.eye(6))
