"""The exceptions of the package `worlds`; `WorldsError` is the base class of all."""


class WorldsError(ValueError):
    """A house, spec or argument cannot be used; the message names the place and what would be valid."""


class SpecError(WorldsError):
    """A house spec (or the JSON it came from) is malformed."""


class HouseError(WorldsError):
    """A well-formed spec describes an impossible house: it cannot be built, or its rooms cannot all be reached on foot."""


def reworded(error: WorldsError, message: str) -> WorldsError:
    """An error of the same class and with the same notes, but another message."""
    other = type(error)(message)
    for note in getattr(error, "__notes__", ()):
        other.add_note(note)
    return other
