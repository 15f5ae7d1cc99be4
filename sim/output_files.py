"""Checks of the files and folders that a command is to write, before minutes or hours of work."""

import os
import tempfile
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from sim.errors import SimError


def check_output_file(path: Path) -> None:
    """Raise `SimError` unless the folder of a file exists and can be written to, and nothing but a file has its name."""
    folder = path.absolute().parent
    with _refused(path, "a file in a folder that can be written to"):
        if not folder.is_dir():
            raise SimError(f"{path}: its folder does not exist; valid: a file in a folder that exists")
        if path.exists() and not path.is_file():
            raise SimError(f"{path}: is {'a folder' if path.is_dir() else 'a device or a pipe'}; valid: the name of a file")
        tempfile.TemporaryFile(dir=folder).close()


def check_not_input(path: Path, source: Path) -> None:
    """Raise `SimError` if the file to write is the file `source` that is read, by whatever name or link."""
    if os.path.realpath(path) == os.path.realpath(source):
        raise SimError(f"{path}: is the file that is read, and would be replaced; valid: a name of another file")


def check_ending(path: Path, endings: Collection[str]) -> None:
    """Raise `SimError` unless the name of a file ends in one of `endings`, such as ".svg", in small letters or capitals."""
    if path.suffix.lower() not in endings:
        raise SimError(f"{path}: cannot be written in this format; valid: a name that ends in {' or '.join(endings)}")


def make_output_folder(folder: Path) -> None:
    """Make a folder unless it exists. Raises `SimError` if it cannot be made, or if no file can be written in it."""
    with _refused(folder, "a folder that can be made and written to"):
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()


@contextmanager
def _refused(path: Path, valid: str) -> Iterator[None]:
    """Raise `SimError` about the path, with what would be valid, if the block cannot write."""
    try:
        yield
    except OSError as error:
        raise SimError(f"{path}: cannot be written: {error.strerror}; valid: {valid}") from None
