"""Arrays from .npz files: arrays written by numpy are read exactly, and files with false sizes are refused cheaply."""

import io
import tracemalloc
import zipfile

import numpy as np
import pytest

from lexis.errors import MapError
from lexis.files.arrays import read_arrays
from lexis.files.reading import FileKind

KIND = FileKind("arrays", 10_000_000, MapError, unusable="no arrays")
LAYOUT = {"a": ("f8", ("n", 3)), "b": ("i8", ("n",)), "c": ("f4", ())}


def arrays(rng):
    return {"a": rng.normal(size=(5, 3)), "b": np.arange(5), "c": np.array(2.5, np.float32)}


def member(array):
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def archive(path, members, method=zipfile.ZIP_STORED):
    with zipfile.ZipFile(path, "w", method) as file:
        for name, content in members.items():
            file.writestr(f"{name}.npy", content)


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_reading_gives_back_what_numpy_has_written(save, rng, tmp_path):
    written = arrays(rng) | {
        "more": np.array(["text", "x"]),
        "empty": np.zeros((0, 5)),
        "turned": np.asfortranarray(np.eye(3, 4)),
    }
    save(tmp_path / "a.npz", **written)
    read = read_arrays(tmp_path / "a.npz", KIND, packed=True)
    assert set(read) == set(written)
    for name, array in written.items():
        assert read[name].dtype == array.dtype and read[name].flags.writeable
        np.testing.assert_array_equal(read[name], array)
    assert set(read_arrays(tmp_path / "a.npz", KIND, LAYOUT, {"n": 5}, packed=True)) == set(LAYOUT)


def header(text):
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("a", member(np.zeros((4, 3))), "array b has shape"),
        ("a", member(np.zeros((5, 3), np.float32)), r"array a is float32 \(5, 3\); valid: float64"),
        ("a", member(np.zeros((5, 3)))[:-1], "'a.npy' has .* bytes"),
        ("a", b"", "no header"),
        ("a", header(b"{'descr': '|O', 'fortran_order': False, 'shape': (5, 3), }\n"), "more or less than a simple type"),
        ("a", header(b"{'descr': '<f8', 'fortran_order': False, 'shape': (10000000000, 3), }\n"), "has .* bytes"),
        ("a", header(b"{'descr': '<f8', 'fortran_order': False, 'shape': (5, 3" + b")" * 900), "more or less"),
        ("a", header(b"__import__('os').abort()"), "more or less"),
        ("a", header(b"'''"), "more or less"),
        ("a", header(b"{'descr': '<M8', 'fortran_order': False, 'shape': (5, 3), }\n"), "more or less|type"),
    ],
)
def test_members_that_are_not_the_arrays_of_the_layout_are_refused(name, content, says, rng, tmp_path):
    members = {key: member(array) for key, array in arrays(rng).items()} | {name: content}
    archive(tmp_path / "a.npz", members)
    with pytest.raises(MapError, match=f"no arrays: .*{says}") as error:
        read_arrays(tmp_path / "a.npz", KIND, LAYOUT)
    assert "\n" not in str(error.value)


def test_two_arrays_of_one_name_are_refused(tmp_path):
    with pytest.warns(UserWarning, match="Duplicate"), zipfile.ZipFile(tmp_path / "a.npz", "w") as file:
        for _ in range(2):
            file.writestr("a.npy", member(np.zeros(3)))
    with pytest.raises(MapError, match="two arrays of one name"):
        read_arrays(tmp_path / "a.npz", KIND)


@pytest.mark.parametrize("packed", [True, False])
def test_a_bomb_costs_nothing(packed, tmp_path):
    """200 MB of zeros compressed to 200 kB are refused by the size that the archive states, before they are unpacked."""
    archive(
        tmp_path / "a.npz", {"a": member(np.zeros((25_000_000, 1), np.uint8)) + bytes(175_000_000)}, zipfile.ZIP_DEFLATED
    )
    archive(tmp_path / "b.npz", {"a": member(np.zeros(25_000_000, np.uint8))}, zipfile.ZIP_DEFLATED)
    tracemalloc.start()
    try:
        for name in ("a.npz", "b.npz"):
            with pytest.raises(MapError, match=r"unpacks to 25000000 bytes|'a.npy' has"):
                read_arrays(tmp_path / name, KIND, packed=packed)
        assert tracemalloc.get_traced_memory()[1] < 1_000_000
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("damage", ["method", "encrypted", "lzma", "deflated", "stored", "cut", "local header"])
def test_damaged_archives_are_refused_whatever_zipfile_raises(damage, rng, tmp_path):
    path = tmp_path / "a.npz"
    method = {"lzma": zipfile.ZIP_LZMA, "deflated": zipfile.ZIP_DEFLATED}.get(damage, zipfile.ZIP_STORED)
    archive(path, {"a": member(rng.normal(size=(50, 3)))}, method)
    content = bytearray(path.read_bytes())
    central = content.index(b"PK\x01\x02")
    match damage:
        case "method":
            content[central + 10] = 77
        case "encrypted":
            content[central + 8] |= 1
            content[6] |= 1
        case "cut":
            del content[central - 100 : central]
        case "local header":
            content[30] ^= 0xFF
        case _:
            content[200:210] = bytes(10)
    path.write_bytes(content)
    with pytest.raises(MapError, match="no arrays: "):
        read_arrays(path, KIND, packed=True)
