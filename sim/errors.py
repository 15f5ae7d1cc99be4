"""Exceptions of `sim`. All of them derive from `SimError`."""


class SimError(ValueError):
    """A run, an argument or the machine is unusable. The message says where, what is wrong, and what would be valid."""


class GraphicsError(SimError):
    """Off-screen OpenGL is missing or failed."""
