"""LEXIS without language, and without some of its rules."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from lexis.config import PAPER, Config
from lexis.types import Camera, Observation
from sim.harness.adapters import Lexis
from sim.harness.estimate import Estimate
from sim.harness.feature_input import FeatureInput

LEXIS_VARIANTS: Mapping[str, Config] = MappingProxyType(
    {
        "LEXIS": Config(),
        "LEXIS, paper": PAPER,
        "LEXIS, no refinement": replace(PAPER, labels=replace(PAPER.labels, method="image")),
        "LEXIS, no merging": replace(PAPER, segmentation=replace(PAPER.segmentation, adjacency_m=1e-6)),
    }
)
"""Settings of LEXIS by name. The last two use the methods of the paper without one rule: the refinement of labels, and the
merging of neighbouring clusters of one label. Clusters with consecutive keyframes still merge."""


class WordlessLexis:
    """LEXIS without language: every room has the same name, and stairs are found by their change of height."""

    def __init__(self) -> None:
        """Prepare a run of LEXIS with its usual settings."""
        self._lexis = Lexis()

    @property
    def _names(self) -> tuple[str, str]:
        return "room", Config().labels.stairs_name

    def start(self, camera: Camera, room_names: Sequence[str]) -> None:
        """Begin a run on images. The names of rooms are ignored."""
        self._lexis.start(camera, self._names)

    def start_on_features(self, camera: Camera, room_names: Sequence[str], features: FeatureInput) -> None:
        """Begin a run on percepts of the feature sensor. The names of rooms are ignored."""
        self._lexis.start_on_features(camera, self._names, features)

    def process(self, observation: Observation) -> None:
        """Add the next observation to the map."""
        self._lexis.process(observation)

    def finish(self) -> Estimate:
        """Return LEXIS's estimate without labels."""
        return replace(self._lexis.finish(), labels=None, baseline_labels=None, similarities=None)
