"""The errors that `lexis` raises on purpose; all derive from `LexisError`."""

import re


class LexisError(ValueError):
    """An argument, a file or a state is unusable; the message says where, what is wrong, and what would be valid."""


class ConfigError(LexisError):
    """A setting of LEXIS is outside its valid range."""


class ObservationError(LexisError):
    """An observation does not fit the camera, the sequence, or the geometry of a rigid motion."""


class EncoderError(LexisError):
    """A model is unknown, cannot be loaded or used, or does not fit the room names."""


class MapError(LexisError):
    """A map, or a file made from one, cannot be read, written or used; or the map was made with another encoder."""


class PlanError(LexisError):
    """The map lacks the requested room, or no path leads to the room."""


class DatasetError(LexisError):
    """A recorded run is incomplete or contradicts itself."""


_LONG_WORD = re.compile(r"(\S{60})\S{20,}(\S{40})")


def encodable(text: str) -> str:
    """Return a text that can be written in UTF-8: halves of surrogate pairs, as in undecodable file names, are escaped."""
    return text.encode("utf-8", "backslashreplace").decode()


def one_line(said: object, most: int = 240) -> str:
    """Put the text of an error on one line of at most `most` characters, which can be written in UTF-8.

    A longer text is shortened by leaving out the middles of long words, such as paths, and then the middle of the line.
    """
    line = encodable(" ".join(str(said).split())) or type(said).__name__
    if len(line) > most:
        line = _LONG_WORD.sub(r"\1...\2", line)
    if len(line) <= most:
        return line
    end = most // 3
    return f"{line[: most - end - 5]} ... {line[-end:]}"
