"""Names of what LEXIS is given in a run: images, or what a model of the encoder makes of what is truly in view."""

FIDELITIES = ("render", "features")
ORACLE = "oracle"
"""An encoder that is told the truth: for tests of what comes after the encoder, never for a figure of LEXIS."""
