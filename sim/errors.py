"""The one base class of everything that `sim` raises on purpose."""


class SimError(ValueError):
    """A run, argument or machine is not usable; the message says what was wrong, where, and what would be valid."""


class GraphicsError(SimError):
    """No off-screen OpenGL is at hand."""
