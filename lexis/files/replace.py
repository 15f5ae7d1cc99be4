"""Files and folders that appear whole or not at all: written beside their place, then renamed."""

import errno
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path

from lexis.errors import LexisError
from lexis.files.swap import swap, sync, sync_folder
from lexis.files.workshop import clear, workshop

_TRIES = 100
"""How often a folder is put in its place while other processes put theirs there."""
_OCCUPIED = (errno.EEXIST, errno.ENOTEMPTY, errno.ENOTDIR)


@contextmanager
def replaced_file(path: Path) -> Iterator[Path]:
    """A path beside `path`, where nothing is yet; the file written there takes its place when the block ends well.

    A symbolic link is followed. Raises LexisError where the file cannot be written. If it is written and cannot take its
    place, it is kept under a similar name, which the error tells.
    """
    with _written(path, "a place with room for it, in a folder that exists"):
        target = _followed(path)
        if target.is_dir():
            raise LexisError(f"{path}: is a folder; valid: the name of a file")
        if target.exists() and not target.is_file():
            raise LexisError(f"{path}: is a device or a pipe, which cannot be replaced; valid: the name of a file")
        with workshop(target.parent) as folder:
            new = folder / "new" / target.name
            yield new
            _put(path, new, target, lambda: new.replace(target))


@contextmanager
def replaced_folder(path: Path, marker: str) -> Iterator[Path]:
    """An empty folder beside `path` that takes its place when the block ends well.

    An earlier one is only replaced if it holds the file `marker`, or nothing; whoever looks, or kills this process, finds
    the earlier or the new one, whole. A symbolic link is followed. Raises LexisError for any other folder, and where `path`
    cannot be written. If the new folder is written and cannot take its place, it is kept under a similar name, which the
    error tells.
    """
    check_replaceable(path, marker)
    target = _followed(path)
    with _written(path, "a place with room for it, where a folder can be made"):
        target.parent.mkdir(parents=True, exist_ok=True)
        with workshop(target.parent) as folder:
            new = folder / "new" / target.name
            new.mkdir()
            yield new
            _put(path, new, target, lambda: _replace_folder(path, new, target, folder / "old" / target.name, marker))


def check_replaceable(path: Path, marker: str) -> None:
    """Raise LexisError unless `path` is free, an empty folder, or one of ours, known by its `marker`, and can be written.

    For long work, that it does not end in vain; nothing is left behind.
    """
    try:
        target = _followed(path)
        clear(target.parent)
        _check_ours(path, target, marker)
    except OSError as error:
        raise LexisError(f"{path}: cannot be looked into: {error.strerror}; valid: a folder that can be made") from None
    if os.path.ismount(target):
        raise LexisError(f"{path}: is a mount point, which cannot be replaced; valid: a folder inside it")
    # What may be written is best found by writing: permissions say nothing of file systems.
    place = next(folder for folder in target.parents if folder.exists())
    with _written(path, "a folder that can be made"), workshop(place):
        pass


def _followed(path: Path) -> Path:
    """Where `path` leads, all symbolic links followed. Raises OSError for a loop of them."""
    target = Path(os.path.realpath(path))
    with suppress(FileNotFoundError, NotADirectoryError):
        target.stat()
    return target


def _check_ours(path: Path, target: Path, marker: str) -> None:
    """Raise LexisError unless there is nothing at `target`, an empty folder, or one that holds `marker`."""
    try:
        # One listing: between two looks another process may have put its folder there.
        names = os.listdir(target)
    except FileNotFoundError:
        return
    except NotADirectoryError:
        if not os.path.lexists(target):  # a folder above it is a file: whoever writes there finds that
            return
        raise LexisError(f"{path}: is a file; valid: the name of a folder") from None
    if names and marker not in names:
        raise LexisError(f"{path}: exists and holds no {marker}; valid: a new name, or an earlier one of its kind")


@contextmanager
def _written(path: Path, valid: str) -> Iterator[None]:
    """Errors of the system as LexisError."""
    try:
        yield
    except OSError as error:
        raise LexisError(f"{path}: cannot be written: {error.strerror or error}; valid: {valid}") from None


def _put(path: Path, new: Path, target: Path, replace: Callable[[], object]) -> None:
    """Replace `target` by `new`, which is on the disk before; if that fails, keep `new` under a similar name."""
    sync(new)
    try:
        with _written(path, "a name that nobody else writes to"):
            replace()
    except LexisError as error:
        kept = next(name for i in count(1) if not os.path.lexists(name := target.with_stem(f"{target.stem}-{i}")))
        new.rename(kept)
        raise LexisError(f"{error}; what was to be written there is kept as {kept}") from None
    finally:
        sync_folder(target.parent)


def _replace_folder(path: Path, new: Path, target: Path, old: Path, marker: str) -> None:
    """Put the folder `new` in the place of `target`, whatever other processes put there meanwhile.

    Raises LexisError if what is there is not ours, and OSError.
    """
    for _ in range(_TRIES):
        try:
            new.rename(target)
            return
        except OSError as error:
            if error.errno not in _OCCUPIED:
                raise
        _check_ours(path, target, marker)
        try:
            _swap_with_ours(path, new, target, old, marker)
            return
        except OSError as error:
            if error.errno not in (errno.ENOENT, *_OCCUPIED):
                raise
    raise LexisError(f"{path}: other processes keep replacing it; valid: a name that nobody else writes to")


def _swap_with_ours(path: Path, new: Path, target: Path, old: Path, marker: str) -> None:
    """Swap two folders; swap them back, and raise LexisError, if what was there turns out not to be ours."""
    replaced = swap(new, target, old)
    try:
        _check_ours(path, replaced, marker)
    except LexisError:
        swap(replaced, target, old if replaced == new else new)
        raise
