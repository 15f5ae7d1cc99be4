"""Hidden temporary folders, in which files and folders are written before they are renamed to their target.

    .lexis-PID-RANDOM/lock        file that is locked as long as the process lives
    .lexis-PID-RANDOM/new/NAME    the new content while it is written; after an exchange of names, the old content
    .lexis-PID-RANDOM/old/NAME    the old content, only if the system cannot exchange names

A killed process leaves its temporary folder behind. The next process that writes to the same place removes it. If the killed
process had moved the old content away from its target, the old content is moved back first.
"""

import fcntl
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_NAME = re.compile(r"\.lexis-(\d+)-\w+")


@contextmanager
def temporary_folder(place: Path) -> Iterator[Path]:
    """Yield a hidden folder in `place`, with an empty folder `new` in it.

    The hidden folder is removed when the `with` block ends. Raises OSError.
    """
    remove_abandoned(place)
    folder = Path(tempfile.mkdtemp(prefix=f".lexis-{os.getpid()}-", dir=place))
    try:
        (folder / "new").mkdir()
        with (folder / "unlocked").open("wb") as lock:
            # If locking does not work here, other processes cannot lock the file either and leave the folder alone.
            with suppress(OSError):
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            # The file is renamed only now, so that no other process sees a file `lock` before it is locked.
            (folder / "unlocked").rename(folder / "lock")
            yield folder
    finally:
        _remove(folder)


def is_temporary(path: Path) -> bool:
    """Return whether a path leads through a temporary folder, whose content is incomplete or about to be removed."""
    return any(_NAME.fullmatch(part) for part in path.parts)


def remove_abandoned(place: Path) -> None:
    """Remove the temporary folders that killed processes left in `place`.

    If the system cannot exchange names, a process that replaces a folder first moves the old content into its temporary
    folder. If the process was killed before the new content was in place, the old content is moved back.
    """
    with suppress(OSError):
        for folder in place.iterdir():
            if _is_abandoned(folder):
                _remove(folder)


def recover(path: Path) -> None:
    """Move the old content back to `path` if a process was killed while it replaced `path`."""
    target = Path(os.path.realpath(path))
    if not os.path.lexists(target):
        remove_abandoned(target.parent)


def _remove(folder: Path) -> None:
    # If old content cannot be moved back, nothing may be deleted; the next process tries again.
    with suppress(OSError):
        old = folder / "old"
        if old.is_dir():
            for kept in old.iterdir():
                if not os.path.lexists(folder.parent / kept.name):
                    kept.rename(folder.parent / kept.name)
            # The folder is renamed before deletion; otherwise, a half-deleted folder might be moved back later.
            old.rename(folder / "replaced")
        shutil.rmtree(folder, ignore_errors=True)


def _is_abandoned(folder: Path) -> bool:
    """Whether a path is a temporary folder of this user whose process no longer runs."""
    name = _NAME.fullmatch(folder.name)
    if name is None or folder.is_symlink() or folder.stat().st_uid != os.getuid():
        return False
    try:
        with (folder / "lock").open("r+") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
    except FileNotFoundError:
        return not _is_running(int(name[1]))
    except OSError:
        return False


def _is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        pass
    return True
