"""Replaced images reach the SLAM, and the law about similarities finds those of another frame."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.open_flat import OPEN_FLAT

from lexis.types import Observation
from sim.harness import Lexis
from sim.harness.adapters import OdometryOnly
from sim.harness.estimate import EstimatedLoops
from sim.suites.checks import evaluated_run
from sim.suites.image_evidence import JumbledImages, JumbledImagesAreNotRecognised, OtherImages, SimilaritiesFollowImages

IMAGE = np.array([[[10, 101, 250], [0, 1, 2]]], np.uint8)


def oracle():
    """LEXIS with the encoder that knows the truth."""
    return Lexis("oracle")


def shown(change, image, index=0):
    (seen,) = change.observations(Observation(index, 0.0, image, np.eye(4), np.eye(6)), None)
    return seen.image


def test_every_second_image_is_replaced_by_the_same_one():
    assert shown(OtherImages(), IMAGE, 4) is IMAGE
    np.testing.assert_array_equal(shown(OtherImages(), IMAGE, 5), np.zeros_like(IMAGE))


def test_jumbled_images_show_details_beside_their_place_from_some_observation_on():
    y, x = np.indices((120, 160), np.uint8)
    image = np.stack([y, x, x], axis=2)
    change = JumbledImages(first=3, most_px=7)
    assert shown(change, image, 2) is image
    jumbled = shown(change, image, 3).astype(int)
    np.testing.assert_array_equal(jumbled, shown(change, image, 3))
    assert (jumbled != shown(change, image, 4)).mean() > 0.5, "each image is jumbled in another way"
    away = jumbled[:100, :140, :2] - np.stack([y, x], axis=2)[:100, :140]  # tiles at the edge may show the edge itself
    assert np.abs(away).max() == 7
    tile = away[20:40, 20:40].reshape(-1, 2)
    assert np.ptp(tile, axis=0).max() == 0 and len(np.unique(away.reshape(-1, 2), axis=0)) > 20


class WithoutGeometry(OdometryOnly):
    """Estimates loop closures whatever the images show."""

    def finish(self):
        estimates = super().finish()
        query = np.arange(30, len(estimates.frames))
        return replace(estimates, loops=EstimatedLoops(query, query - 30, np.stack([np.eye(4)] * len(query))))


@pytest.mark.parametrize(
    ("slam", "fidelity", "holds"),
    [
        (Lexis, "render", True),
        (WithoutGeometry, "render", False),
        (oracle, "features", None),
        (OdometryOnly, "render", None),
    ],
)
def test_a_slam_that_confirms_loops_without_looking_at_their_geometry_is_found(slam, fidelity, holds):
    walk, law = replace(OPEN_FLAT, frame_rate_hz=3.0, length_m=32.0), JumbledImagesAreNotRecognised(change=JumbledImages(60))
    scenario = replace(walk, fidelity="render", encoder="mini") if fidelity == "render" else walk
    assert law.examine(evaluated_run(scenario, slam), slam).holds is holds


class LabelsLate(Lexis):
    """Takes the similarities of every frame from the frame before it."""

    def __init__(self):
        super().__init__("oracle")

    def finish(self):
        estimates = super().finish()
        return replace(estimates, similarities=np.roll(estimates.similarities, 1, axis=0))


@pytest.mark.parametrize(
    ("slam", "holds"), [(oracle, True), (LabelsLate, False), (OdometryOnly, None)],
    ids=["Lexis", "LabelsLate", "OdometryOnly"],
)  # fmt: skip
def test_similarities_of_another_frame_are_found(slam, holds):
    assert SimilaritiesFollowImages().examine(evaluated_run(OPEN_FLAT, slam), slam).holds is holds
