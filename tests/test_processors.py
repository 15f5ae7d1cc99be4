"""A run makes the same decisions on every processor and with every number of threads; poses agree within a nanometre.

OPENBLAS_CORETYPE makes the numerical library use the code for another processor, which sums in another order. Code for a
processor with more instructions than this one has would crash.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
from helpers.decisions import decisions

from sim.harness import Scenario, run
from sim.render.rig import RigConfig
from worlds.presets import sample_from_rooms, sample_house

SMALL = {
    "two rooms": Scenario(
        house=sample_from_rooms(("kitchen", "bedroom"), seed=31),
        seed=5,
        length_m=13.0,
        rig=RigConfig("wide", 200, 150, 80.0),
    ),
    "no pixels, no drift": Scenario(
        house=sample_house("home", 500, rooms=6), seed=500, fidelity="features", frame_rate_hz=2.0, odometry="perfect"
    ),
}
HOMES = {f"home {seed}": Scenario(preset="home", seed=seed) for seed in (7, 500, 501, 502, 503, 504)}
"""The demo, which is also the first test of README.md, and the homes of `lexis-sim bench segmentation`."""
RUNS = SMALL | HOMES
REFERENCE = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OPENBLAS_CORETYPE": "Haswell"}
ENVIRONMENTS = {
    "two threads": {"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2", "OPENBLAS_CORETYPE": "Haswell"},
    "Zen": {"OPENBLAS_CORETYPE": "Zen"},
    "Nehalem": {"OPENBLAS_CORETYPE": "Nehalem"},
    "SkylakeX": {"OPENBLAS_CORETYPE": "SkylakeX"},
    "one core": {"ONE_CORE": "1"},
}
HAS_AVX512 = "avx512f" in Path("/proc/cpuinfo").read_text(encoding="utf-8").split()
CLOSE_M = 1e-9


def decided(names, environment):
    """Decisions of runs by name, computed in a separate process with the given environment variables."""
    command = [sys.executable, __file__, *names]
    inherited = {name: value for name, value in os.environ.items() if name not in REFERENCE}
    found = subprocess.run(command, env=inherited | environment, stdout=subprocess.PIPE, text=True, check=True).stdout
    return json.loads(found)


def assert_alike(here, there):
    for name, expected in here.items():
        found = dict(there[name])
        np.testing.assert_allclose(found.pop("poses"), expected["poses"], rtol=0.0, atol=CLOSE_M, err_msg=name)
        for what, value in found.items():
            assert value == expected[what], f"{name}: {what}"
        assert found["plans"] == found["plans_from_file"], name


@pytest.fixture(scope="module")
def small():
    return decided(SMALL, REFERENCE)


@pytest.fixture(scope="module")
def homes():
    return decided(HOMES, REFERENCE)


def test_another_processor_and_two_threads_decide_the_same(small):
    assert_alike(small, decided(SMALL, ENVIRONMENTS["two threads"] | ENVIRONMENTS["Nehalem"]))
    assert all(found["loops"] for found in small.values())


@pytest.mark.slow
@pytest.mark.parametrize("environment", ENVIRONMENTS.values(), ids=ENVIRONMENTS.keys())
def test_homes_are_decided_the_same_everywhere(homes, environment):
    if environment is ENVIRONMENTS["SkylakeX"] and not HAS_AVX512:
        pytest.skip("this processor cannot run code for SkylakeX")
    assert_alike(homes, decided(HOMES, environment))


@pytest.mark.slow
def test_every_plan_of_the_demo_arrives(homes):
    assert all(success for _, _, success, _ in homes["home 7"]["drives"])


if __name__ == "__main__":
    if "ONE_CORE" in os.environ:
        os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])
    with tempfile.TemporaryDirectory() as folder:
        print(json.dumps({name: decisions(run(RUNS[name]), Path(folder) / "map") for name in sys.argv[1:]}))
