"""Types are checked at run time in every package: without the hook in conftest.py, wrong types would pass unseen."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from beartype.roar import BeartypeCallHintViolation
from jaxtyping import TypeCheckError

from lexis.maths.se3 import upright
from sim.tours.view import view_along
from worlds.variant import variant

TOP = Path(__file__).parents[1]


@pytest.mark.parametrize(
    "call",
    [
        pytest.param(lambda: upright("north", (0.0, 0.0, 0.0)), id="lexis"),
        pytest.param(lambda: view_along("a house", (), 0.5, True), id="sim"),
        pytest.param(lambda: variant("a house", openness=0.5), id="worlds"),
    ],
)
def test_an_argument_of_a_wrong_type_is_refused_in_every_package(call):
    with pytest.raises((BeartypeCallHintViolation, TypeCheckError)):
        call()


def test_a_run_of_lexis_passes_the_checks_of_the_nightly_session():
    """An annotation that gives one name to two lengths shows here, and not only at night."""
    command = [sys.executable, "-m", "pytest", "-q", "tests/sim/suites/test_consistency.py"]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    tests = subprocess.run(command, cwd=TOP, env=environment | {"CHECK_AXES": "1"}, stdout=subprocess.PIPE, text=True)
    assert tests.returncode == 0, tests.stdout
