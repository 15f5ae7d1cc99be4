"""Changes of images reach the SLAM, and the laws about them find what they are made for."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.open_flat import OPEN_FLAT

from lexis.types import Observation, Percept
from sim.harness import Lexis
from sim.harness.adapters import OdometryOnly
from sim.suites.checks import NotBetter, examined
from sim.suites.image_changes import DarkerImages, ExchangedColours, OtherImages
from sim.suites.image_evidence import SimilaritiesFollowImages
from sim.suites.stream_changes import NoChange

IMAGE = np.array([[[10, 101, 250], [0, 1, 2]]], np.uint8)


def oracle():
    """LEXIS with the encoder that knows the truth."""
    return Lexis("oracle")


def shown(change, image, index=0):
    (seen,) = change.observations(Observation(index, 0.0, image, np.eye(4), np.eye(6)), index, None)
    return seen.image


def test_colours_are_exchanged_and_brightness_is_halved():
    np.testing.assert_array_equal(shown(ExchangedColours(), IMAGE), [[[250, 101, 10], [2, 1, 0]]])
    np.testing.assert_array_equal(shown(DarkerImages(), IMAGE), [[[5, 50, 125], [0, 0, 1]]])


def test_every_second_image_is_replaced_by_the_same_one():
    assert shown(OtherImages(), IMAGE, 4) is IMAGE
    np.testing.assert_array_equal(shown(OtherImages(), IMAGE, 5), np.zeros_like(IMAGE))


@pytest.mark.parametrize("change", [ExchangedColours(), DarkerImages()], ids=lambda change: type(change).__name__)
def test_changes_of_pixels_do_not_concern_percepts(change):
    assert not change.matters(OPEN_FLAT, None) and change.matters(
        replace(OPEN_FLAT, encoder="mini", fidelity="render"), None
    )


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


class Inverts(Lexis):
    """Is only right about embeddings whose sign was changed."""

    def __init__(self):
        super().__init__("oracle")

    def process(self, observation):
        super().process(inverted(observation))


class Inverted(NoChange):
    """The sign of all embeddings is changed."""

    def observations(self, observation, number, previous):
        yield inverted(observation)


def inverted(observation):
    assert isinstance(observation.image, Percept)
    return replace(observation, image=replace(observation.image, embedding=-observation.image.embedding))


@pytest.mark.parametrize(("slam", "holds"), [(oracle, True), (Inverts, False), (OdometryOnly, None)],
                         ids=["Lexis", "Inverts", "OdometryOnly"])  # fmt: skip
def test_a_slam_that_spoils_its_input_is_better_on_input_that_is_spoilt_the_opposite_way(slam, holds):
    law = NotBetter("inverted", "No better.", Inverted(), "labels.accuracy", tolerance=0.3)
    assert law.examine(examined(OPEN_FLAT, slam), slam).holds is holds


def test_a_change_of_pixels_is_not_tried_on_percepts():
    law = NotBetter("colours", "No better.", ExchangedColours(), "labels.accuracy", tolerance=0.3)
    assert law.examine(examined(OPEN_FLAT, oracle), oracle).holds is None
