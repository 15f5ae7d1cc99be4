"""Types are checked at run time in every package: without the hook in conftest.py, wrong types would pass unseen."""

import pytest
from beartype.roar import BeartypeCallHintViolation
from jaxtyping import TypeCheckError

from lexis.maths.se3 import upright
from sim.tours.view import view_along
from worlds.variant import variant


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
