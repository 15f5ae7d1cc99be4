"""The image cache on disk returns what was stored or nothing, and never the embeddings of another encoder."""

import sqlite3
import subprocess
import sys

import numpy as np
import pytest

from lexis.encoder.image_cache import ImageCache, image_key
from lexis.errors import EncoderError

ENCODER = "ab" * 32


def row(seed, size=8):
    values = np.random.default_rng(seed).normal(size=size).astype(np.float32)
    return values / np.linalg.norm(values)


@pytest.fixture
def cache(tmp_path):
    return ImageCache(tmp_path, ENCODER)


def test_what_was_added_is_found_again_by_another_process_and_by_no_other_encoder(cache, tmp_path):
    cache.add({b"a": row(1), b"b": row(2)})
    again = ImageCache(tmp_path, ENCODER).find([b"b", b"a", b"c", b"a"])
    assert list(again) == [b"b", b"a"]
    np.testing.assert_array_equal(again[b"a"], row(1))
    assert not ImageCache(tmp_path, "cd" * 32).find([b"a"])
    code = (
        "import sys; from pathlib import Path; from lexis.encoder.image_cache import ImageCache;"
        "print(len(ImageCache(Path(sys.argv[1]), sys.argv[2]).find([b'a', b'b'])))"
    )
    told = subprocess.run([sys.executable, "-c", code, str(tmp_path), ENCODER], capture_output=True, text=True, check=True)
    assert told.stdout.strip() == "2"


def test_keys_are_those_of_shape_and_content():
    image = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    other = image.copy()
    other[0, 0, 0] += 1
    assert image_key(image) == image_key(np.asfortranarray(image)) == image_key(np.flip(np.flip(image, 0), 0))
    assert len({image_key(image), image_key(other), image_key(image.reshape(2, 8, 3)), image_key(image[::-1])}) == 4


def test_a_damaged_entry_is_unknown_and_can_be_replaced(cache, tmp_path):
    cache.add({key: row(3) for key in (b"short", b"zero", b"text", b"long", b"whole")})
    bad = {b"short": b"123", b"zero": bytes(32), b"text": "none", b"long": row(3).tobytes() + row(4).tobytes()}
    (path,) = tmp_path.glob("*.sqlite")
    with sqlite3.connect(path) as connection:
        connection.executemany("UPDATE images SET row = ? WHERE key = ?", [(value, key) for key, value in bad.items()])
    assert list(cache.find([*bad, b"whole"])) == [b"whole"]
    cache.add({b"short": row(5)})
    np.testing.assert_array_equal(cache.find([b"short"])[b"short"], row(5))


def test_the_oldest_entries_are_evicted(tmp_path):
    cache = ImageCache(tmp_path, ENCODER, most=3)
    for i in range(5):
        cache.add({bytes([i]): row(i)})
    assert list(cache.find([bytes([i]) for i in range(5)])) == [b"\2", b"\3", b"\4"]


@pytest.mark.parametrize("damage", ["other file", "cut", "folder is a file"])
def test_a_damaged_cache_is_named_in_one_line(cache, tmp_path, damage):
    cache.add({bytes([i]): row(i, 2000) for i in range(50)})
    (path,) = tmp_path.glob("*.sqlite")
    with sqlite3.connect(path) as connection:
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    folder = tmp_path / "other"
    if damage == "folder is a file":
        folder.touch()
    else:
        folder.mkdir()
        (folder / path.name).write_bytes(b"embeddings" * 1000 if damage == "other file" else path.read_bytes()[:9000])
    with pytest.raises(EncoderError, match=r"unusable cache.*valid:") as error:
        ImageCache(folder, ENCODER).find([bytes([i]) for i in range(50)])
    assert "\n" not in str(error.value)
