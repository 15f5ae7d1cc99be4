"""Recorded runs in ROS 2 bags (sqlite3 or MCAP), read without ROS by the package `rosbags` (`pip install lexis-sim[ros]`).

    /cam0/image_raw              sensor_msgs/Image (rgb8, bgr8 or mono8), or
    /cam0/image_raw/compressed   sensor_msgs/CompressedImage (PNG or JPEG)
    /cam0/camera_info            sensor_msgs/CameraInfo: pinhole, plumb_bob; further cameras of a rig: /cam1 and so on, with
                                 images of equal stamps
    /odom                        nav_msgs/Odometry: T_O_B
    /odom/increment_covariance   std_msgs/Float64MultiArray, optional: one message per odometry message, in the same order,
                                 with the 6x6 covariance of the increment since the previous odometry message, rotation
                                 first [rad², m²]
    /tf_static                   tf2_msgs/TFMessage: from the odometry's child frame to the camera's frame

The stamps are read from the message headers. Covariances of increments are used only if the odometry has the same stamps as
the images. The covariances in the odometry messages are not read: they are covariances of the pose, and the difference of
two covariance matrices need not be a covariance matrix.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeAlias

import cv2
import numpy as np
from jaxtyping import Bool, Float64

from lexis.datasets.camera_tracks import CameraTrack, joined
from lexis.datasets.recorded import (
    DatasetConfig,
    OdometryTrack,
    Recorded,
    check_ascending,
    check_calibration,
    check_image_size,
    decode_image,
    rectifier,
)
from lexis.errors import DatasetError, one_line
from lexis.files.reading import FileKind, open_file, read_yaml
from lexis.inputs import usable_covariances
from lexis.maths.quaternions import UNIT_TOLERANCE, poses_of
from lexis.types import Camera, Image, Intrinsics, Pose

METADATA, CAMERA, ODOMETRY = "metadata.yaml", "cam0", "/odom"
_METADATA_FILE = FileKind("the metadata of a bag", 300_000, DatasetError, unusable="not a readable bag")
_STORAGE_FILE = FileKind("the storage of a bag", 10**13, DatasetError)

_IMAGE, _COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
_INFO, _ODOMETRY = "sensor_msgs/msg/CameraInfo", "nav_msgs/msg/Odometry"
_MATRIX, _TRANSFORMS = "std_msgs/msg/Float64MultiArray", "tf2_msgs/msg/TFMessage"

Message: TypeAlias = Any
"""A ROS message; `rosbags` creates its class at run time."""

_CHANNELS: dict[str, Callable[[Image], Image]] = {
    "rgb8": lambda image: image,
    "bgr8": lambda image: image[..., ::-1].copy(),
    "mono8": lambda image: np.asarray(cv2.cvtColor(image, cv2.COLOR_GRAY2RGB), np.uint8),
}


def is_bag(directory: Path) -> bool:
    """Whether a folder is a ROS 2 bag, or contains one named `bag`."""
    return (directory / METADATA).is_file() or (directory / "bag" / METADATA).is_file()


def read_bag(directory: Path, config: DatasetConfig) -> Recorded:
    """Read a bag that has the topics listed at the top of this module, under the names that `config` gives.

    Raises LexisError, which names the topic, if the bag is incomplete or inconsistent.
    """
    bag = _Bag(directory if (directory / METADATA).is_file() else directory / "bag")
    track, body = _read_odometry(bag, config.odometry or ODOMETRY)
    seen = joined([_read_images(bag, f"/{name}", body) for name in config.cameras(CAMERA)])
    covariances = _read_covariances(bag, f"{config.odometry or ODOMETRY}/increment_covariance", len(track.stamps))
    return Recorded.of(seen, track, covariances)


def _read_images(bag: "_Bag", name: str, body: str) -> CameraTrack:
    """Read the calibration of the camera `name` and the stamps of its images. `body` is the body frame."""
    raw, compressed = f"{name}/image_raw", f"{name}/image_raw/compressed"
    topic = bag.first_of(raw, compressed)
    kind, decode = (_COMPRESSED, _decode) if topic == compressed else (_IMAGE, _as_image)
    camera, distortion = _read_camera(bag, f"{name}/camera_info", body)
    rectified, source = rectifier(camera, distortion), f"{bag.path}: {topic}"

    def images(wanted: Bool[np.ndarray, "n"]) -> Iterator[Image]:
        messages = zip(bag.messages(topic, kind), wanted.tolist(), strict=True)
        return (rectified(decode(message, source, camera)) for message, is_wanted in messages if is_wanted)

    stamps = np.array([_stamp(message) for message in bag.messages(topic, kind)])
    check_ascending(source, stamps)
    return CameraTrack(source, camera, stamps, images)


class _Bag:
    """A bag of which one topic after the other can be read."""

    def __init__(self, path: Path) -> None:
        try:
            from rosbags.typesys import Stores, get_typestore
        except ImportError:
            raise DatasetError(
                f"{path}: a ROS 2 bag needs the package rosbags; install it: pip install lexis-sim[ros]"
            ) from None
        self.path = path
        self._check_files()
        self._types = get_typestore(Stores.ROS2_HUMBLE)
        with self._open() as reader:
            self.topics = sorted({topic for c in reader.connections if isinstance(topic := c.topic, str)})

    def _check_files(self) -> None:
        """Raise DatasetError unless the metadata are plain YAML, and all files of the bag are regular and uncompressed.

        The check is needed because `rosbags` would follow YAML aliases, read from pipes and devices without end, and unpack
        compressed files without a limit on their size.
        """
        path = self.path / METADATA
        bag = read_yaml(path, _METADATA_FILE).get("rosbag2_bagfile_information")
        names = bag.get("relative_file_paths") if isinstance(bag, dict) else None
        if not isinstance(bag, dict) or not isinstance(names, list):
            raise _METADATA_FILE.refusal(path, "lists no relative_file_paths")
        if str(bag.get("compression_mode", "")).lower() == "file":
            raise _METADATA_FILE.refusal(path, "its files are compressed as a whole; unpack them first")
        for name in names:
            with open_file(self.path / Path(str(name)).name, _STORAGE_FILE):
                pass

    def first_of(self, *topics: str) -> str:
        """The first of the given topics that is in the bag. Raises DatasetError if the bag has none of the topics."""
        present = [topic for topic in topics if topic in self.topics]
        if not present:
            found = ", ".join(self.topics) or "nothing"
            raise DatasetError(f"{self.path}: has no topic {' or '.join(topics)}; it holds {found}")
        return present[0]

    def messages(self, topic: str, kind: str) -> Iterator[Message]:
        """The messages of a topic, in the order of their arrival. Raises DatasetError if their type is not `kind`."""
        with self._open() as reader:
            wanted = [connection for connection in reader.connections if connection.topic == topic]
            if other := [connection.msgtype for connection in wanted if connection.msgtype != kind]:
                raise DatasetError(f"{self.path}: {topic}: holds {one_line(other[0], 80)}; valid: {kind}")
            stored = iter(reader.messages(wanted))
            while (message := self._next(stored, topic, kind)) is not None:
                yield message

    def _next(self, stored: Iterator[Any], topic: str, kind: str) -> Message | None:
        """The next message, or None after the last."""
        try:
            found = next(stored, None)
            return None if found is None else self._types.deserialize_cdr(found[2], kind)
        except Exception as error:
            # For damaged bytes, rosbags and its libraries (SQLite, zstd, LZ4, numpy) raise almost any type of error.
            found = f"{kind} is not readable: {one_line(error, 120)}"
            raise DatasetError(f"{self.path}: {topic}: {found}; valid: undamaged messages") from None

    @contextmanager
    def _open(self) -> Iterator[Any]:
        from rosbags.rosbag2 import Reader

        reader = Reader(self.path)
        try:
            reader.open()
        except Exception as error:  # rosbags passes on the errors of SQLite, YAML and MCAP
            found = f"is not a readable bag: {one_line(error, 120)}"
            raise DatasetError(f"{self.path}: {found}; valid: a complete bag of ROS 2 with its metadata") from None
        try:
            yield reader
        finally:
            reader.close()


def _read_odometry(bag: _Bag, topic: str) -> tuple[OdometryTrack, str]:
    """Return the odometry and the name of its child frame, which is the body frame."""
    messages = list(bag.messages(bag.first_of(topic), _ODOMETRY))
    where = f"{bag.path}: {topic}"
    stamps = np.array([_stamp(message) for message in messages])
    check_ascending(where, stamps)
    rows = np.array([_pose_row(m.pose.pose.position, m.pose.pose.orientation) for m in messages])
    usable = _usable(rows)
    if not usable.all():
        found = f"message {int(np.argmin(usable))} has no finite position with a unit quaternion"
        raise DatasetError(f"{where}: {found}; valid: finite numbers, and a quaternion of norm 1")
    return OdometryTrack(where, stamps, poses_of(rows)), str(messages[0].child_frame_id)


def _read_covariances(bag: _Bag, topic: str, expected: int) -> Float64[np.ndarray, "n 6 6"] | None:
    if topic not in bag.topics:
        return None
    matrices = [np.asarray(message.data, float) for message in bag.messages(topic, _MATRIX)]
    usable = all(m.size == 36 and bool(usable_covariances(m.reshape(6, 6))) for m in matrices)
    if not usable or len(matrices) != expected:
        found = f"{len(matrices)} covariances for {expected} poses" if usable else "a matrix that is no covariance"
        valid = f"{expected} positive semi-definite 6x6 matrices, one per pose"
        raise DatasetError(f"{bag.path}: {topic}: holds {found}; valid: {valid}")
    return np.array(matrices).reshape(-1, 6, 6)


def _read_camera(bag: _Bag, topic: str, body: str) -> tuple[Camera, Float64[np.ndarray, "k"]]:
    """Return the camera, with its pose in the frame `body`, and its distortion coefficients."""
    info = next(bag.messages(bag.first_of(topic), _INFO), None)
    if info is None or info.distortion_model not in ("", "plumb_bob"):
        found = "no message" if info is None else f"the distortion model {one_line(info.distortion_model, 80)}"
        raise DatasetError(f"{bag.path}: {topic}: holds {found}; valid: a CameraInfo with the distortion model plumb_bob")
    k = np.asarray(info.k, float)
    intrinsics = Intrinsics(int(info.width), int(info.height), *(float(k[i]) for i in (0, 4, 2, 5)))
    camera = Camera(intrinsics, _static_transform(bag, body, str(info.header.frame_id)))
    distortion = np.asarray(info.d, float)
    check_calibration(f"{bag.path}: {topic}", camera, distortion)
    return camera, distortion


def _static_transform(bag: _Bag, body: str, frame: str) -> Pose:
    """Return the pose of `frame` in the frame `body`, composed from the static transforms.

    The bag needs no static transforms if the two frames are one.
    """
    if frame == body:
        return np.eye(4)
    messages = bag.messages(bag.first_of("/tf_static"), _TRANSFORMS)
    links = {link.child_frame_id: link for message in messages for link in message.transforms}
    T, here = np.eye(4), frame
    for _ in range(len(links)):
        if here == body or here not in links:
            break
        link = links[here]
        row = np.array([_pose_row(link.transform.translation, link.transform.rotation)])
        if not _usable(row).all():
            raise DatasetError(
                f"{bag.path}: /tf_static: the link to {here!r} has no finite position with a unit quaternion; "
                "valid: finite numbers, and a quaternion of norm 1"
            )
        here, T = link.header.frame_id, poses_of(row)[0] @ T
    if here != body:
        found = f"does not lead from {frame!r} up to {body!r}, the frame of the odometry"
        raise DatasetError(f"{bag.path}: /tf_static: {found}; valid: static transforms from the one to the other")
    return T


def _pose_row(position: Message, orientation: Message) -> list[float]:
    return [position.x, position.y, position.z, orientation.x, orientation.y, orientation.z, orientation.w]


def _usable(rows: Float64[np.ndarray, "n 7"]) -> Bool[np.ndarray, "n"]:
    """Whether each row holds a finite position and a unit quaternion."""
    norms = np.linalg.norm(rows[:, 3:], axis=1)
    return np.asarray(np.isfinite(rows).all(axis=1) & (np.abs(norms - 1.0) <= UNIT_TOLERANCE))


def _stamp(message: Message) -> float:
    return float((message.header.stamp.sec * 10**9 + message.header.stamp.nanosec) / 1e9)


def _decode(message: Message, where: str, camera: Camera) -> Image:
    return decode_image(np.asarray(message.data, np.uint8), where, camera)


def _as_image(message: Message, where: str, camera: Camera) -> Image:
    channels = 1 if message.encoding == "mono8" else 3
    if message.encoding not in _CHANNELS or message.data.size != message.height * message.width * channels:
        raise DatasetError(f"{where}: encoding {message.encoding!r}; valid: {', '.join(_CHANNELS)}, without padding")
    pixels = np.asarray(message.data, np.uint8).reshape(message.height, message.width, channels)
    return check_image_size(_CHANNELS[message.encoding](pixels), where, camera)
