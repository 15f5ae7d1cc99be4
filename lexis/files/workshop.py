"""Hidden folders in which files and folders are made beside the place that they are for.

    .lexis-PID-RANDOM/lock        locked as long as the process lives
    .lexis-PID-RANDOM/new/NAME    what is being made; after an exchange of names, what it has replaced
    .lexis-PID-RANDOM/old/NAME    where names cannot be exchanged: what is being replaced

A process that was killed leaves its folder behind. The next one that writes to the same place removes it, and first gives
back to a name what the killed process had taken away from it.
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
def workshop(place: Path) -> Iterator[Path]:
    """A hidden folder in `place`, with an empty folder `new` in it, that is removed at the end. Raises OSError."""
    clear(place)
    folder = Path(tempfile.mkdtemp(prefix=f".lexis-{os.getpid()}-", dir=place))
    try:
        (folder / "new").mkdir()
        with (folder / "unlocked").open("w") as lock:
            # Where locks do not work, nobody else gets this one either, and leaves the folder alone.
            with suppress(OSError):
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            (folder / "unlocked").rename(folder / "lock")
            yield folder
    finally:
        _remove(folder)


def clear(place: Path) -> None:
    """Remove from `place` what killed processes have left there; what they were replacing gets its name back."""
    with suppress(OSError):
        for folder in place.iterdir():
            if _is_abandoned(folder):
                _remove(folder)


def restore(path: Path) -> None:
    """Bring back the file or folder `path` if a process was killed while it replaced it."""
    target = Path(os.path.realpath(path))
    if not os.path.lexists(target):
        clear(target.parent)


def _remove(folder: Path) -> None:
    # Where a name cannot be given back, nothing may be deleted; the next process tries again.
    with suppress(OSError):
        old = folder / "old"
        if old.is_dir():
            for kept in old.iterdir():
                if not os.path.lexists(folder.parent / kept.name):
                    kept.rename(folder.parent / kept.name)
            # Under another name, or a half-deleted one might be given back later.
            old.rename(folder / "replaced")
        shutil.rmtree(folder, ignore_errors=True)


def _is_abandoned(folder: Path) -> bool:
    """Whether a path is a workshop of this user whose process is dead."""
    name = _NAME.fullmatch(folder.name)
    if name is None or folder.is_symlink() or folder.stat().st_uid != os.getuid():
        return False
    try:
        with (folder / "lock").open("r+") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
    except FileNotFoundError:
        return not _lives(int(name[1]))
    except OSError:
        return False


def _lives(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        pass
    return True
