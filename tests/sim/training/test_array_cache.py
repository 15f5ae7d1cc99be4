"""Cached arrays: made once, and refused where they were made from anything other than what is asked for."""

import numpy as np
import pytest

from sim.errors import SimError
from sim.training import array_cache as module
from sim.training.array_cache import cached_arrays, house_origin, loaded
from sim.training.houses import TRAINING_SEEDS, HouseDraw

ORIGINS = ("way", "house")
HOUSE = HouseDraw("uh2-apt", TRAINING_SEEDS[0])


@pytest.fixture
def path(tmp_path):
    """A file for arrays in a folder of its own."""
    file = tmp_path / "folder" / "a.npz"
    cached_arrays(file, ORIGINS, lambda: {"n": np.arange(3), "x": np.eye(2)})
    return file


def test_arrays_are_made_once(path):
    arrays = cached_arrays(path, ORIGINS, lambda: pytest.fail("made again"))
    assert set(arrays) == {"n", "x"}
    np.testing.assert_array_equal(arrays["n"], np.arange(3))
    np.testing.assert_array_equal(arrays["x"], np.eye(2))


def test_arrays_of_another_origin_are_refused(path):
    assert set(loaded(path, ORIGINS[:1])) == {"n", "x"}
    for other in (("way", "other house"), ("other way", "house"), ("other way",), (*ORIGINS, "more")):
        with pytest.raises(SimError, match=r"a\.npz: made from other.*delete its folder"):
            loaded(path, other)
    np.savez(path, n=np.arange(3))
    with pytest.raises(SimError, match="delete its folder"):
        loaded(path, ORIGINS)


@pytest.mark.parametrize("damaged", [b"", b"PK", b"no arrays", None])
def test_a_damaged_file_is_named(path, damaged):
    path.write_bytes(path.read_bytes()[:-100] if damaged is None else damaged)
    with pytest.raises(SimError, match=r"a\.npz: cannot be read.*delete it"):
        loaded(path, ORIGINS)


def test_houses_of_another_draw_or_built_otherwise_have_another_origin(monkeypatch):
    changes = (
        {},
        {"seed": 1},
        {"preset": "home"},
        {"texture": "poor"},
        {"light": "dim"},
        {"openness": 0.7},
        {"clutter": 1.5},
    )
    found = [house_origin(HOUSE._replace(**change)) for change in changes]
    assert len(set(found)) == len(changes) and found[0] == house_origin(HOUSE)
    build = module.build_house
    monkeypatch.setattr(module, "build_house", lambda spec: build(spec.model_copy(update={"clutter": 0.9})))
    assert house_origin(HOUSE) != found[0]
