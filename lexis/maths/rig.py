"""Angles between the cameras of a rig at two poses of the body."""

import numpy as np
from jaxtyping import Float64

from lexis.maths.se3 import Transforms, rotation_angle

Rotations = Float64[np.ndarray, "cameras 3 3"]


def camera_angles(T_m_q: Transforms, rotations: Rotations) -> Float64[np.ndarray, "*batch cameras cameras"]:
    """Return the angles between the cameras of a rig at two poses of the body, m and q [rad].

    The entry (j, i) is the angle between camera j at pose m and camera i at pose q. On the diagonal, it is the angle of the
    body, because one camera turns as much as the body does.

    Args:
        T_m_q: relative poses of the body.
        rotations: rotations of the cameras on the body, from C to B.
    """
    if len(rotations) == 1:
        return np.asarray(rotation_angle(T_m_q)[..., None, None])
    turned = np.einsum("jba,...bc,icd->...jiad", rotations, T_m_q[..., :3, :3], rotations)
    angles = rotation_angle(turned)
    same = np.arange(len(rotations))
    angles[..., same, same] = rotation_angle(T_m_q)[..., None]
    return angles
