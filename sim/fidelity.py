"""Names of the kinds of input that a run gives to LEXIS."""

from typing import Literal, get_args

Fidelity = Literal["render", "features"]
"""Input of the SLAM. render: rendered images. features: embeddings and loops that the feature sensor predicts."""
FIDELITIES: tuple[Fidelity, ...] = get_args(Fidelity)
ORACLE = "oracle"
"""Name of an encoder that is told the truth, for tests of the stages after it. Never report its results as LEXIS's."""
