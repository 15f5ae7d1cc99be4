"""Reading text files that users name: only regular files of limited size are read."""

import os
import stat
from pathlib import Path

from worlds.errors import SpecError
from worlds.spec_errors import MAX_JSON_BYTES


def read_text(path: Path) -> str:
    """Return the text of a UTF-8 file of at most 16 MB.

    Pipes and devices are refused, because reading them may never end. Raises `SpecError` for a file that cannot be read; the
    message does not name the file, so that callers can put the name in front.
    """
    try:
        status = os.stat(path)
        if not stat.S_ISREG(status.st_mode):
            raise SpecError(f"cannot be read: is {'a folder' if stat.S_ISDIR(status.st_mode) else 'a device or a pipe'}")
        if status.st_size > MAX_JSON_BYTES:
            raise SpecError(f"larger than {MAX_JSON_BYTES // 1_000_000} MB")
        with path.open("rb") as file:
            content = file.read(MAX_JSON_BYTES + 1)
        if len(content) > MAX_JSON_BYTES:
            raise SpecError(f"larger than {MAX_JSON_BYTES // 1_000_000} MB")
        return content.decode("utf-8-sig")
    except OSError as error:
        raise SpecError(f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise SpecError("is not text in UTF-8") from None
    except SpecError:
        raise
    except ValueError:  # a null byte, or half of a surrogate pair
        raise SpecError("cannot be read: not a valid file name") from None
