"""Exceptions of `sim`. All of them derive from `SimError`."""


class SimError(ValueError):
    """A run, an argument or the machine is unusable. The message names the place, the problem and the valid values."""


class GraphicsError(SimError):
    """Off-screen OpenGL is missing or failed."""
