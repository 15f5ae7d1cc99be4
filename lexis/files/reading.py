"""Safe reading of untrusted files: only regular files of bounded size are read, and every problem raises one type of error.

Nothing is unpickled or evaluated, pipes and devices are refused, and sizes stated in a file are checked before use.
"""

import io
import json
import os
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from lexis.errors import LexisError, one_line

MAX_LINE_CHARACTERS = 20_000
"""Largest number of characters in a line; lines of numbers are far shorter."""
_VALID = "; valid: "
_Model = TypeVar("_Model", bound=BaseModel)


@dataclass(frozen=True)
class FileKind:
    """What a reader expects of a file, and the error that the reader raises if the file is different."""

    valid: str
    """A description of a valid file, for messages."""
    max_bytes: int
    """Largest size of the file on disk [bytes]."""
    error: type[ValueError] = LexisError
    missing: str = "cannot be read"
    """Words of the message if the file cannot be opened."""
    unusable: str = "cannot be used"
    """Words of the message if the file's content is wrong."""

    def refusal(self, path: Path, reason: object) -> ValueError:
        """The error to raise if a file's content is wrong; the reason is put on one short line.

        A reason that says itself what is valid stands alone.
        """
        said = one_line(reason)
        valid = "" if _VALID in said else f"{_VALID}{self.valid}"
        return self.error(f"{path}: {self.unusable}: {said}{valid}")

    def unopened(self, path: Path, reason: object) -> ValueError:
        """The error to raise if a file cannot be opened; the reason is put on one short line."""
        return self.error(f"{path}: {self.missing}: {one_line(reason)}; valid: {self.valid}")


def open_file(path: Path, kind: FileKind) -> io.BufferedReader:
    """Open a regular file of at most `kind.max_bytes`. Raises the error of `kind` for anything else.

    Pipes and devices are refused, because reading them may never end.
    """
    try:
        status = _status(path, kind)
        if not stat.S_ISREG(status.st_mode):
            raise kind.unopened(path, "is a folder" if stat.S_ISDIR(status.st_mode) else "is a device or a pipe")
        if status.st_size > kind.max_bytes:
            raise kind.refusal(path, f"larger than {kind.max_bytes / 1e6:g} MB")
        return path.open("rb")
    except OSError as error:
        raise kind.unopened(path, error.strerror) from None


def _status(path: Path, kind: FileKind) -> os.stat_result:
    try:
        return os.stat(path)
    except ValueError:  # a null byte, or half of a surrogate pair
        raise kind.unopened(path, "is not a valid file name") from None


def read_bytes(path: Path, kind: FileKind) -> bytes:
    """The content of a file. Raises the error of `kind` if the file cannot be read or is larger than `kind.max_bytes`."""
    with open_file(path, kind) as file:
        try:
            content = file.read(kind.max_bytes + 1)
        except OSError as error:
            raise kind.unopened(path, error.strerror) from None
    if len(content) > kind.max_bytes:
        raise kind.refusal(path, f"larger than {kind.max_bytes / 1e6:g} MB")
    return content


def read_text(path: Path, kind: FileKind) -> str:
    """The content of a text file in UTF-8, with or without a byte order mark. Raises the error of `kind`."""
    try:
        return read_bytes(path, kind).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise kind.refusal(path, "is not text in UTF-8") from None


def numbered_lines(path: Path, kind: FileKind) -> Iterator[tuple[int, str]]:
    """Yield the lines of a text file with their numbers, from 1; blank lines and lines that begin with # are skipped.

    Raises the error of `kind` during iteration, not at the call.
    """
    with open_file(path, kind) as file, io.TextIOWrapper(file, encoding="utf-8-sig") as text:
        try:
            for number, line in enumerate(iter(lambda: text.readline(MAX_LINE_CHARACTERS + 1), ""), 1):
                if len(line) > MAX_LINE_CHARACTERS:
                    raise kind.refusal(path, f"line {number} has more than {MAX_LINE_CHARACTERS} characters")
                if line.strip() and not line.startswith("#"):
                    yield number, line.rstrip("\r\n")
        except UnicodeDecodeError:
            raise kind.refusal(path, "is not text in UTF-8") from None
        except OSError as error:
            raise kind.unopened(path, error.strerror) from None


def read_json(path: Path, kind: FileKind) -> Any:
    """The data of a JSON file. Raises the error of `kind`, also for a field that an object has twice."""
    text = read_text(path, kind)
    try:
        return json.loads(text, object_pairs_hook=_fields)
    except _RepeatedError as error:
        raise kind.refusal(path, str(error)) from None
    except RecursionError:
        raise kind.refusal(path, "is nested too deeply") from None
    except json.JSONDecodeError as error:
        raise kind.refusal(path, f"is not JSON: {error}") from None
    except ValueError:  # Python refuses to convert integers of more than 4300 digits
        raise kind.refusal(path, "has a number of too many digits") from None


class _RepeatedError(Exception):
    """A field that an object has twice, which JSON itself permits."""


def _fields(pairs: list[tuple[str, object]]) -> dict[str, object]:
    fields: dict[str, object] = {}
    for name, value in pairs:
        if name in fields:
            raise _RepeatedError(f"has the field {name!r:.80} twice in one object; valid: once")
        fields[name] = value
    return fields


def read_model(path: Path, kind: FileKind, model: type[_Model]) -> _Model:
    """The data of a JSON file, validated by `model`. Raises the error of `kind`, which names the first wrong field."""
    content = read_bytes(path, kind)
    try:
        checked = model.model_validate_json(content)
        json.loads(content, object_pairs_hook=_fields)  # the model takes the last of two fields of one name
        return checked
    except _RepeatedError as error:
        raise kind.refusal(path, str(error)) from None
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        place = f"{one_line('.'.join(map(str, first['loc'])), 100)}: " if first["loc"] else ""
        raise kind.refusal(path, f"{place}{first['msg']}") from None


def read_yaml(path: Path, kind: FileKind) -> dict[str, Any]:
    """The mapping that a YAML file holds. Every scalar in it is read as text. Raises the error of `kind`.

    Aliases are refused and tags are ignored: calibration files need neither, and a few lines with aliases can expand to more
    data than memory holds.
    """
    text = read_text(path, kind).removeprefix("%YAML:1.0")
    try:
        data = yaml.load(text, Loader=_TextLoader)
    except Exception as error:  # PyYAML also passes on Python's errors, for deep nesting or wrong types
        raise kind.refusal(path, f"is not YAML: {one_line(error, 100)}") from None
    if not isinstance(data, dict):
        raise kind.refusal(path, "holds no keys")
    return data


class _TextLoader(yaml.BaseLoader):  # type: ignore[misc]
    """Loads mappings, lists and texts, and refuses aliases."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("aliases are not read")
        return super().compose_node(parent, index)
