"""Embeddings of images kept on disk, so that to encode a dataset again costs next to nothing.

One SQLite file for each encoder: safe with several processes, and an entry is there whole or not at all.
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
"""Of one encoder; the oldest make room."""
_WAIT_S = 30.0
"""For another process that is writing."""


class ImageCache:
    """What one encoder made of images, by their content."""

    def __init__(self, folder: Path, encoder: str, most: int = MOST_IMAGES) -> None:
        """Open or make the cache in `folder` of the encoder that this digest names. Raises EncoderError where that fails."""
        self._path = folder / f"{encoder}.sqlite"
        self._most = most
        with self._reported():
            folder.mkdir(parents=True, exist_ok=True)
            self._connection = sqlite3.connect(self._path, timeout=_WAIT_S, check_same_thread=False)
            self._connection.execute("PRAGMA journal_mode = WAL")
            self._connection.execute("PRAGMA synchronous = NORMAL")  # a power cut loses the last entries at most
            self._connection.execute(
                "CREATE TABLE IF NOT EXISTS images (age INTEGER PRIMARY KEY, key BLOB UNIQUE, row BLOB)"
            )

    def find(self, keys: Sequence[bytes]) -> dict[bytes, Float32[np.ndarray, "d"]]:
        """The embeddings of those that are known; a damaged entry counts as unknown."""
        with self._reported():
            query = "SELECT row FROM images WHERE key = ?"
            rows = {key: _row(self._connection.execute(query, (key,)).fetchone()) for key in keys}
        return {key: row for key, row in rows.items() if row is not None}

    def add(self, rows: Mapping[bytes, Float32[np.ndarray, "d"]]) -> None:
        """Keep embeddings of unit norm."""
        entries = [(key, row.astype("<f4").tobytes()) for key, row in rows.items()]
        with self._reported(), self._connection:
            self._connection.executemany("INSERT OR REPLACE INTO images (key, row) VALUES (?, ?)", entries)
            self._connection.execute("DELETE FROM images WHERE age <= (SELECT max(age) FROM images) - ?", (self._most,))

    @contextmanager
    def _reported(self) -> Iterator[None]:
        try:
            yield
        except (sqlite3.Error, OSError) as error:
            told = "another folder, or to delete this file"
            raise EncoderError(f"{self._path}: unusable cache: {error}; valid: {told}") from None


def image_key(image: Image) -> bytes:
    """Of the content: equal for equal images only."""
    digest = hashlib.sha256(repr(image.shape).encode())
    digest.update(np.ascontiguousarray(image).data)
    return digest.digest()


def _row(found: tuple[object] | None) -> Float32[np.ndarray, "d"] | None:
    """The embedding that was found, if any and if it is one of unit norm."""
    if found is None or not isinstance(stored := found[0], bytes) or len(stored) % 4:
        return None
    row = np.frombuffer(stored, "<f4").astype(np.float32)
    return row if abs(float(np.linalg.norm(row)) - 1.0) < 1e-5 else None
