"""Atomic writing of files and folders, which appear complete or not at all: write beside the target, then rename.

1. Write the new file or folder into a hidden folder beside the target (`temporary_folder`), on the same file system, so
   that it can be renamed.
2. Sync it to the disk, so that a power cut cannot leave a renamed but empty file.
3. Rename it to the target. For a folder that exists, exchange the two names (`lexis.files.swap`), so that the target exists
   at any time.

A folder is only replaced if this module has written all files in it, and nobody has changed them since. Every folder
therefore holds a list of its files with their checksums, `.lexis-contents`.
"""

import errno
import hashlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path

from lexis.errors import LexisError
from lexis.files.swap import swap, sync, sync_folder
from lexis.files.temporary_folder import remove_abandoned, temporary_folder

CONTENTS = ".lexis-contents"
"""File in every folder that `replaced_folder` has written: checksum and name of every other file in it, one a line."""
_CACHES = {"__pycache__", ".pytest_cache", ".hypothesis"}
"""Folders in which Python and pytest keep what can be made again, for example when a written test is run."""
_TRIES = 100
"""Number of attempts to replace a folder that other processes keep replacing too."""
_OCCUPIED = (errno.EEXIST, errno.ENOTEMPTY, errno.ENOTDIR)


@contextmanager
def replaced_file(path: Path) -> Iterator[Path]:
    """Yield a temporary path; the file written to it replaces `path` if the `with` block ends without an exception.

    A symbolic link is followed. Raises LexisError if the file cannot be written. If it was written but cannot be renamed to
    `path`, it is kept under a similar name, which the error states.
    """
    with _os_errors_as_lexis_errors(path, "a place with room for it, in an existing folder"):
        target = _resolved(path)
        if target.is_dir():
            raise LexisError(f"{path}: is a folder; valid: the name of a file")
        if target.exists() and not target.is_file():
            raise LexisError(f"{path}: is a device or a pipe, which cannot be replaced; valid: the name of a file")
        with temporary_folder(target.parent) as folder:
            new = folder / "new" / target.name
            yield new
            _install(path, new, target, lambda: new.replace(target))


@contextmanager
def replaced_folder(path: Path, *markers: str) -> Iterator[Path]:
    """Yield an empty temporary folder, which replaces `path` if the `with` block ends without an exception.

    An existing folder is only replaced if it is empty, or if it holds one of the files `markers` and no file that somebody
    else has put there or changed. If the system can exchange names (`lexis.files.swap`), `path` is at any time the complete
    old folder or the complete new one, even if this process is killed. A symbolic link is followed. Raises LexisError if
    `path` is any other folder or cannot be written. If the new folder was written but cannot be renamed to `path`, it is
    kept under a similar name, which the error states.
    """
    check_replaceable(path, *markers)
    target = _resolved(path)
    with _os_errors_as_lexis_errors(path, "a place with room for it, where a folder can be made"):
        target.parent.mkdir(parents=True, exist_ok=True)
        with temporary_folder(target.parent) as folder:
            new = folder / "new" / target.name
            new.mkdir()
            yield new
            write_contents(new)
            _install(path, new, target, lambda: _replace_folder(path, new, target, folder / "old" / target.name, markers))


def check_replaceable(path: Path, *markers: str) -> None:
    """Raise LexisError unless `replaced_folder` could write to `path`.

    `path` must be free, an empty folder, or a folder that `replaced_folder` has written and that holds one of the files
    `markers`. Call this before long work whose result is written to `path`. It leaves nothing behind.
    """
    try:
        target = _resolved(path)
        remove_abandoned(target.parent)
        _check_may_replace(path, target, markers)
        with suppress(FileNotFoundError):  # another process replaces the folder; it is checked again before it is replaced
            _check_own(path, target)
    except OSError as error:
        raise LexisError(f"{path}: cannot be accessed: {error.strerror}; valid: a folder that can be made") from None
    if os.path.ismount(target):
        raise LexisError(f"{path}: is a mount point, which cannot be replaced; valid: a folder inside it")
    # Permissions do not tell whether a file system can be written, so try it.
    place = next(folder for folder in target.parents if folder.exists())
    with _os_errors_as_lexis_errors(path, "a folder that can be made"), temporary_folder(place):
        pass


def check_outside(path: Path, folder: Path) -> None:
    """Raise LexisError if `path`, which is to be written, is `folder` or inside it, because `folder` is only read."""
    written, read = Path(os.path.realpath(path)), Path(os.path.realpath(folder))
    if written == read:
        raise LexisError(f"{path}: is the folder that is read; valid: another one")
    if written.is_relative_to(read):
        raise LexisError(f"{path}: is inside {folder}, which is only read; valid: a place outside of it")


def similar_name(path: Path) -> Path:
    """Return the first name that nothing has: `map-1`, `map-2` and so on for a path that ends with `map`."""
    return next(name for i in count(1) if not os.path.lexists(name := path.with_stem(f"{path.stem}-{i}")))


def _resolved(path: Path) -> Path:
    """The path with all symbolic links resolved. Raises OSError if links form a loop."""
    target = Path(os.path.realpath(path))
    with suppress(FileNotFoundError, NotADirectoryError):
        target.stat()  # raises OSError for a loop, which realpath ignores
    return target


