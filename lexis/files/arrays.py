"""Arrays from .npz files that are not trusted: their headers are read first, and only then what they promise.

numpy's own reader evaluates a header as Python source, and reads as much as the header says.
"""

import math
import os
import re
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Shaped

from lexis.errors import one_line
from lexis.files.reading import FileKind, open_file

Arrays = Mapping[str, Shaped[np.ndarray, "..."]]
Layout = Mapping[str, tuple[str, tuple[str | int, ...]]]
"""Type and shape of arrays by name. The names of dimensions stand for one size each."""

_MAGIC = b"\x93NUMPY\x01\x00"
_MAX_HEADER_BYTES = 4096
_HEADER = re.compile(rb"\{'descr': '([<>|][a-zA-Z]\d{1,9})', 'fortran_order': (True|False), 'shape': \(([\d, ]*)\), \}\s*")
_SIMPLE_KINDS = "biufU"
"""Truth values, numbers and texts; of numpy's types none that refers to Python objects."""


def read_arrays(
    path: Path, kind: FileKind, layout: Layout | None = None, sizes: Mapping[str, int] | None = None, packed: bool = False
) -> dict[str, Shaped[np.ndarray, "..."]]:
    """The arrays of an .npz file. Types, shapes and sizes are checked before any array is read. Raises the kind's error.

    Args:
        path: of the file.
        kind: its `max_bytes` bounds what all arrays need together, too.
        layout: the arrays that there must be, and no others matter; None takes all.
        sizes: of dimensions in the layout that are known beforehand.
        packed: whether the file may be compressed; if not, the arrays cannot need more memory than the file has bytes.
    """
    with open_file(path, kind) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                members = _members(archive, None if layout is None else set(layout))
                headers = {name: _header(archive, member) for name, member in members.items()}
                _check_sizes(headers, kind.max_bytes if packed else os.fstat(file.fileno()).st_size)
                if layout is not None:
                    _check_layout(headers, layout, {name: size for name, size in (sizes or {}).items()})
                return {name: _array(archive, members[name], header) for name, header in headers.items()}
        except _UnusableError as error:
            raise kind.refusal(path, error) from None
        except Exception as error:
            # A damaged archive makes zipfile, its codecs and the C library raise what none of them documents: at the last
            # count RuntimeError, NotImplementedError, EOFError, OSError and the error classes of zlib, lzma and struct.
            raise kind.refusal(path, f"{type(error).__name__}: {one_line(error, 100)}") from None


class _UnusableError(Exception):
    """The reason why an archive is refused."""


@dataclass(frozen=True)
class _Header:
    """The header of an array in an archive: its type and its shape."""

    start: int
    """Where the numbers begin [bytes]."""
    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    fortran: bool

    @property
    def size(self) -> int:
        return math.prod(self.shape) * self.dtype.itemsize


def _members(archive: zipfile.ZipFile, wanted: set[str] | None) -> dict[str, zipfile.ZipInfo]:
    """The members to read, by the name of their array."""
    named = [(info.filename.removesuffix(".npy"), info) for info in archive.infolist() if info.filename.endswith(".npy")]
    members = dict(named)
    if len(members) < len(named):
        raise _UnusableError("holds two arrays of one name")
    if missing := sorted((wanted or set()) - members.keys()):
        raise _UnusableError(f"lacks the arrays {', '.join(missing)}")
    return members if wanted is None else {name: members[name] for name in wanted}


def _header(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> _Header:
    """The header in version 1.0 of the format, as numpy writes it; nothing of it is evaluated."""
    with archive.open(member) as stream:
        start = stream.read(10)
        length = int.from_bytes(start[8:10], "little")
        if not start.startswith(_MAGIC) or length > _MAX_HEADER_BYTES:
            raise _UnusableError(f"array {member.filename!r} has no header of numpy's format 1.0")
        found = _HEADER.fullmatch(stream.read(length))
    if found is None:
        raise _UnusableError(f"array {member.filename!r} has a header that says more or less than a simple type and a shape")
    dtype = np.dtype(found[1].decode())
    if dtype.kind not in _SIMPLE_KINDS:
        raise _UnusableError(f"array {member.filename!r} is of type {dtype}; valid: numbers")
    shape = tuple(int(size) for size in found[3].decode().split(",") if size.strip())
    header = _Header(10 + length, dtype, shape, found[2] == b"True")
    if member.file_size != header.start + header.size:
        raise _UnusableError(f"array {member.filename!r} has {member.file_size} bytes; valid: those of {dtype} {shape}")
    return header


def _check_sizes(headers: Mapping[str, _Header], limit: int) -> None:
    total = sum(header.size for header in headers.values())
    if total > limit:
        raise _UnusableError(f"unpacks to {total} bytes; valid: up to {limit}")


def _check_layout(headers: Mapping[str, _Header], layout: Layout, sizes: dict[str | int, int]) -> None:
    """Raise _UnusableError unless types and shapes are those of the layout, and sizes agree."""
    for name, (kind, shape) in layout.items():
        found = headers[name]
        expected = tuple(size if isinstance(size, int) else sizes.get(size, size) for size in shape)
        if found.dtype != np.dtype(kind) or len(found.shape) != len(shape):
            raise _UnusableError(f"array {name} is {found.dtype} {found.shape}; valid: {np.dtype(kind)} {expected}")
        for dimension, size in zip(shape, found.shape, strict=True):
            wanted = dimension if isinstance(dimension, int) else sizes.setdefault(dimension, size)
            if size != wanted:
                raise _UnusableError(f"array {name} has shape {found.shape}; valid: {expected}")


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo, header: _Header) -> Shaped[np.ndarray, "..."]:
    with archive.open(member) as stream:
        stream.read(header.start)
        content = bytearray(stream.read(header.size))
        if len(content) != header.size or stream.read(1):
            raise _UnusableError(f"array {member.filename!r} is cut short")
    return np.frombuffer(content, header.dtype).reshape(header.shape, order="F" if header.fortran else "C")
