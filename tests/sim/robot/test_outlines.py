"""Whatever the robot can touch is in its range scan: outlines cover the collision geoms of obstacles."""

import numpy as np
import pytest
from shapely import Polygon, union_all

from sim.render.gl import mujoco
from sim.robot.body import HEIGHT_M, OUTLINE_GROUP, Body
from worlds.house import build_house
from worlds.presets import sample_house

TOLERANCE_M = 1e-4
CYLINDER = mujoco.mjtGeom.mjGEOM_CYLINDER
"""Geom type whose size is a radius and half of a height."""


def footprint(body, geom):
    """The rectangle around a geom, in the plan. Its sides are parallel to those of the geom."""
    (width, depth, _), rotation = body.model.geom_size[geom], body.data.geom_xmat[geom].reshape(3, 3)
    if body.model.geom_type[geom] == CYLINDER:
        depth = width
    corners = np.array([(-width, -depth), (width, -depth), (width, depth), (-width, depth)])
    return Polygon(body.data.geom_xpos[geom, :2] + corners @ rotation[:2, :2].T)


def heights(body, geom):
    """Lowest and highest point of an upright geom [m]."""
    half = body.model.geom_size[geom, 1 if body.model.geom_type[geom] == CYLINDER else 2]
    return body.data.geom_xpos[geom, 2] - half, body.data.geom_xpos[geom, 2] + half


@pytest.mark.parametrize(("preset", "seed"), [("home", 600), ("uh2-office", 601)])
def test_the_outlines_cover_every_obstacle_that_the_body_can_touch(preset, seed):
    house = build_house(sample_house(preset, seed))
    body = Body(house)
    outlines = [geom for geom in range(body.model.ngeom) if body.model.geom_group[geom] == OUTLINE_GROUP]
    spans = [(*heights(body, outline), footprint(body, outline)) for outline in outlines]
    floors = [storey.floor_m for storey in house.storeys]
    seen = 0
    for geom in range(body.model.ngeom):
        name, (low, high) = body.model.geom(geom).name, heights(body, geom)
        floor = max(floor for floor in floors if floor <= high)
        if not name.startswith(("door/", "wall#", *(piece.id for piece in house.furniture))) or low - floor >= HEIGHT_M:
            continue
        own = footprint(body, geom)
        around = [shape for bottom, top, shape in spans if bottom <= high and low <= top and shape.intersects(own)]
        beyond = own.difference(union_all(around).buffer(TOLERANCE_M))
        assert beyond.is_empty, f"{name} at {beyond.bounds}"
        seen += 1
    assert seen > 100
