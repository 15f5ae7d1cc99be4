"""Writes runs as ROS 2 bags of standard messages. Package `rosbags` is used for this; ROS is not needed.

Topics are named as in EuRoC's bags. `lexis.datasets.ros2` lists the topics that LEXIS reads. The other topics are
`/cam1/...`, `/imu0` and `/ground_truth/pose`, which holds the true poses.
"""

import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from lexis.datasets.ros2 import ODOMETRY
from lexis.maths.quaternions import pose_rows
from lexis.maths.se3 import between, compose_covariance
from lexis.types import Observation
from sim.errors import SimError
from sim.record.messages import Messages
from sim.record.settings import write_settings
from sim.record.take import RecordedFrame, Take
from sim.render.image_files import SUFFIXES, encoded

if TYPE_CHECKING:
    from rosbags.rosbag2 import Writer

_VERSION: Literal[8] = 8
"""Version of the format of the bag's metadata. Every supported ROS 2 release can read this version."""


def write_bag(folder: Path, take: Take, frames: Iterable[RecordedFrame], images: str, storage: str = "sqlite3") -> None:
    """Write a take (the sensor data of one walk) as a bag in `folder / "bag"`. `storage` is sqlite3 or mcap.

    Settings files of other SLAM systems are written beside the bag. Raises `SimError` if `rosbags` is not installed, or if a
    file cannot be written, for example because the disk is full.
    """
    messages = Messages.load()
    with _writer(folder / "bag", storage) as writer:
        write_settings(folder / "settings", take)
        bag = _Bag(writer, messages)
        start = int(take.imu_ns[0])
        bag.write(start, "/tf_static", messages.static_transforms(start, take.cameras))
        imu = _Inertial(take, bag)
        odometry = _Odometry(bag)
        arrival_ns = 0
        for frame in frames:
            # A frame that arrives late, or with an earlier stamp, is read after those that arrived before it.
            arrival_ns = max(arrival_ns + 1, frame.stamp_ns)
            imu.until(arrival_ns)
            _write_images(bag, take, frame, images, arrival_ns)
            odometry.write(frame.stamp_ns, arrival_ns, frame.observation)
        imu.until(int(take.imu_ns[-1]))


@contextmanager
def _writer(path: Path, storage: str) -> Iterator["Writer"]:
    from rosbags.rosbag2 import StoragePlugin, Writer

    try:
        with Writer(path, version=_VERSION, storage_plugin=StoragePlugin[storage.upper()]) as writer:
            yield writer
    except (sqlite3.Error, OSError) as error:
        raise SimError(f"{path}: cannot be written: {error}; valid: a place with room for it") from None


class _Bag:
    """Writes messages to their topics. A topic is added to the bag at its first message.

    A bag is read and played in the order of the times of arrival, which may differ from the stamps in the messages.
    """

    def __init__(self, writer: "Writer", messages: Messages) -> None:
        self._writer, self.messages = writer, messages
        self._connections: dict[str, Any] = {}

    def write(self, arrival_ns: int, topic: str, message: Any) -> None:
        """Write a message to a topic, with its time of arrival [ns]."""
        kind = message.__msgtype__
        if topic not in self._connections:
            qos = self.messages.latched if topic == "/tf_static" else ()
            self._connections[topic] = self._writer.add_connection(
                topic, kind, typestore=self.messages.types, offered_qos_profiles=qos
            )
        data = self.messages.types.serialize_cdr(message, kind)
        self._writer.write(self._connections[topic], arrival_ns, data)


class _Inertial:
    """Writes IMU measurements and true poses in turn with the frames, so that messages are in the order of their stamps."""

    def __init__(self, take: Take, bag: _Bag) -> None:
        self._take, self._bag = take, bag
        self._truth = pose_rows(take.T_W_B)
        self._next = 0

    def until(self, stamp_ns: int) -> None:
        """Write the IMU measurements and true poses that are not written yet, up to and including `stamp_ns`."""
        imu, config = self._take.imu, self._take.imu_config
        end = int(np.searchsorted(self._take.imu_ns, stamp_ns, side="right"))
        for k in range(self._next, end):
            stamp = int(self._take.imu_ns[k])
            message = self._bag.messages.imu(stamp, imu.angular_velocity[k], imu.specific_force[k], config)
            self._bag.write(stamp, "/imu0", message)
            if self._take.with_truth:
                self._bag.write(stamp, "/ground_truth/pose", self._bag.messages.pose(stamp, self._truth[k]))
        self._next = max(end, self._next)


class _Odometry:
    """Writes the odometry as two messages: a standard message, and the covariance that LEXIS needs.

    LEXIS needs the covariance of the increment since the last message. The standard message contains the covariance of the
    pose, and the covariance of the increment only in a scaled and reordered form, from which LEXIS could not restore it bit
    by bit. The exact covariance of the increment is therefore written to a topic of its own.
    """

    def __init__(self, bag: _Bag) -> None:
        self._bag = bag
        self._last: Observation | None = None
        self._covariance = np.zeros((6, 6))

    def write(self, stamp_ns: int, arrival_ns: int, seen: Observation) -> None:
        """Write the odometry of one observation. The covariance of its pose is composed from the increments so far."""
        increment, seconds = np.eye(4), 0.0
        if self._last is not None:
            increment, seconds = between(self._last.T_O_B, seen.T_O_B), seen.stamp - self._last.stamp
            self._covariance = compose_covariance(self._covariance, increment, seen.increment_covariance)
        message = self._bag.messages.odometry(
            stamp_ns, seen.T_O_B, self._covariance, increment, seen.increment_covariance, seconds
        )
        self._bag.write(arrival_ns, ODOMETRY, message)
        exact = self._bag.messages.matrix(seen.increment_covariance)
        self._bag.write(arrival_ns, f"{ODOMETRY}/increment_covariance", exact)
        self._last = seen


def _write_images(bag: _Bag, take: Take, frame: RecordedFrame, images: str, arrival_ns: int) -> None:
    for name, image in frame.images.items():
        camera = take.cameras[name]
        info = bag.messages.camera_info(frame.stamp_ns, name, camera, take.cameras["cam0"], take.distortion)
        bag.write(arrival_ns, f"/{name}/camera_info", info)
        if images == "raw":
            bag.write(arrival_ns, f"/{name}/image_raw", bag.messages.image(frame.stamp_ns, name, image))
        else:
            content = encoded(image, SUFFIXES[images])
            message = bag.messages.compressed_image(frame.stamp_ns, name, images, content)
            bag.write(arrival_ns, f"/{name}/image_raw/compressed", message)
