"""`Body`: an upright round robot among a house's collision geoms. MuJoCo finds its contacts and the ground below it."""

import numpy as np
from jaxtyping import Float64

from sim.errors import SimError
from sim.render.collision_geoms import add_ground, add_obstacles
from sim.render.gl import mujoco
from sim.robot.outlines import add_outlines
from worlds.house import House

RADIUS_M = 0.22
HEIGHT_M = 1.5
STEP_M = 0.25
"""Largest height of a step that the robot can climb [m]."""
_CLEAR_OF_GROUND_M = 0.03
"""Height of the robot's underside above the ground [m]. It is above 0, so that the robot never touches its own floor."""
_ROBOT = "robot"
_OBSTACLE, _GROUND = 1, 2
"""Bits of MuJoCo's contact types. The lower part of the robot, up to `STEP_M`, collides with obstacles only, so that it can
stand over steps. The part above also collides with the ground, such as the side of a flight of stairs."""
GROUND_GROUP, OUTLINE_GROUP = 4, 5
"""Geom groups for ray casts: the ground, to find the height at which the robot stands, and the outlines of obstacles, for
the range scan."""


class Body:
    """A cylinder of `RADIUS_M` and `HEIGHT_M` that slides along x, y and z. It has a position, but no dynamics.

    The model has collision geoms only, so that it compiles in about 0.1 s. `place` moves the robot anywhere, even into an
    obstacle, and reports the contacts.
    """

    def __init__(self, house: House) -> None:
        spec = mujoco.MjSpec()
        for geom in add_ground(spec, house):
            geom.contype, geom.conaffinity, geom.group = _GROUND, 0, GROUND_GROUP
        for geom in add_obstacles(spec, house):
            geom.contype, geom.conaffinity = _OBSTACLE, 0
        for geom in add_outlines(spec, house, HEIGHT_M):
            geom.contype, geom.conaffinity, geom.group = 0, 0, OUTLINE_GROUP
        body = spec.worldbody.add_body(name=_ROBOT)
        for axis in np.eye(3):
            body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        _add_cylinder(body, _CLEAR_OF_GROUND_M, STEP_M, _OBSTACLE)
        _add_cylinder(body, STEP_M, HEIGHT_M, _OBSTACLE | _GROUND)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)  # also computes the poses of static geoms
        self.id = self.model.body(_ROBOT).id
        self._down = group_mask(GROUND_GROUP)

    @property
    def position(self) -> Float64[np.ndarray, "3"]:
        """Position of the robot in W [m]: the point on the ground below its centre."""
        return np.array(self.data.qpos)

    def place(self, x: float, y: float, z: float) -> tuple[str, ...]:
        """Put the robot on the point (x, y, z) in W [m] and return the names of the geoms that it touches."""
        self.data.qpos[:] = x, y, z
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_collision(self.model, self.data)
        if not self.data.ncon:
            return ()
        pairs = self.data.contact.geom
        others = pairs[self.model.geom_bodyid[pairs] != self.id]
        return tuple(self.model.geom(int(geom)).name for geom in others)

    def ground(self, x: float, y: float, z: float) -> float | None:
        """Return the height of the ground at (x, y) in W [m]; None if there is none within `STEP_M` above or below `z`."""
        hit = np.zeros(1, np.int32)
        start, down = np.array([x, y, z + STEP_M]), np.array([0.0, 0.0, -1.0])
        distance = mujoco.mj_ray(self.model, self.data, start, down, self._down, True, self.id, hit)
        return z + STEP_M - distance if 0.0 <= distance <= 2.0 * STEP_M else None

    def stand(self, point: Float64[np.ndarray, "3"]) -> tuple[str, ...]:
        """Put the robot on the ground above or below a point in W [m] and return the names of the geoms that it touches.

        Raises `SimError` if there is no ground within `STEP_M`.
        """
        x, y, z = map(float, point)
        height = self.ground(x, y, z)
        if height is None:
            raise SimError(f"robot: nothing to stand on within {STEP_M} m of ({x:.2f}, {y:.2f}, {z:.2f}) m; valid: a floor")
        return self.place(x, y, height)


def _add_cylinder(body: "mujoco.MjsBody", bottom_m: float, top_m: float, contact_bits: int) -> None:
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER, pos=[0.0, 0.0, (bottom_m + top_m) / 2],
        size=[RADIUS_M, (top_m - bottom_m) / 2, 0.0], contype=0, conaffinity=contact_bits, mass=1.0,
    )  # fmt: skip


def group_mask(group: int) -> np.ndarray:
    """Return MuJoCo's mask of geom groups for ray casts that hit geoms of `group` only."""
    mask = np.zeros(mujoco.mjNGROUP, np.uint8)
    mask[group] = 1
    return mask
