from dataclasses import FrozenInstanceError, fields

import pytest

from lexis.config import (
    Config,
    KeyframeConfig,
    LabelConfig,
    LandmarkConfig,
    PlaceRecognitionConfig,
    PlannerConfig,
    PoseGraphConfig,
    SegmentationConfig,
    VerificationConfig,
)
from lexis.errors import ConfigError, LexisError
from lexis.keyframes import MAX_STEP_M

BAD = [
    (KeyframeConfig, "spacing_m", 0.0),
    (KeyframeConfig, "spacing_m", float("nan")),
    (KeyframeConfig, "spacing_m", MAX_STEP_M),  # every step would count as a gap, and there would be no plans
    (KeyframeConfig, "rotation_rad", -0.1),
    (KeyframeConfig, "supports", 0),
    (LandmarkConfig, "akaze_threshold", 0.0),
    (LandmarkConfig, "ratio", 1.1),
    (LandmarkConfig, "min_views", 1),
    (LabelConfig, "neighbours", 0),
    (LabelConfig, "every", 0),
    (SegmentationConfig, "distance_m", -1.0),
    (PlaceRecognitionConfig, "candidates", -1),
    (VerificationConfig, "min_inliers", 3),
    (VerificationConfig, "min_cells", 37),
    (PoseGraphConfig, "outlier_threshold", 0.0),
    (PlannerConfig, "shortcut_m", -0.1),
]


@pytest.mark.parametrize(("kind", "setting", "value"), BAD)
def test_a_bad_value_is_refused_by_name(kind, setting, value):
    with pytest.raises(ConfigError, match=rf"\.{setting} is {value}; valid: "):
        kind(**{setting: value})


def test_stages_that_contradict_each_other_are_refused():
    with pytest.raises(ConfigError, match=r"landmarks\.min_views is 4; valid: "):
        Config(keyframes=KeyframeConfig(supports=1), landmarks=LandmarkConfig(min_views=4))


def test_an_optimisation_moves_all_keyframes_since_the_one_before():
    with pytest.raises(ConfigError, match=r"pose_graph\.window is 5; valid: >= every = 10"):
        PoseGraphConfig(window=5, every=10)


def test_the_defaults_of_refinement_are_in_the_ranges_of_the_paper():
    config = Config()
    assert 3 <= config.labels.neighbours <= 7
    assert 7 <= config.labels.every <= 12


def test_settings_cannot_be_changed_behind_a_stage_s_back():
    for stage in fields(Config):
        with pytest.raises(FrozenInstanceError):
            getattr(Config(), stage.name).anything = 1


def test_every_error_is_a_lexis_error():
    assert issubclass(ConfigError, LexisError)