def _check_may_replace(path: Path, target: Path, markers: tuple[str, ...]) -> None:
    """Raise LexisError unless `target` does not exist, is an empty folder, or holds a marker. `path` is for messages."""
    try:
        # One listing decides: between two system calls, another process may put its folder there.
        names = os.listdir(target)
    except FileNotFoundError:
        return
    except NotADirectoryError:
        if not os.path.lexists(target):  # a parent is a file, which is reported when writing
            return
        raise LexisError(f"{path}: is a file; valid: the name of a folder") from None
    if names and not set(markers) & set(names):
        raise LexisError(
            f"{path}: exists and holds no {' or '.join(markers)}; valid: a new name, or an earlier folder of this kind"
        )


def _check_own(path: Path, target: Path) -> None:
    """Raise LexisError if the folder `target` holds a file that is not in its list, or has changed. `path` is for messages.

    If another process replaces the folder meanwhile, nothing is known about its files: LexisError is not raised, but
    FileNotFoundError may be.
    """
    if not target.is_dir():
        return
    before, contents = target.stat(), target / CONTENTS
    lines = os.fsdecode(contents.read_bytes()).split("\n") if contents.is_file() else []
    own = {name: checksum for checksum, _, name in (line.partition(" ") for line in lines)}
    files = _files(target)
    strange, what = next((name for name in files if name not in own), None), "was not written with this folder"
    if strange is None and own:
        since_ns, what = contents.stat().st_ctime_ns, "was changed since this folder was written"
        strange = next((name for name in files if _has_changed(target / name, own[name], since_ns)), None)
    if strange is not None and os.path.samestat(before, target.stat()):
        raise LexisError(f"{path}: holds {strange}, which {what} and would be lost; valid: a new name")


def write_contents(folder: Path) -> None:
    """Write the list of the files that a folder holds now, with their checksums."""
    lines = [f"{_checksum(folder / name)} {name}\n" for name in _files(folder)]
    (folder / CONTENTS).write_bytes(os.fsencode("".join(lines)))


def _files(folder: Path) -> list[str]:
    """Return the paths of all files in a folder, relative to it, except for its list and for caches of Python."""
    paths = (path.relative_to(folder) for path in folder.rglob("*") if path.is_symlink() or not path.is_dir())
    return sorted(path.as_posix() for path in paths if path != Path(CONTENTS) and not _CACHES & set(path.parts))


def _has_changed(path: Path, checksum: str, since_ns: int) -> bool:
    """Whether a file has another checksum.

    A file whose status last changed before the time `since_ns` [ns], at which its checksum was stored, is not read: a
    recording has gigabytes. No program can set this time back, as it can the time of modification.
    """
    return path.lstat().st_ctime_ns >= since_ns and _checksum(path) != checksum


def _checksum(path: Path) -> str:
    """Return a checksum of a file, or of the target's name for a symbolic link; "" for a device or a pipe."""
    if path.is_symlink():
        return hashlib.sha256(os.fsencode(os.readlink(path))).hexdigest()[:16]
    if not path.is_file():
        return ""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:16]


@contextmanager
def _os_errors_as_lexis_errors(path: Path, valid: str) -> Iterator[None]:
    """Convert an OSError of the `with` block to a LexisError."""
    try:
        yield
    except OSError as error:
        raise LexisError(f"{path}: cannot be written: {error.strerror or error}; valid: {valid}") from None


def _install(path: Path, new: Path, target: Path, replace: Callable[[], object]) -> None:
    """Sync `new` to the disk, then replace `target` by `new`; if that fails, keep `new` under a similar name."""
    sync(new)
    try:
        with _os_errors_as_lexis_errors(path, "a name that no other process writes to, or a folder that may be changed"):
            replace()
    except LexisError as error:
        kept = similar_name(target)
        new.rename(kept)
        raise LexisError(f"{error}; the new content is kept as {kept}") from None
    finally:
        sync_folder(target.parent)


def _replace_folder(path: Path, new: Path, target: Path, old: Path, markers: tuple[str, ...]) -> None:
    """Rename the folder `new` to `target`, even if other processes replace `target` meanwhile.

    Raises LexisError if `target` is a folder that may not be replaced, and OSError.
    """
    for _ in range(_TRIES):
        try:
            new.rename(target)
            return
        except OSError as error:
            if error.errno not in _OCCUPIED:
                raise
        _check_may_replace(path, target, markers)
        try:
            _swap_checked(path, new, target, old, markers)
            return
        except OSError as error:
            if error.errno not in (errno.ENOENT, *_OCCUPIED):
                raise
    raise LexisError(f"{path}: other processes keep replacing it; valid: a name that no other process writes to")


def _swap_checked(path: Path, new: Path, target: Path, old: Path, markers: tuple[str, ...]) -> None:
    """Exchange two folders. If the old folder turns out not to be replaceable, exchange them again and raise LexisError.

    Only now is the old folder searched for files of others, because before, other processes may replace it meanwhile.
    """
    replaced = swap(new, target, old)
    try:
        _check_may_replace(path, replaced, markers)
        _check_own(path, replaced)
    except LexisError:
        swap(replaced, target, old if replaced == new else new)
        raise
