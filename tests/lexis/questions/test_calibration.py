"""Calibrations: loading inverts saving, damaged or foreign ones are refused, and the shipped one belongs to `mini`."""

import json
from dataclasses import replace

import numpy as np
import pytest
from helpers.map_builder import ENCODER
from helpers.reading_encoder import ReadingEncoder

from lexis.encoder.open_clip_encoder import load_encoder
from lexis.errors import LexisError
from lexis.questions.calibration import (
    MINI_CALIBRATION,
    Calibration,
    familiarity,
    find_calibration,
    load_calibration,
    save_calibration,
)

CALIBRATION = Calibration(ENCODER.fingerprint, ("office", "kitchen"), base=0.1, slope=0.5, temperature=0.04)
VECTORS = dict(zip(("office", "kitchen", "desk", "moon"), np.array(
    [[1, 0, 0], [0, 1, 0], [0.6, 0.0, 0.8], [0, 0, 1]], np.float32), strict=True))  # fmt: skip


@pytest.fixture
def encoder():
    return ReadingEncoder(VECTORS, ENCODER)


def test_the_probability_is_a_half_at_the_threshold_and_the_odds_are_e_a_temperature_above(encoder):
    texts = ("office", "desk", "moon")
    questions = encoder.encode_texts(texts)
    np.testing.assert_allclose(familiarity(questions, CALIBRATION.room_names, encoder), [1.0, 0.6, 0.0], atol=1e-6)
    thresholds = np.array([[0.6, 0.4, 0.1]])
    p = CALIBRATION.probabilities(np.concatenate([thresholds, thresholds + 0.04]), questions, encoder)
    np.testing.assert_allclose(p / (1 - p), [[1.0] * 3, [np.e] * 3], rtol=1e-5)


def test_loading_gives_back_what_was_saved(encoder, tmp_path):
    save_calibration(CALIBRATION, tmp_path / "c.json")
    assert load_calibration(tmp_path / "c.json") == CALIBRATION == find_calibration(encoder, tmp_path / "c.json")


def test_a_given_calibration_of_other_weights_is_refused_and_the_shipped_one_ignored(tmp_path):
    other = ReadingEncoder(VECTORS, replace(ENCODER, fingerprint="1" * 64))
    save_calibration(CALIBRATION, tmp_path / "c.json")
    with pytest.raises(LexisError, match="fitted to weights 00000000, and those of 'test' are 11111111"):
        find_calibration(other, tmp_path / "c.json")
    assert find_calibration(other) is None


def test_the_shipped_one_is_that_of_the_shipped_weights():
    """If this fails, run lexis-sim calibrate-queries."""
    assert load_calibration(MINI_CALIBRATION).fingerprint == load_encoder("mini").fingerprint


@pytest.mark.parametrize(
    ("change", "says"),
    [({"schema": 2}, "schema"), ({"temperature": 0.0}, "temperature"), ({"room_names": []}, "room_names"), ({"x": 1}, "x")],
)
def test_a_damaged_one_is_refused(tmp_path, change, says):
    save_calibration(CALIBRATION, tmp_path / "c.json")
    (tmp_path / "c.json").write_text(json.dumps(json.loads((tmp_path / "c.json").read_text()) | change))
    with pytest.raises(LexisError, match=says) as error:
        load_calibration(tmp_path / "c.json")
    assert "\n" not in str(error.value)


def test_what_is_no_file_is_refused(tmp_path):
    with pytest.raises(LexisError, match="cannot be read"):
        load_calibration(tmp_path / "absent.json")
