"""The one base class of everything that `lexis` raises on purpose."""


class LexisError(ValueError):
    """An argument, a file or a state is not usable; the message names the place and what would be valid."""


class ConfigError(LexisError):
    """A setting is outside its valid range."""


class ObservationError(LexisError):
    """An observation does not fit the camera, the sequence, or the geometry of a rigid motion."""


class EncoderError(LexisError):
    """A model is unknown, cannot be loaded, or does not fit the room names."""


class MapError(LexisError):
    """A map (or the file it came from) is malformed."""


class PlanError(LexisError):
    """There is no such room in the map, or no way to it."""


class DatasetError(LexisError):
    """A recorded run is incomplete or contradicts itself."""
