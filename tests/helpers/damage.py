"""Operators that damage files as failing hardware, editors and attackers do. All draws come from the generator passed in."""

import io
import json
import os
import re
import zipfile

import numpy as np

NUMBERS = (
    0,
    -1,
    1,
    0.5,
    1e-300,
    1e155,
    -1e155,
    1e308,
    float("nan"),
    float("inf"),
    float("-inf"),
    2**31,
    2**63,
    -(2**63),
    10**400,
)
OTHERS = (
    None,
    True,
    False,
    "",
    "x",
    "5",
    "nan",
    "a\nb",
    "\ud800"[:0] + "ä" * 300,
    [],
    {},
    [[]],
    [None],
    {"a": 1},
    [1, 2, 3],
)
WORDS = (
    *("0", "-1", "1e155", "-1e308", "nan", "inf", "-inf", ".inf", ".nan", "9" * 5000, "1e999", "0x10", "1_0", "2001-13-99"),
    *(
        "",
        "~",
        "null",
        "true",
        "[",
        "]",
        "{",
        "}",
        "[[1, 2], [3]]",
        "{a: b}",
        "&a [*a]",
        "*a",
        "<<",
        "|",
        "?",
        "-",
        ":",
        "#",
    ),
    *("!!binary x", "!!python/name:os.system", "'", '"', "\t", "\x00", "é", "%", "x" * 100_000, "1:2:3", "12:30:45.6"),
    *("../x.png", "/dev/zero"),
)
NESTED, DIGITS = "nested marker", "digits marker"


def damaged_bytes(rng, content):
    """Damage bytes: flip bits, truncate, or delete, duplicate, zero, move or insert a stretch."""
    data = bytearray(content)
    for _ in range(rng.integers(1, 4)):
        a, b = sorted(int(i) for i in rng.integers(0, len(data) + 1, 2))
        b = min(b, a + int(rng.choice([1, 4, 64, 4096])))
        match int(rng.integers(7)):
            case 0:
                for _ in range(rng.integers(1, 9)):
                    if data:
                        data[rng.integers(len(data))] ^= 1 << int(rng.integers(8))
            case 1:
                del data[a:]
            case 2:
                del data[a:b]
            case 3:
                data[a:a] = data[a:b]
            case 4:
                data[a:b] = bytes(b - a)
            case 5:
                data[a:a] = rng.bytes(int(rng.integers(1, 40)))
            case 6:
                piece = data[a:b]
                del data[a:b]
                at = int(rng.integers(len(data) + 1))
                data[at:at] = piece
    return bytes(data)


def damaged_json(rng, data):
    """JSON text with damage: values replaced by another type or size, swapped, deleted, duplicated, or nested deeply."""
    data = json.loads(json.dumps(data))
    for _ in range(rng.integers(1, 3)):
        places = list(_places(data))
        if places:
            _damage_place(rng, data, *places[rng.integers(len(places))], places)
    text = json.dumps(data)
    depth = int(rng.choice([5, 100, 900, 1100, 200_000]))
    opening, closing = ("[", "]") if rng.random() < 0.5 else ('{"a":', "}")
    text = text.replace(f'"{NESTED}"', opening * depth + "1" + closing * depth)
    return text.replace(f'"{DIGITS}"', "9" * 5000)


def _places(node):
    keys = list(node) if isinstance(node, dict) else range(len(node)) if isinstance(node, list) else ()
    for key in keys:
        yield node, key
        yield from _places(node[key])


def _damage_place(rng, data, parent, key, places):
    value = parent[key]
    match int(rng.integers(11)):
        case 0:
            del parent[key]
        case 1:
            if isinstance(parent, list):
                parent.insert(key, value)
            else:
                parent[f"{key}2"] = value
        case 2:
            other, at = places[rng.integers(len(places))]
            parent[key], other[at] = json.loads(json.dumps(other[at])), json.loads(json.dumps(value))
        case 3 | 4:
            parent[key] = NUMBERS[rng.integers(len(NUMBERS))]
        case 5:
            parent[key] = OTHERS[rng.integers(len(OTHERS))]
        case 6:
            parent[key] = NESTED if rng.random() < 0.7 else DIGITS
        case 7:
            parent[key] = ("x" * 100_000, [0] * 10_000, "y" * 500, [value], [value])[rng.integers(5)]
        case _:
            parent[key] = _nudged(rng, value)


def _nudged(rng, value):
    """A value near the given one (a list is permuted), so that the file parses and only its meaning is wrong."""
    if isinstance(value, bool) or not isinstance(value, int | float | list):
        return value
    if isinstance(value, list):
        return [value[i] for i in rng.permutation(len(value))]
    change = float(rng.choice([-1.0, 0.5, 0.9, 1.001, 1.5, 3.0]))
    return int(value * change) if isinstance(value, int) else value * change


