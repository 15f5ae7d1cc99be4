"""Names of the kinds of input that LEXIS gets in a run: rendered images or predicted features."""

from typing import Literal, get_args

Fidelity = Literal["render", "features"]
"""The kind of input that the SLAM gets. "render": rendered images. "features": the embeddings and loop closures that a
fitted model, the feature sensor, predicts without rendering."""
FIDELITIES: tuple[Fidelity, ...] = get_args(Fidelity)
ORACLE = "oracle"
"""Name of the encoder that knows the ground truth. It serves to test the stages after the encoder. Never report its results
as LEXIS's."""
ENCODERS_ON_FEATURES = ("mini", ORACLE)
"""Names of the encoders that the included feature model imitates."""


def may_be_imitated(encoder: str) -> bool:
    """Return whether the included feature model may stand for an encoder, given its name.

    A name with a colon may be a copy of `mini` under another path.
    """
    return encoder in ENCODERS_ON_FEATURES or ":" in encoder
