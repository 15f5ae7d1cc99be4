"""The feature sensor computes, without the renderer, what the renderer shows, and it obeys the laws of visibility."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.viewpoints import viewpoints

from sim.feature_sensor.ray_origins import RayGrid
from sim.feature_sensor.rays import cast
from sim.feature_sensor.surroundings import KINDS, survey
from sim.feature_sensor.visible_shares import COLUMNS, LABELS, ROWS, look, shares_of
from sim.render.camera import CameraRenderer, fovy_deg, wide_camera
from sim.render.scene import build_scene
from worlds.furniture import registry
from worlds.furniture.catalogue import CATALOGUE
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.spec import HouseSpec, RoomSpec, StoreySpec
from worlds.truth import NOWHERE, room_at
from worlds.variant import explicit
from worlds.visuals.surface_textures import finishes
from worlds.visuals.surfaces import SURFACE_KINDS

CAMERA = wide_camera(160, 120)


@pytest.fixture(scope="module", params=["home", "uh2-apt"])
def house(request):
    return build_house(sample_house(request.param, 5))


def test_furniture_of_a_user_hides_things_and_has_no_kind(monkeypatch):
    """The shipped model was fitted before a user declared kinds of furniture: descriptions must keep their length."""
    spec = explicit(sample_house("home", 5))
    here = viewpoints(build_house(spec), 24)
    sideboard = next(piece for piece in spec.storeys[0].furniture if piece.kind == "sideboard")
    monkeypatch.setitem(registry.KINDS, "harp", replace(CATALOGUE["sideboard"], name="harp", build=lambda size, rng: ()))
    storey = spec.storeys[0]
    pieces = tuple(piece.model_copy(update={"kind": "harp"}) if piece is sideboard else piece for piece in storey.furniture)
    harps = spec.model_copy(update={"storeys": (storey.model_copy(update={"furniture": pieces}), *spec.storeys[1:])})
    before, after = (look(survey(build_house(each)), here, CAMERA) for each in (spec, harps))
    np.testing.assert_array_equal(before.hits.depth, after.hits.depth)
    lost = before.of_kinds() - after.of_kinds()
    assert lost[:, KINDS.index("sideboard")].max() > 0.01 and after.described().shape == before.described().shape
    np.testing.assert_allclose(np.delete(lost, KINDS.index("sideboard"), axis=1), 0.0, atol=1e-6)


@pytest.fixture(scope="module")
def poses(house):
    return viewpoints(house, 24)


@pytest.fixture(scope="module")
def views(house, poses):
    return look(survey(house), poses, CAMERA)


@pytest.fixture(scope="module")
def rendered(house, poses, views):
    """The share of every object, and the depths along the sensor's rays, from the renderer."""
    scene = build_scene(house, (160, 120), fovy_deg(CAMERA.intrinsics))
    row = {name: i for i, name in enumerate(views.around.names)}
    thing_of = np.array([row.get(name, NOWHERE) for name in scene.object_of_geom] + [NOWHERE])
    with CameraRenderer(scene, CAMERA) as renderer:
        things = np.stack([thing_of[renderer.geom_ids(T)] for T in poses])
        depth = np.stack([renderer.depth(T)[2::4, 2::4].T for T in poses])
    return shares_of(things, len(row)), depth


def rooms(views, shares):
    return replace(views, shares=shares).of_rooms()


def test_rooms_fill_the_share_of_the_image_that_they_fill_when_rendered(views, rendered):
    off = np.abs(views.of_rooms() - rooms(views, rendered[0])).sum(axis=1) / 2
    assert np.median(off) < 0.02 and off.mean() < 0.04


def test_box_shaped_objects_fill_the_share_of_the_image_that_they_fill_when_rendered(views, rendered):
    off = np.abs(views.shares - rendered[0]).sum(axis=1) / 2
    assert np.median(off) < 0.1
    kinds = replace(views, shares=rendered[0]).of_kinds()
    assert np.corrcoef(views.of_kinds().ravel(), kinds.ravel())[0, 1] > 0.97


def test_depths_are_the_renderers(views, rendered):
    near = rendered[1] < 30.0  # the sky lies beyond
    off = np.abs(views.hits.depth[near] - rendered[1][near]) / rendered[1][near]
    assert np.median(off) < 0.01 and np.mean(off < 0.1) > 0.75


