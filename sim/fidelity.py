"""Fidelities of the simulated camera: rendered images, or embeddings that a feature model predicts from the true view."""

FIDELITIES = ("render", "features")
ORACLE = "oracle"
"""Name of an encoder that reads the ground truth. For tests of the later stages; never report its results as LEXIS's."""
