"""A house as MJCF: MuJoCo reads back the meshes and textures, and collision geometry is where the house is solid."""

import errno
from pathlib import Path

import numpy as np
import pytest

from lexis.errors import LexisError
from sim.render.collision_geoms import GROUP
from sim.render.gl import mujoco
from sim.render.mjcf import write_mjcf
from sim.render.scene import house_mjspec
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.visuals.house_visuals import visuals


@pytest.fixture(scope="module")
def house():
    return build_house(sample_house("uh2-apt", 3))


@pytest.fixture(scope="module")
def loaded(house, tmp_path_factory):
    path = tmp_path_factory.mktemp("mjcf") / "house.xml"
    write_mjcf(house, path)
    write_mjcf(house, path)  # this one replaces an earlier export
    return mujoco.MjModel.from_xml_path(str(path))


def test_what_is_seen_comes_back_as_it_was(house, loaded):
    rendered = house_mjspec(house, visuals(house)).compile()
    assert np.count_nonzero(loaded.geom_group != GROUP) == rendered.ngeom
    assert loaded.nmesh == rendered.nmesh and loaded.nmeshvert == rendered.nmeshvert
    assert np.array_equal(loaded.tex_data, rendered.tex_data)
    assert np.allclose(loaded.mesh_texcoord, rendered.mesh_texcoord, atol=1e-5)


def test_rays_meet_the_collision_geoms_where_the_house_is_solid(house, loaded):
    data = mujoco.MjData(loaded)
    mujoco.mj_forward(loaded, data)
    groups = np.eye(6, dtype=np.uint8)[GROUP]
    for room in house.rooms:
        x, y = room.polygon.representative_point().coords[0]
        start = np.array([x, y, room.ceiling_m - 0.01])
        fall = mujoco.mj_ray(loaded, data, start, np.array([0.0, 0.0, -1.0]), groups, 1, -1, np.zeros(1, np.int32))
        assert 0.0 <= fall <= room.ceiling_m - 0.01 - room.floor_m + 1e-6
    for wall in house.walls:
        if wall.boundary.length < 0.1:
            continue
        middle = np.array([*(np.array(wall.start) + wall.end) / 2, (wall.bottom_m + wall.top_m) / 2])
        across = np.eye(3)[1 - wall.boundary.axis]
        assert mujoco.mj_ray(loaded, data, middle - 0.06 * across, across, groups, 1, -1, np.zeros(1, np.int32)) < 0.011


def test_a_folder_that_is_not_ours_is_left_alone(house, tmp_path):
    (tmp_path / "house_textures").mkdir()
    (tmp_path / "house_textures" / "thesis.txt").write_text("mine")
    with pytest.raises(LexisError, match="house_textures"):
        write_mjcf(house, tmp_path / "house.xml")
    assert not (tmp_path / "house.xml").exists() and (tmp_path / "house_textures" / "thesis.txt").read_text() == "mine"


@pytest.mark.parametrize("at", [".png", ".xml", ".txt"])
def test_a_full_disk_leaves_nothing_half_written(at, house, tmp_path, monkeypatch):
    """Whichever file does not fit, nothing remains: textures without a model would look like a complete export."""

    def full(path, *_, **__):
        raise OSError(errno.ENOSPC, "No space left on device", str(path))

    writing = "write_bytes" if at == ".png" else "write_text"
    real = getattr(Path, writing)
    monkeypatch.setattr(Path, writing, lambda path, *rest, **more: (full if at in path.name else real)(path, *rest, **more))
    with pytest.raises(LexisError, match="No space left on device"):
        write_mjcf(house, tmp_path / "house.xml")
    assert not list(tmp_path.iterdir())