def test_without_furniture_and_openings_it_is_exact(rng):
    room = RoomSpec(id="a", label="office", polygon_m=((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)))
    spec = HouseSpec(storeys=(StoreySpec(height_m=2.5, rooms=(room,), windows=(), furniture=()),))
    T_W_B = viewpoints(build_house(spec), 16)
    grid = RayGrid.of(CAMERA.intrinsics, COLUMNS, ROWS)
    hits = cast(survey(build_house(spec)), T_W_B @ CAMERA.T_B_C, grid)
    x, y = np.meshgrid(grid.x, grid.y, indexing="ij")
    directions = np.stack([np.ones_like(x), -x, -y], axis=-1) @ np.swapaxes(T_W_B[:, None, :3, :3], -1, -2)
    low, high, start = np.array([0.05, 0.05, 0.0]), np.array([3.95, 2.95, 2.5]), T_W_B[:, None, None, :3, 3]
    with np.errstate(divide="ignore"):
        expected = (np.where(directions > 0, high - start, low - start) / directions).min(axis=-1)
    np.testing.assert_allclose(hits.depth, expected, rtol=2e-3)
    around = survey(build_house(spec))
    assert {around.names[i] for i in np.unique(hits.thing)} == {"a/wall", "a/floor", "a/ceiling"}
    made_of = finishes(build_house(spec))["a"]
    for i, surface in enumerate(SURFACE_KINDS):
        pattern, colour = getattr(made_of, surface)
        assert KINDS[around.kind[i]] == f"{pattern} {surface}" and np.allclose(around.colour[0, i], colour)


def test_a_view_does_not_depend_on_the_others(views, poses):
    alone = look(views.around, poses[7:8], CAMERA)
    np.testing.assert_array_equal(alone.shares[0], views.shares[7])
    np.testing.assert_array_equal(alone.hits.depth[0], views.hits.depth[7])


def test_moving_the_whole_house_changes_nothing(house, views, poses):
    shift = np.array([31.25, -17.5])
    spec = house.spec.model_dump(mode="json", by_alias=True)
    given = build_house(house.spec)
    for storey in spec["storeys"]:
        storey["furniture"] = []
        storey["windows"] = []
        for room in storey["rooms"]:
            room["polygon_m"] = [[x + shift[0], y + shift[1]] for x, y in room["polygon_m"]]
        for opening in storey["openings"]:
            for end in ("start_m", "end_m"):
                opening[end] = [opening[end][0] + shift[0], opening[end][1] + shift[1]]
    bare = replace(given, furniture=(), windows=())
    moved = build_house(HouseSpec.model_validate(spec))
    there = poses.copy()
    there[:, :2, 3] += shift
    here, away = look(survey(bare), poses, CAMERA), look(survey(moved), there, CAMERA)
    np.testing.assert_allclose(here.of_rooms(), away.of_rooms(), atol=0.004)  # rays that graze an edge may hit either side


def test_shut_doors_show_no_more_of_other_rooms(house, views, poses):
    shut = replace(house, leaves=tuple(replace_turn(leaf) for leaf in house.leaves))
    own = room_at(house, poses[:, :3, 3])
    rows = np.arange(len(poses))
    open_share, shut_share = views.of_rooms()[rows, own], look(survey(shut), poses, CAMERA).of_rooms()[rows, own]
    # A leaf counts for the room that it swings into, from wherever it is seen.
    leaf_rooms = look(survey(shut), poses, CAMERA)
    doors = leaf_rooms.shares[:, leaf_rooms.around.kind == KINDS.index("door")].sum(axis=1)
    assert (shut_share + doors >= open_share - 0.01).all() and (shut_share + doors > open_share + 0.01).any()


def replace_turn(leaf):
    (x, y), half = leaf.hinge, leaf.size[0] / 2
    position = (x + half * np.cos(leaf.shut_yaw), y + half * np.sin(leaf.shut_yaw), leaf.position[2])
    return replace(leaf, turn=0.0, position=position)


def test_shares_are_between_zero_and_one_and_add_up(views):
    assert (views.shares >= 0.0).all() and (views.shares.sum(axis=1) <= 1.0 + 1e-5).all()
    np.testing.assert_allclose(views.of_kinds().sum(axis=1), views.shares.sum(axis=1), atol=1e-5)
    np.testing.assert_allclose(views.of_rooms().sum(axis=1), views.shares.sum(axis=1), atol=1e-5)


def test_names_are_the_renderers(house, views):
    scene = build_scene(house, (8, 8), 60.0)
    unknown = {name for name in scene.object_of_geom if not name.startswith("(outside)")} - set(views.around.names)
    small = {piece.id for piece in house.furniture if max(piece.size) < 0.08}
    assert unknown <= small


def test_labels_of_rooms_stand_in_their_columns_of_a_description_and_nowhere_else(views):
    """The visible shares must not contain the labels of rooms: an encoder sees only surfaces and furniture."""
    around = views.around
    others = tuple(replace(room, label="garage") for room in around.house.rooms)
    relabelled = replace(views, around=replace(around, house=replace(around.house, rooms=others)))
    before, after = views.described(), relabelled.described()
    differs = np.flatnonzero((before != after).any(axis=0))
    assert len(differs) > 1 and differs.min() >= LABELS.start and differs.max() < LABELS.stop
    assert np.ptp(np.delete(before, np.r_[LABELS], axis=1)) > 1.0 > np.ptp(before[:, LABELS])
