"""The look of a house: appearance changes only the look, twins look alike, textures repeat exactly, lighting is as set."""

import cv2
import numpy as np
import pytest

from sim.render.camera import CameraRenderer, fovy_deg, wide_camera
from sim.render.scene import LIGHTS, build_scene
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.spec import AppearanceSpec, FurnitureSpec, HouseSpec, OpeningSpec, RoomSpec, StoreySpec
from worlds.visuals.house_visuals import ATLAS, visuals
from worlds.visuals.surface_textures import PERIOD_M, finishes

CAMERA = wide_camera(240, 180)
SIZE, FOVY = (240, 180), fovy_deg(CAMERA.intrinsics)


def rectangle(x0, y0, x1, y1):
    return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))


def row_of_offices(furniture=(), **appearance):
    """Two equal offices of 5 x 4 m, each with a door to the corridor north of them; a third one has no seed of its own."""
    rooms = [RoomSpec(id=f"office {i}", label="office", polygon_m=rectangle(5.0 * i, 0.0, 5.0 * i + 5.0, 4.0), seed=seed)
             for i, seed in enumerate((7, 7, None))]  # fmt: skip
    rooms.append(RoomSpec(id="corridor", label="corridor", polygon_m=rectangle(0.0, 4.0, 15.0, 6.0)))
    doors = tuple(
        OpeningSpec(rooms=(f"office {i}", "corridor"), kind="door", start_m=(5.0 * i + 2.0, 4.0), end_m=(5.0 * i + 2.9, 4.0))
        for i in range(3)
    )
    storey = StoreySpec(rooms=tuple(rooms), openings=doors, windows=(), furniture=tuple(furniture))
    return HouseSpec(seed=3, appearance=AppearanceSpec(**appearance), storeys=(storey,))


def looking_south(x, y, z=1.3):
    T_W_B = np.eye(4)
    T_W_B[:3, :3] = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    T_W_B[:3, 3] = x, y, z
    return T_W_B


def pictures(spec, poses):
    with CameraRenderer(build_scene(build_house(spec), SIZE, FOVY), CAMERA) as renderer:
        return [renderer.rgb(T).astype(int) for T in poses]


def key_points(image):
    grey = cv2.cvtColor(image.astype(np.uint8), cv2.COLOR_RGB2GRAY)
    return len(cv2.AKAZE_create(threshold=3e-4).detect(grey, None))


@pytest.mark.parametrize("appearance", [dict(texture="poor"), dict(texture="repeating"), dict(light="dim"), dict(seed=9)])
def test_appearance_changes_no_shape(appearance):
    spec = sample_house("home", 3)
    other = spec.model_copy(update={"appearance": AppearanceSpec(**appearance)})
    before, after = visuals(build_house(spec)), visuals(build_house(other))
    assert [part.name for part in before.parts] == [part.name for part in after.parts]
    for old, new in zip(before.parts, after.parts, strict=True):
        if not old.shows.startswith("window/"):  # the window bars are a random detail
            assert np.array_equal(old.corners, new.corners)


def test_twins_look_alike_and_others_do_not():
    images = visuals(build_house(row_of_offices())).images
    for kind in ("wall", "floor", "ceiling"):
        assert np.array_equal(images[f"office 0/{kind}"], images[f"office 1/{kind}"])
        assert not np.array_equal(images[f"office 0/{kind}"], images[f"office 2/{kind}"])
    one, other = pictures(row_of_offices(), [looking_south(x + 2.5, 3.5) for x in (0.0, 5.0)])
    assert np.mean(np.abs(one - other) <= 2) > 0.999


def test_a_new_paint_keeps_twins_and_leaves_no_wall_as_it_was():
    before, after = (visuals(build_house(row_of_offices(**looks))).images for looks in ({}, {"seed": 1}))
    assert np.array_equal(after["office 0/wall"], after["office 1/wall"])
    assert not any(np.array_equal(before[name], after[name]) for name in before if name != ATLAS)


