"""Whatever is wrong with a file, the answer is one of the package's errors: soon, and within bounds of memory.

Damage is drawn with fixed seeds. A few inputs of every kind are tried in the normal suite, thousands in the nightly one.
"""

import shutil

import damage
import numpy as np
import pytest
import small_inputs
from survey import MEMORY_BYTES, PROCESSOR_S, survey

from lexis.datasets import open_dataset
from lexis.errors import LexisError
from lexis.export import FORMATS, export_map
from lexis.map_io import load_map
from lexis.planner import plan
from sim.errors import SimError
from sim.features.model import load_features
from worlds.errors import WorldsError
from worlds.spec import HouseSpec
from worlds.validation import spec_problems

ERRORS = (LexisError, SimError, WorldsError)


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    """Whole inputs of every kind, each by the name of its file or folder."""
    folder = tmp_path_factory.mktemp("whole")
    small_inputs.write_all(folder)
    return folder


def many(smoke, nightly):
    """Numbers of inputs: of the normal suite, and of the nightly one."""
    return pytest.mark.parametrize("cases", [smoke, pytest.param(nightly, marks=pytest.mark.slow)])


def hold(found):
    """Nothing foreign, nothing long, nothing large; and the damage was such that most of it is noticed."""
    print(found)
    assert not found.foreign, "\n".join([str(found), *found.examples[:20]])
    assert found.longest_s <= PROCESSOR_S and found.peak_bytes <= MEMORY_BYTES
    assert found.refused > 0.2 * found.tried


@many(50, 5000)
def test_damaged_houses(cases, tmp_path):
    whole = small_inputs.houses()

    def attempt(rng, folder):
        text = damage.damaged_json(rng, whole[rng.integers(len(whole))])
        (folder / "house.json").write_bytes(
            damage.damaged_bytes(rng, text.encode()) if rng.random() < 0.1 else text.encode()
        )
        spec = HouseSpec.load(folder / "house.json")
        for problem in spec_problems(spec):
            raise WorldsError(problem)

    hold(survey(attempt, cases, 1, ERRORS, tmp_path))


@many(50, 3000)
def test_damaged_maps(cases, inputs, tmp_path):
    with np.load(inputs / "map" / "arrays.npz") as whole:
        arrays = {name: whole[name] for name in whole.files}

    def attempt(rng, folder):
        shutil.copytree(inputs / "map", folder / "map")
        if rng.random() < 0.7:
            (folder / "map" / "arrays.npz").write_bytes(damage.damaged_npz(rng, arrays))
        else:
            damage.damaged_file(rng, folder / "map" / str(rng.choice(["map.json", "map.json", "arrays.npz"])))
        lexis_map = load_map(folder / "map")
        for form in FORMATS:  # what is let in is good for everything
            export_map(lexis_map, form, folder / "out")
        plan(lexis_map, "kitchen", "office")

    hold(survey(attempt, cases, 2, ERRORS, tmp_path))


@many(50, 3000)
def test_damaged_feature_models(cases, inputs, tmp_path):
    with np.load(inputs / "features.npz") as whole:
        arrays = {name: whole[name] for name in whole.files}

    def attempt(rng, folder):
        path = folder / "features.npz"
        if rng.random() < 0.9:
            path.write_bytes(damage.damaged_npz(rng, arrays))
        else:
            shutil.copy(inputs / "features.npz", path)
            damage.damaged_file(rng, path)
        load_features(path)

    hold(survey(attempt, cases, 3, ERRORS, tmp_path))


@many(40, 1600)
def test_damaged_recordings(cases, inputs, tmp_path):
    def attempt(rng, folder):
        shutil.copytree(inputs / str(rng.choice(["tum", "euroc", "euroc", "bag", "mcap"])), folder / "run")
        files = [path for path in sorted(folder.rglob("*")) if path.is_file()]
        few = [path for path in files if path.suffix != ".png"]
        for path in rng.choice(few if rng.random() < 0.8 else files, 1 + int(rng.random() < 0.2), replace=False):
            damage.damaged_file(rng, path)
        for observation in open_dataset(folder / "run"):
            assert observation.image.shape == (24, 32, 3)

    hold(survey(attempt, cases, 4, ERRORS, tmp_path))