def damaged_text(rng, text):
    """Text with damage: lines and words deleted, duplicated, swapped, or replaced by invalid numbers and names."""
    lines = text.split("\n")
    for _ in range(rng.integers(1, 4)):
        i, j = (int(k) for k in rng.integers(0, len(lines), 2))
        match int(rng.integers(9)):
            case 0:
                lines[i] = ""
            case 1:
                lines.insert(i, lines[j])
            case 2:
                lines[i], lines[j] = lines[j], lines[i]
            case 3:
                lines = [f"#{line}" for line in lines] if rng.random() < 0.3 else lines[: i + 1]
            case _:
                words = re.split(r"([\s,:\[\]]+)", lines[i])
                words[rng.integers(len(words))] = WORDS[rng.integers(len(WORDS))]
                lines[i] = "".join(words)
    return "\n".join(lines)


def damaged_arrays(rng, arrays):
    """Arrays with damage: one or two deleted, of another type or shape, or with invalid values."""
    arrays = dict(arrays)
    for _ in range(rng.integers(1, 3)):
        name = str(rng.choice(list(arrays)))
        array = arrays[name]
        match int(rng.integers(14)):
            case 0:
                del arrays[name]
            case 1:
                arrays[f"{name}2"] = array
            case 2:
                arrays[name] = array.astype(rng.choice(["f2", "f4", "f8", ">f8", "i4", "i8", "u1", "c16", "U3", "?"]))
            case 3:
                arrays[name] = array[:-1] if array.ndim else array.reshape(1)
            case 4:
                arrays[name] = np.concatenate([array, array[:1]]) if array.ndim else np.zeros((3, 3))
            case 5:
                arrays[name] = array.ravel() if rng.random() < 0.5 else array[None]
            case 6:
                arrays[name] = np.zeros_like(array)
            case 7:
                arrays[name] = np.asfortranarray(array.T)
            case 8:
                arrays[name] = np.array([array, None], object)
            case 9:
                arrays[name] = np.zeros((int(rng.choice([0, 1, 10_000])), *array.shape[1:]), array.dtype)
            case 10:
                other = str(rng.choice(list(arrays)))
                arrays[name], arrays[other] = arrays[other], array
            case _:
                arrays[name] = _with_extreme(rng, array)
        if not arrays:
            break
    return arrays


def _with_extreme(rng, array):
    array = array.copy()
    if array.size and array.dtype.kind in "fiu":
        values = (
            (np.nan, np.inf, 1e155, 1e308, -1.0, 0.0, 0.5) if array.dtype.kind == "f" else (0, 1, -1, 2**62, -(2**62), 1000)
        )
        picked = slice(None) if rng.random() < 0.2 else int(rng.integers(array.size))
        with np.errstate(all="ignore"):
            array.ravel()[picked] = np.array(rng.choice(values)).astype(array.dtype)
    return array


def damaged_npz(rng, arrays):
    """An .npz archive with damage in its arrays, in the headers of its members, or in its bytes."""
    way = int(rng.integers(4))
    content = packed(rng, damaged_arrays(rng, arrays) if way in (0, 1) else arrays, header=way == 2)
    return damaged_bytes(rng, content) if way == 3 else content


def packed(rng, arrays, header=False):
    """Arrays packed as an .npz archive; with `header`, the first bytes of one member are damaged before it is stored."""
    method = int(
        rng.choice([zipfile.ZIP_STORED, zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2])
    )
    struck = str(rng.choice(list(arrays))) if header and arrays else None
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", method) as archive:
        for name, array in arrays.items():
            member = io.BytesIO()
            np.save(member, array, allow_pickle=True)
            content = member.getvalue()
            if name == struck:
                content = damaged_text(rng, content[:128].decode("latin1")).encode("latin1", "ignore") + content[128:]
                content = damaged_bytes(rng, content[:128]) + content[128:] if rng.random() < 0.5 else content
            archive.writestr(f"{name}.npy", content)
    return buffer.getvalue()


def bomb(arrays, name, shape):
    """An .npz archive in which one array unpacks to about a hundred times the size of the file."""
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **(dict(arrays) | {name: np.zeros(shape, arrays[name].dtype)}))
    return buffer.getvalue()


def displaced(rng, path):
    """Replace a file by something else: nothing, a folder, a pipe, a device, a link loop, an empty or an endless file."""
    path.unlink()
    match int(rng.integers(7)):
        case 0:
            path.mkdir()
        case 1:
            os.mkfifo(path)
        case 2:
            path.symlink_to("/dev/zero")
        case 3:
            path.symlink_to(path.name)
        case 4:
            path.write_bytes(b"")
        case 5:
            with path.open("wb") as file:
                file.truncate(20_000_000_000)


def damaged_file(rng, path):
    """Damage a file according to its type, or in a way that is possible for any file."""
    if rng.random() < 0.08:
        displaced(rng, path)
        return
    content = path.read_bytes()
    if path.suffix == ".json" and rng.random() < 0.8:
        path.write_text(damaged_json(rng, json.loads(content)))
    elif path.suffix in (".txt", ".tum", ".csv", ".yaml") and rng.random() < 0.8:
        path.write_text(damaged_text(rng, content.decode()), encoding="utf-8")
    else:
        path.write_bytes(damaged_bytes(rng, content))
