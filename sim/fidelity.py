"""Names of the kinds of input that a run gives to LEXIS."""

from typing import Literal, get_args

Fidelity = Literal["render", "features"]
"""What the SLAM gets. "render": rendered images. "features": the embeddings and loop closures that a fitted model, the
feature sensor, predicts without rendering."""
FIDELITIES: tuple[Fidelity, ...] = get_args(Fidelity)
ORACLE = "oracle"
"""Name of an encoder that is told the truth, for tests of the stages after it. Never report its results as LEXIS's."""
