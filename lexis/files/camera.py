"""A camera as JSON: its intrinsics and its pose on the body."""

from collections.abc import Sequence

import numpy as np
from pydantic import BaseModel

from lexis.files.models import STRICT
from lexis.types import Camera, Intrinsics

Row = tuple[float, float, float, float]


class CameraData(BaseModel):
    """Intrinsics of a pinhole camera [px], and the rows of its pose on the body, T_B_C, with the translation in metres.

    The data are of one camera; the further cameras of a rig are stored beside it.
    """

    model_config = STRICT

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    T_B_C: tuple[Row, Row, Row, Row]

    @staticmethod
    def of(camera: Camera) -> "CameraData":
        """Convert a camera to its JSON data."""
        rows = [tuple(float(value) for value in row) for row in camera.T_B_C]
        return CameraData.model_validate({**vars(camera.intrinsics), "T_B_C": rows})

    def camera(self, others: Sequence["CameraData"] = ()) -> Camera:
        """Convert the JSON data to a camera; use `lexis.inputs.check_camera` to check its values.

        `others` are the further cameras of a rig.
        """
        values = self.model_dump(include=set(CameraData.model_fields))
        T_B_C = np.array(values.pop("T_B_C"), float)
        return Camera(Intrinsics(**values), T_B_C, tuple(other.camera() for other in others))
