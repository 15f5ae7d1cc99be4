"""Replaced images reach the SLAM, and the law about similarities finds those of another frame."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.open_flat import OPEN_FLAT

from lexis.types import Observation
from sim.harness import Lexis
from sim.harness.adapters import OdometryOnly
from sim.suites.checks import examined
from sim.suites.image_evidence import OtherImages, SimilaritiesFollowImages

IMAGE = np.array([[[10, 101, 250], [0, 1, 2]]], np.uint8)


def oracle():
    """LEXIS with the encoder that knows the truth."""
    return Lexis("oracle")


def shown(change, image, index=0):
    (seen,) = change.observations(Observation(index, 0.0, image, np.eye(4), np.eye(6)), index, None)
    return seen.image


def test_every_second_image_is_replaced_by_the_same_one():
    assert shown(OtherImages(), IMAGE, 4) is IMAGE
    np.testing.assert_array_equal(shown(OtherImages(), IMAGE, 5), np.zeros_like(IMAGE))


class LabelsLate(Lexis):
    """Takes the similarities of every frame from the frame before it."""

    def __init__(self):
        super().__init__("oracle")

    def finish(self):
        claims = super().finish()
        return replace(claims, similarities=np.roll(claims.similarities, 1, axis=0))


@pytest.mark.parametrize(
    ("slam", "holds"), [(oracle, True), (LabelsLate, False), (OdometryOnly, None)],
    ids=["Lexis", "LabelsLate", "OdometryOnly"],
)  # fmt: skip
def test_similarities_of_another_frame_are_found(slam, holds):
    assert SimilaritiesFollowImages().examine(examined(OPEN_FLAT, slam), slam).holds is holds
