"""Files and folders that appear whole or not at all: written beside their place, then renamed."""

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lexis.errors import LexisError


@contextmanager
def replaced_file(path: Path) -> Iterator[Path]:
    """A file beside `path` that takes its place when the block ends well. Raises LexisError where it cannot be written."""
    try:
        if path.is_dir():
            raise LexisError(f"{path}: is a folder; valid: the name of a file")
        if path.exists() and not path.is_file():
            raise LexisError(f"{path}: is a device or a pipe, which cannot be replaced; valid: the name of a file")
        handle, name = tempfile.mkstemp(prefix=f".{path.name}-", dir=path.parent)
    except OSError as error:
        raise LexisError(f"{path}: cannot be written: {error.strerror}; valid: a file in a folder that exists") from None
    os.close(handle)
    beside = Path(name)
    try:
        yield beside
        beside.chmod(0o644)
        beside.replace(path)
    except OSError as error:
        raise LexisError(f"{path}: cannot be written: {error.strerror}; valid: a place with room for it") from None
    finally:
        beside.unlink(missing_ok=True)


@contextmanager
def replaced_folder(path: Path, marker: str) -> Iterator[Path]:
    """A folder beside `path` that takes its place when the block ends well.

    An earlier one is only replaced if it holds the file `marker`, or nothing. Raises LexisError for any other, and where
    `path` cannot be written.
    """
    check_replaceable(path, marker)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        beside = Path(tempfile.mkdtemp(prefix=f".{path.name}-", dir=path.parent))
    except OSError as error:
        raise LexisError(f"{path}: cannot be written: {error.strerror}; valid: a folder that can be made") from None
    try:
        yield beside
        beside.chmod(0o755)
        if path.exists():
            shutil.rmtree(path)
        beside.rename(path)
    except OSError as error:
        raise LexisError(f"{path}: cannot be written: {error.strerror}; valid: a place with room for it") from None
    finally:
        shutil.rmtree(beside, ignore_errors=True)


def check_replaceable(path: Path, marker: str) -> None:
    """Raise LexisError unless `path` is free, an empty folder, or one of ours, known by its `marker`, and can be written.

    For long work, that it does not end in vain; nothing is left behind.
    """
    try:
        ours = not path.exists() or (path.is_dir() and ((path / marker).is_file() or not any(path.iterdir())))
    except OSError as error:
        raise LexisError(f"{path}: cannot be looked into: {error.strerror}; valid: a folder that can be made") from None
    if path.is_file():
        raise LexisError(f"{path}: is a file; valid: the name of a folder")
    if not ours:
        raise LexisError(f"{path}: exists and holds no {marker}; valid: a new name, or an earlier one of its kind")
    try:
        # What may be written is best found by writing: permissions say nothing of file systems.
        tempfile.TemporaryDirectory(dir=next(folder for folder in path.resolve().parents if folder.exists())).cleanup()
    except OSError as error:
        raise LexisError(f"{path}: cannot be written: {error.strerror}; valid: a folder that can be made") from None
