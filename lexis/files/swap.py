"""Operations for atomic replacement: exchange of two names in one step if the system can, and syncing to the disk."""

import ctypes
import errno
import os
import shutil
import sys
from contextlib import suppress
from pathlib import Path

_AT_FDCWD, _RENAME_EXCHANGE = -100, 2
"""Linux constants, which are the same on all architectures."""
_UNSUPPORTED = (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP, errno.EPERM, errno.EXDEV)
"""Error numbers of a kernel, a file system or a sandbox that does not support the exchange of names."""


def swap(new: Path, target: Path, old: Path) -> Path:
    """Exchange the folders `new` and `target`; return the path at which the earlier `target` is now.

    This path is `new` if the system can exchange names in one step. Otherwise it is `old`: the earlier folder is moved there
    first, and for a moment there is no `target`. Raises OSError, and FileNotFoundError if there is no `target`.
    """
    if exchange(new, target):
        return new
    shutil.rmtree(old, ignore_errors=True)
    old.parent.mkdir(exist_ok=True)
    move_folder(target, old)
    new.rename(target)
    return old


def move_folder(folder: Path, to: Path) -> None:
    """Rename a folder, or copy and delete it if renaming fails, as in a lower layer of an overlay file system."""
    try:
        folder.rename(to)
    except OSError as error:
        if error.errno != errno.EXDEV:
            raise
        shutil.copytree(folder, to, symlinks=True)
        shutil.rmtree(folder)


def exchange(a: Path, b: Path) -> bool:
    """Exchange the names of two files or folders in one step.

    Returns False if the system does not support this. Raises OSError if the exchange fails for another reason.
    """
    rename = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None) if sys.platform == "linux" else None
    if rename is None:
        return False
    if rename(_AT_FDCWD, os.fsencode(a), _AT_FDCWD, os.fsencode(b), ctypes.c_uint(_RENAME_EXCHANGE)) == 0:
        return True
    number = ctypes.get_errno()
    if number in _UNSUPPORTED:
        return False
    raise OSError(number, os.strerror(number), str(b))


def sync(path: Path) -> None:
    """Wait until a file, or a folder with all its contents, is on the disk. Raises OSError."""
    if path.is_dir():
        for inside in path.rglob("*"):
            if inside.is_dir():
                sync_folder(inside)
            elif inside.is_file():
                _sync_file(inside)
        sync_folder(path)
    else:
        _sync_file(path)


def sync_folder(path: Path) -> None:
    """Wait until the names in a folder are on the disk, if the file system supports that."""
    with suppress(OSError):
        _sync_file(path)


def _sync_file(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