def test_rooms_keep_their_finish_when_others_change():
    spec = row_of_offices()
    fewer = spec.model_copy(update={"storeys": (spec.storeys[0].model_copy(
        update={"rooms": spec.storeys[0].rooms[1:], "openings": spec.storeys[0].openings[1:]}),)})  # fmt: skip
    before, after = finishes(build_house(spec)), finishes(build_house(fewer))
    assert all(before[room] == after[room] for room in after)


def test_repeating_walls_look_the_same_one_period_further_on():
    metre = PERIOD_M["wall"]
    assert all((metre / period).is_integer() for period in PERIOD_M.values())
    spec = row_of_offices(texture="repeating")
    far = [looking_south(x, 1.3) for x in (6.0, 6.0 + metre, 6.0 + metre / 2)]  # of the south wall alone
    here, one_on, half_on = (image[60:120, 90:150] for image in pictures(spec, far))
    assert np.mean(np.abs(here - one_on) <= 2) > 0.999
    assert np.mean(np.abs(here - half_on) <= 2) < 0.7


def test_poor_houses_have_few_key_points():
    spec = sample_house("uh2-apt", 3)
    room = next(room for room in build_house(spec).rooms if room.label == "bedroom")
    x, y = room.polygon.centroid.coords[0]
    poses = [looking_south(x, y, room.floor_m + 1.4)]
    rich, poor = (
        pictures(spec.model_copy(update={"appearance": AppearanceSpec(texture=texture)}), poses)[0]
        for texture in ("rich", "poor")
    )
    assert key_points(poor) < 0.6 * key_points(rich)
    bare_rich, bare_poor = (pictures(row_of_offices(texture=t), [looking_south(2.5, 2.5)])[0] for t in ("rich", "poor"))
    assert key_points(bare_poor) < 0.1 * key_points(bare_rich)


def test_evening_is_warm_and_dim_is_dark():
    pose = [looking_south(2.5, 3.5)]
    day, evening, dim = (pictures(row_of_offices(light=light), pose)[0].mean(axis=(0, 1)) for light in LIGHTS)
    assert day.mean() > evening.mean() > dim.mean() > 15
    assert evening[0] / evening[2] > 1.2 * day[0] / day[2]


def piece(name, kind, x, room="office 0", seed=5, size=(1.0, 0.5, 1.0)):
    return FurnitureSpec(id=name, kind=kind, room=room, position_m=(x, 1.0, 0.0), yaw_rad=0.0, size_m=size, seed=seed)


def test_a_piece_looks_the_same_whatever_else_is_there():
    chest = piece("chest", "dresser", 1.0)
    alone = row_of_offices([chest])
    among = row_of_offices([piece(f"sofa {i}", "sofa", 6.0 + i, "office 1", i, (1.8, 0.9, 0.8)) for i in range(4)] + [chest])
    looks = []
    for spec in (alone, among):
        seen = visuals(build_house(spec))
        part = next(part for part in seen.parts if part.shows == "chest")
        size = np.array(seen.images[ATLAS].shape[1::-1])
        pixels = (part.uv.mean(axis=1) * (1.0, -1.0) + (0.0, 1.0)) * size
        looks.append(seen.images[ATLAS][tuple(pixels[:, ::-1].astype(int).T)])
    assert np.array_equal(*looks)


def test_every_geom_says_what_it_shows():
    house = build_house(sample_house("home", 3))
    scene = build_scene(house, SIZE, FOVY)
    assert len(scene.object_of_geom) == scene.model.ngeom
    shown = set(scene.object_of_geom)
    assert {piece.id for piece in house.furniture} | {leaf.id for leaf in house.leaves} <= shown
    assert {f"{room.id}/floor" for room in house.rooms} <= shown


def test_nothing_is_drawn_with_shadows_or_multi_sampling():
    model = build_scene(build_house(sample_house("uh2-apt", 3)), SIZE, FOVY).model
    assert model.vis.quality.offsamples == model.vis.quality.shadowsize == 0
    assert not model.light_castshadow.any()
