"""A check that a new session can continue a map: both need the same encoder, room names and camera."""

from collections.abc import Sequence

import numpy as np

from lexis.errors import MapError, one_line
from lexis.map.encoder_check import check_encoder
from lexis.perception import Encoder
from lexis.types import Camera, LexisMap


def check_continues(map: LexisMap, camera: Camera, encoder: Encoder, room_names: Sequence[str]) -> None:
    """Raise MapError unless a session with this camera, encoder and room names can continue the map."""
    check_encoder(map, encoder)
    if tuple(room_names) != map.room_names:
        raise MapError(
            f"the map has the room names {', '.join(map.room_names)}, but the new session has {', '.join(room_names)}; "
            "valid: equal names in equal order ('lexis relabel' changes those of a map)"
        )
    if len(camera.rig) != len(map.camera.rig):
        raise MapError(
            f"the rig has {len(camera.rig)} cameras, and that of the map {len(map.camera.rig)}; "
            "valid: the same cameras in all sessions of a map"
        )
    for own, other in zip(camera.rig, map.camera.rig, strict=True):
        if own.intrinsics != other.intrinsics:
            raise MapError(
                f"the camera has {own.intrinsics}, but that of the map {other.intrinsics}; "
                "valid: the same camera in all sessions of a map"
            )
        if not np.allclose(own.T_B_C, other.T_B_C, atol=1e-6):
            raise MapError(
                f"the camera is at {one_line(own.T_B_C[:3].tolist())} on the body, but that of the map at "
                f"{one_line(other.T_B_C[:3].tolist())}; valid: the same camera in all sessions of a map"
            )
