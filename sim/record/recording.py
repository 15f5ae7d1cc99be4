"""`record`: writes a run as a dataset. If writing fails, no incomplete folder is left."""

import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias

from lexis.files.replace import replaced_folder
from sim.errors import SimError
from sim.harness.scenario import Scenario
from sim.odometry.imu import ImuConfig
from sim.record.euroc import write_euroc
from sim.record.rooms import ROOMS, FrameRooms, write_labels
from sim.record.ros2 import write_bag
from sim.record.take import RecordedFrame, Take, prepare
from sim.record.tum_rgbd import write_tum_rgbd
from sim.render.lens import Distortion

Write: TypeAlias = Callable[[Path, Take, Iterable[RecordedFrame], str], None]


@dataclass(frozen=True)
class Format:
    """A dataset format: the function that writes it, and the kinds of images that it supports."""

    write: Write
    """Function that writes the sensor data of one walk to a folder. Its last argument is the kind of images, such as png."""
    images: tuple[str, ...]
    """Kinds of images that the format supports."""
    depth: bool = False
    """Whether recordings have images and depth maps of cam0 only, instead of the images of several cameras."""


FORMATS: Mapping[str, Format] = MappingProxyType(
    {
        "euroc": Format(write_euroc, ("png", "jpg")),
        "tum": Format(write_tum_rgbd, ("png", "jpg"), depth=True),
        "ros2": Format(write_bag, ("png", "jpg", "raw")),
        "mcap": Format(partial(write_bag, storage="mcap"), ("png", "jpg", "raw")),
    }
)

_BYTES_PER_PIXEL = {"png": 1.5, "jpg": 0.4, "raw": 3.0}
"""Approximate size of the image of a rendered room, for the check of free disk space [bytes per pixel]."""
_DEPTH_BYTES_PER_PIXEL = 1.0


def record(
    scenario: Scenario,
    out: Path,
    format: str = "euroc",
    images: str = "png",
    progress: Callable[[float], None] | None = None,
    imu_config: ImuConfig | None = None,
    distortion: Distortion | None = None,
    day: int = 0,
) -> int:
    """Record the run that `scenario` describes to the folder `out`. An earlier recording there is replaced.

    The cameras are the pinhole cameras of the scenario's rig. If there is only one, a second camera is added on its right.

    Args:
        scenario: the run to record.
        out: folder to write.
        format: a key of `FORMATS`.
        images: png, jpg or, in bags only, raw.
        progress: called after every frame with the share of frames done, in [0, 1].
        imu_config: rate and noise of the IMU; by default, those of EuRoC's IMU.
        distortion: lens distortion of every camera; by default, none.
        day: number of days by which all stamps are later, so that sessions of several days have different stamps.

    Returns the number of bytes written. Raises `LexisError` if `out` contains anything but a recording or cannot be written;
    `SimError` for an unknown format or kind of images, a distortion that cannot be rendered, or too little disk space; and
    whatever `sim.harness.run` raises.
    """
    check_format(format, images)
    with replaced_folder(out, ROOMS) as folder:
        write_take(folder, prepare(scenario, imu_config, distortion, day=day), format, images, progress)
        return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def write_take(
    folder: Path,
    take: Take,
    format: str,
    images: str = "png",
    progress: Callable[[float], None] | None = None,
    note: Callable[[RecordedFrame], None] | None = None,
) -> None:
    """Write a take (the sensor data of one walk) to an empty folder. `note` is called with every written frame.

    If the take is without ground truth, `rooms.json` only lists the labels that rooms may have, and `house.json` is not
    written. Raises `SimError` as `record` does.
    """
    form = check_format(format, images)
    _check_space(folder, take, form, images)
    rooms = FrameRooms(take.walk.house)
    others = () if form.depth else tuple(name for name in take.cameras if name != "cam0")
    with closing(take.frames(others, form.depth)) as frames:
        form.write(folder, take, _reported(rooms.note(frames), len(take), progress, note), images)
    if take.with_truth:
        rooms.write(folder / ROOMS)
        (folder / "house.json").write_text(take.walk.house.spec.to_json(), encoding="utf-8")
    else:
        write_labels(folder / ROOMS, take.walk.house)


def check_format(name: str, images: str) -> Format:
    """Look up a format by name. Raises `SimError` for an unknown name, or a kind of images that the format lacks."""
    if name not in FORMATS:
        raise SimError(f"unknown format {name!r}; valid: {', '.join(FORMATS)}")
    if images not in FORMATS[name].images:
        raise SimError(f"the format {name} holds no {images!r} images; valid: {', '.join(FORMATS[name].images)}")
    return FORMATS[name]


def _check_space(folder: Path, take: Take, form: Format, images: str) -> None:
    size = take.cameras["cam0"].intrinsics
    seen = _BYTES_PER_PIXEL[images]
    per_pixel = seen + _DEPTH_BYTES_PER_PIXEL if form.depth else seen * len(take.cameras)
    needed, free = len(take) * size.width * size.height * per_pixel, shutil.disk_usage(folder).free
    if needed > free:
        raise SimError(
            f"a recording of {len(take)} frames needs about {needed / 1e6:.0f} MB, {free / 1e6:.0f} MB are "
            "free; valid: a place with room for it, smaller images (jpg), or a shorter walk"
        )


def _reported(
    frames: Iterable[RecordedFrame],
    total: int,
    progress: Callable[[float], None] | None,
    note: Callable[[RecordedFrame], None] | None,
) -> Iterator[RecordedFrame]:
    for done, frame in enumerate(frames, 1):
        yield frame
        if note is not None:
            note(frame)
        if progress is not None:
            progress(min(done / total, 1.0))  # faults may duplicate frames
    if progress is not None:
        progress(1.0)  # faults may drop frames
