"""A cache on disk for embeddings of images, so that encoding a dataset again takes almost no time.

Each encoder has its own SQLite file, because SQLite allows access by several processes and never stores partial entries.
"""

import hashlib
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from jaxtyping import Float32

from lexis.errors import EncoderError
from lexis.types import Image

MOST_IMAGES = 1_000_000
"""Largest number of images cached per encoder; the oldest entries are deleted first."""
_WAIT_S = 30.0
"""Longest wait for another process that is writing [s]."""


class ImageCache:
    """A cache of one encoder's embeddings, with hashes of the images as keys."""

    def __init__(self, folder: Path, encoder: str, most: int = MOST_IMAGES) -> None:
        """Open or create the cache of one encoder in `folder`. Raises EncoderError if that fails.

        `encoder` is a text that identifies the encoder, and `most` is the largest number of entries.
        """
        self._path = folder / f"{encoder}.sqlite"
        self._most = most
        with self._reported():
            folder.mkdir(parents=True, exist_ok=True)
            self._connection = sqlite3.connect(self._path, timeout=_WAIT_S, check_same_thread=False)
            self._connection.execute("PRAGMA journal_mode = WAL")
            self._connection.execute("PRAGMA synchronous = NORMAL")  # fast; a power cut loses at most the last entries
            self._connection.execute(
                "CREATE TABLE IF NOT EXISTS images (age INTEGER PRIMARY KEY, key BLOB UNIQUE, row BLOB)"
            )

    def find(self, keys: Sequence[bytes]) -> dict[bytes, Float32[np.ndarray, "d"]]:
        """The cached embeddings by key. Keys that are not in the cache, or have a damaged entry, are left out."""
        with self._reported():
            query = "SELECT row FROM images WHERE key = ?"
            rows = {key: _row(self._connection.execute(query, (key,)).fetchone()) for key in keys}
        return {key: row for key, row in rows.items() if row is not None}

    def add(self, rows: Mapping[bytes, Float32[np.ndarray, "d"]]) -> None:
        """Store embeddings of unit norm by their keys, and delete the oldest entries if there are too many."""
        entries = [(key, row.astype("<f4").tobytes()) for key, row in rows.items()]
        with self._reported(), self._connection:
            self._connection.executemany("INSERT OR REPLACE INTO images (key, row) VALUES (?, ?)", entries)
            self._connection.execute("DELETE FROM images WHERE age <= (SELECT max(age) FROM images) - ?", (self._most,))

    @contextmanager
    def _reported(self) -> Iterator[None]:
        try:
            yield
        except (sqlite3.Error, OSError) as error:
            valid = "another folder, or the same after deleting this file"
            raise EncoderError(f"{self._path}: unusable cache: {error}; valid: {valid}") from None


def image_key(image: Image) -> bytes:
    """Hash of an image's shape and pixels."""
    digest = hashlib.sha256(repr(image.shape).encode())
    digest.update(np.ascontiguousarray(image).data)
    return digest.digest()


def _row(found: tuple[object] | None) -> Float32[np.ndarray, "d"] | None:
    """The embedding in a row of the database; None if there is no row, or if it does not hold a vector of unit norm."""
    if found is None or not isinstance(stored := found[0], bytes) or len(stored) % 4:
        return None
    row = np.frombuffer(stored, "<f4").astype(np.float32)
    return row if abs(float(np.linalg.norm(row)) - 1.0) < 1e-5 else None
