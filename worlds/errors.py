"""The one base class of everything that `worlds` raises on purpose."""


class WorldsError(ValueError):
    """A house, spec or argument is not usable; the message names the place and what would be valid."""


class SpecError(WorldsError):
    """A house spec (or the JSON it came from) is malformed."""


class HouseError(WorldsError):
    """A well-formed spec describes a house that cannot stand or cannot be walked."""


def reworded(error: WorldsError, message: str) -> WorldsError:
    """An error of the same class and with the same notes, but another message."""
    other = type(error)(message)
    for note in getattr(error, "__notes__", ()):
        other.add_note(note)
    return other
