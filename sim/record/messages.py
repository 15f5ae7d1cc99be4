"""Makes ROS 2 messages of standard types from recorded data. Package `rosbags` provides the classes at run time."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from jaxtyping import Float64

from lexis.files.g2o import TRANSLATION_FIRST
from lexis.maths.quaternions import pose_rows
from lexis.maths.se3 import inverse, log
from lexis.types import Camera, Image
from sim.errors import SimError
from sim.odometry.imu import ImuConfig
from sim.render.lens import Distortion

WORLD, ODOM, BODY, IMU = "map", "odom", "base_link", "imu0"

_TYPES = (
    "builtin_interfaces/msg/Time",
    "geometry_msgs/msg/Point",
    "geometry_msgs/msg/Pose",
    "geometry_msgs/msg/PoseStamped",
    "geometry_msgs/msg/PoseWithCovariance",
    "geometry_msgs/msg/Quaternion",
    "geometry_msgs/msg/Transform",
    "geometry_msgs/msg/TransformStamped",
    "geometry_msgs/msg/Twist",
    "geometry_msgs/msg/TwistWithCovariance",
    "geometry_msgs/msg/Vector3",
    "nav_msgs/msg/Odometry",
    "sensor_msgs/msg/CameraInfo",
    "sensor_msgs/msg/CompressedImage",
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/Imu",
    "sensor_msgs/msg/RegionOfInterest",
    "std_msgs/msg/Float64MultiArray",
    "std_msgs/msg/Header",
    "std_msgs/msg/MultiArrayDimension",
    "std_msgs/msg/MultiArrayLayout",
    "tf2_msgs/msg/TFMessage",
)


class Messages:
    """Factory of ROS 2 messages. Stamps are in nanoseconds; transforms between frames are `T_parent_child`."""

    def __init__(self, types: Any, latched: Any) -> None:
        self.types = types
        self.latched = latched
        """Quality-of-service profile of latched topics: those who subscribe later receive the last message, too."""
        self._of = {name.rsplit("/", 1)[1]: types.types[name] for name in _TYPES}

    @staticmethod
    def load() -> "Messages":
        """Load the message types of ROS 2 Humble. Raises `SimError` if `rosbags` is not installed."""
        try:
            from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
            from rosbags.typesys import Stores, get_typestore
        except ImportError:
            raise SimError("ROS 2 bags need the package rosbags; install it: pip install lexis-sim[ros]") from None
        never = QosTime(2147483647, 4294967295)
        latched = Qos(
            QosHistory.KEEP_LAST,
            1,
            QosReliability.RELIABLE,
            QosDurability.TRANSIENT_LOCAL,
            never,
            never,
            QosLiveliness.AUTOMATIC,
            never,
            False,
        )
        return Messages(get_typestore(Stores.ROS2_HUMBLE), (latched,))

    def static_transforms(self, stamp_ns: int, cameras: Mapping[str, Camera]) -> Any:
        """Return the TFMessage with the poses of the IMU and the cameras in the body frame."""
        places = {IMU: np.eye(4), **{name: camera.T_B_C for name, camera in cameras.items()}}
        return self._of["TFMessage"]([self._transform(stamp_ns, name, T) for name, T in places.items()])

    def camera_info(self, stamp_ns: int, name: str, camera: Camera, first: Camera, distortion: Distortion) -> Any:
        """Return the CameraInfo message with the calibration of a camera.

        Entry (0, 3) of the matrix P is -fx b [px m], where b is how far the camera is to the right of the camera `first`. It
        is 0 for a camera that is not parallel to `first`, because such a pair has no stereo baseline.
        """
        k, T = camera.intrinsics, inverse(first.T_B_C) @ camera.T_B_C
        to_the_right = T[0, 3] if np.allclose(T[:3, :3], np.eye(3)) else 0.0
        P = np.column_stack([k.matrix, [-k.fx * to_the_right, 0.0, 0.0]])
        region = self._of["RegionOfInterest"](0, 0, 0, 0, False)
        return self._of["CameraInfo"](
            self._header(stamp_ns, name),
            k.height,
            k.width,
            "plumb_bob",
            np.array([*distortion.coefficients, 0.0]),
            k.matrix.ravel(),
            np.eye(3).ravel(),
            P.ravel(),
            0,
            0,
            region,
        )

    def image(self, stamp_ns: int, name: str, image: Image) -> Any:
        """Return the message of an uncompressed RGB image."""
        height, width = image.shape[:2]
        pixels = np.ascontiguousarray(image).ravel()
        return self._of["Image"](self._header(stamp_ns, name), height, width, "rgb8", 0, 3 * width, pixels)

    def compressed_image(self, stamp_ns: int, name: str, kind: str, content: bytes) -> Any:
        """Return the message of an image whose `content` is encoded as `kind`, png or jpg."""
        form = {"png": "rgb8; png compressed bgr8", "jpg": "rgb8; jpeg compressed bgr8"}[kind]
        return self._of["CompressedImage"](self._header(stamp_ns, name), form, np.frombuffer(content, np.uint8))

    def imu(
        self,
        stamp_ns: int,
        angular_velocity: Float64[np.ndarray, "3"],
        specific_force: Float64[np.ndarray, "3"],
        config: ImuConfig,
    ) -> Any:
        """Return the message of an IMU measurement, without an orientation. `config` determines the covariances."""
        unknown = np.zeros(9)
        unknown[0] = -1.0  # how sensor_msgs/Imu marks an orientation that is not measured
        gyroscope, accelerometer = (
            np.ravel(density**2 * config.rate_hz * np.eye(3))
            for density in (config.gyroscope_noise, config.accelerometer_noise)
        )
        return self._of["Imu"](
            self._header(stamp_ns, IMU),
            self._of["Quaternion"](0.0, 0.0, 0.0, 1.0),
            unknown,
            self._vector(angular_velocity),
            gyroscope,
            self._vector(specific_force),
            accelerometer,
        )

    def pose(self, stamp_ns: int, row: Float64[np.ndarray, "7"]) -> Any:
        """Return the message of a pose in the world frame. `row` holds the position and the quaternion (x, y, z, w)."""
        return self._of["PoseStamped"](self._header(stamp_ns, WORLD), self._pose(row))

    def odometry(
        self,
        stamp_ns: int,
        T_O_B: Float64[np.ndarray, "4 4"],
        covariance: Float64[np.ndarray, "6 6"],
        increment: Float64[np.ndarray, "4 4"],
        increment_covariance: Float64[np.ndarray, "6 6"],
        seconds: float,
    ) -> Any:
        """Return the Odometry message: pose and twist with covariances.

        In ROS, covariances have the translation first, and the covariance of the pose is in the axes of the odometry frame.
        Both covariances are therefore reordered, and the covariance of the pose is rotated.

        Args:
            stamp_ns: time stamp [ns].
            T_O_B: pose of the body in the odometry frame.
            covariance: covariance of the pose, rotation first, perturbation on the right (body axes).
            increment: motion since the last message, in body axes.
            increment_covariance: covariance of the increment, rotation first, perturbation on the right.
            seconds: time since the last message; 0 for the first one, which gets a twist of zero.
        """
        axes = np.kron(np.eye(2), T_O_B[:3, :3])
        in_odom = axes @ covariance[np.ix_(TRANSLATION_FIRST, TRANSLATION_FIRST)] @ axes.T
        rate = 1.0 / seconds if seconds > 0.0 else 0.0
        twist = log(increment) * rate
        twist_covariance = increment_covariance[np.ix_(TRANSLATION_FIRST, TRANSLATION_FIRST)] * rate**2
        return self._of["Odometry"](
            self._header(stamp_ns, ODOM),
            BODY,
            self._of["PoseWithCovariance"](self._pose(pose_rows(T_O_B[None])[0]), in_odom.ravel()),
            self._of["TwistWithCovariance"](
                self._of["Twist"](self._vector(twist[3:]), self._vector(twist[:3])), twist_covariance.ravel()
            ),
        )

    def matrix(self, values: Float64[np.ndarray, "rows columns"]) -> Any:
        """Return the Float64MultiArray message of a matrix, in row-major order."""
        sizes = (("rows", values.shape[0], values.size), ("columns", values.shape[1], values.shape[1]))
        layout = self._of["MultiArrayLayout"]([self._of["MultiArrayDimension"](*size) for size in sizes], 0)
        return self._of["Float64MultiArray"](layout, values.ravel())

    def _header(self, stamp_ns: int, frame: str) -> Any:
        return self._of["Header"](self._of["Time"](stamp_ns // 10**9, stamp_ns % 10**9), frame)

    def _vector(self, vector: Float64[np.ndarray, "3"]) -> Any:
        return self._of["Vector3"](*vector.tolist())

    def _pose(self, row: Float64[np.ndarray, "7"]) -> Any:
        x, y, z, *quaternion = row.tolist()
        return self._of["Pose"](self._of["Point"](x, y, z), self._of["Quaternion"](*quaternion))

    def _transform(self, stamp_ns: int, child: str, T_B_S: Float64[np.ndarray, "4 4"]) -> Any:
        row = pose_rows(T_B_S[None])[0].tolist()
        transform = self._of["Transform"](self._of["Vector3"](*row[:3]), self._of["Quaternion"](*row[3:]))
        return self._of["TransformStamped"](self._header(stamp_ns, BODY), child, transform)
