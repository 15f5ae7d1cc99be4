"""The images of one or several cameras of a recorded run, and the times at which all cameras took an image."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np
from jaxtyping import Bool, Float64

from lexis.errors import DatasetError
from lexis.types import Camera, Image


@dataclass(frozen=True, eq=False)
class CameraTrack:
    """The images of one camera, which are read only when they are needed."""

    source: str
    """File or topic of the images, for messages."""
    camera: Camera
    stamps: Float64[np.ndarray, "n"]
    """Stamps of the images, ascending [s]."""
    images: Callable[[Bool[np.ndarray, "n"]], Iterator[Image]]
    """Function that returns a new iterator over the images that an array marks, in order. The iterator raises DatasetError
    if an image is unreadable or does not have the camera's size."""


@dataclass(frozen=True, eq=False)
class RigTrack:
    """The images of all cameras of a rig at the times at which every camera took one."""

    camera: Camera
    """The first camera, with the others of the rig."""
    stamps: Float64[np.ndarray, "n"]
    images: Callable[[], Iterator[tuple[Image, ...]]]
    """Function that returns a new iterator over the images of all cameras. It raises DatasetError as for one camera."""


def joined(tracks: Sequence[CameraTrack]) -> RigTrack:
    """Join the images of cameras that are triggered together; the first camera is the first of the rig.

    Images with a stamp that another camera lacks are left out. Raises DatasetError if the cameras have no stamp in common.
    """
    first, *others = tracks
    stamps = reduce(np.intersect1d, [track.stamps for track in tracks])
    if not len(stamps):
        names = ", ".join(track.source for track in tracks)
        raise DatasetError(
            f"{names}: have no stamp in common; valid: cameras that are triggered together, with equal stamps"
        )

    def images() -> Iterator[tuple[Image, ...]]:
        return zip(*(track.images(np.isin(track.stamps, stamps)) for track in tracks), strict=True)

    camera = replace(first.camera, others=tuple(track.camera for track in others))
    return RigTrack(camera, stamps, images)
