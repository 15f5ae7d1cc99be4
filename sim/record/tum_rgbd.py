"""Writes runs in the layout of the TUM RGB-D benchmark: colour, depth, true trajectory, accelerometer, and odometry.

`groundtruth.txt` contains poses of the camera's optical frame, as in the benchmark. `odometry.tum` contains poses of the
body (see `lexis.datasets.tum_rgbd`).
"""

from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from jaxtyping import Float64

from lexis.datasets.tum_rgbd import CAMERA, COVARIANCE, IMAGE_LIST, ODOMETRY, covariance_line, odometry_line, write_camera
from lexis.maths.quaternions import pose_rows
from sim.record.image_names import unused
from sim.record.settings import write_rgbd_settings
from sim.record.take import RecordedFrame, Take
from sim.render.image_files import SUFFIXES, encoded, encoded_depth

ASSOCIATIONS = "associations.txt"
"""File that lists each image with its depth map, in the format of the benchmark's script `associate.py`. ORB-SLAM3 reads
this file. The file has no header, since ORB-SLAM3 cannot read comments in it."""
_HEADERS = {
    IMAGE_LIST: "# color images\n# timestamp filename\n",
    "depth.txt": "# depth maps, 16 bit, 5000 per metre along the optical axis, 0 where unknown\n# timestamp filename\n",
    ASSOCIATIONS: "",
    ODOMETRY: "# odometry of the body: timestamp tx ty tz qx qy qz qw\n",
    COVARIANCE: "# timestamp, 6x6 of the odometry's increment since the image before, rotation first [rad^2, m^2]\n",
}


def write_tum_rgbd(folder: Path, take: Take, frames: Iterable[RecordedFrame], images: str) -> None:
    """Write a take (the sensor data of one walk) in the layout of TUM RGB-D. `images` is png or jpg. Raises OSError."""
    camera, suffix = take.cameras["cam0"], SUFFIXES[images]
    write_camera(folder / CAMERA, camera, take.distortion.coefficients)
    write_rgbd_settings(folder / "settings", take)
    if take.with_truth:
        truth = pose_rows(take.T_W_B @ camera.T_B_C)
        _write_rows(folder / "groundtruth.txt", "# timestamp tx ty tz qx qy qz qw", take, truth)
    _write_rows(folder / "accelerometer.txt", "# timestamp ax ay az", take, take.imu.specific_force)
    for name in ("rgb", "depth"):
        (folder / name).mkdir()
    with ExitStack() as stack:
        files = {name: stack.enter_context(open(folder / name, "w", encoding="utf-8")) for name in _HEADERS}
        for name, file in files.items():
            file.write(_HEADERS[name])
        taken: set[str] = set()
        for frame in frames:
            stamp = _seconds(frame.stamp_ns)
            name = unused(stamp, suffix, taken)
            taken.add(name)
            colour, depth = f"rgb/{name}", f"depth/{name.removesuffix(suffix)}.png"
            (folder / colour).write_bytes(encoded(frame.images["cam0"], suffix))
            if frame.depth is not None:
                (folder / depth).write_bytes(encoded_depth(frame.depth))
                files["depth.txt"].write(f"{stamp} {depth}\n")
                files[ASSOCIATIONS].write(f"{stamp} {colour} {stamp} {depth}\n")
            files[IMAGE_LIST].write(f"{stamp} {colour}\n")
            files[ODOMETRY].write(odometry_line(stamp, frame.observation))
            files[COVARIANCE].write(covariance_line(stamp, frame.observation))


def _write_rows(path: Path, header: str, take: Take, rows: Float64[np.ndarray, "n k"]) -> None:
    stamps = map(_seconds, take.imu_ns.tolist())
    lines = (
        f"{stamp} {' '.join(f'{value:.9f}' for value in row)}" for stamp, row in zip(stamps, rows.tolist(), strict=True)
    )
    path.write_text("\n".join([header, *lines, ""]), encoding="utf-8")


def _seconds(stamp_ns: int) -> str:
    """Format a stamp as seconds with six decimals, as in the benchmark."""
    micro = round(stamp_ns / 1000)
    return f"{micro // 10**6}.{micro % 10**6:06d}"
