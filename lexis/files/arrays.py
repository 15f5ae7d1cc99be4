"""Reading of arrays from untrusted .npz files: all headers are checked before any array is read.

numpy's own reader is not used, because it evaluates a header as Python source and allocates whatever size the header states.
"""

import math
import os
import re
import zipfile
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Shaped

from lexis.errors import one_line
from lexis.files.reading import FileKind, open_file

Arrays = Mapping[str, Shaped[np.ndarray, "..."]]
Layout = Mapping[str, tuple[str, tuple[str | int, ...]]]
"""Types and shapes of arrays by name. A dimension is a size, or a name; dimensions of the same name have the same size."""

_MAGIC = b"\x93NUMPY\x01\x00"
_MAX_HEADER_BYTES = 4096
_HEADER = re.compile(rb"\{'descr': '([<>|][a-zA-Z]\d{1,9})', 'fortran_order': (True|False), 'shape': \(([\d, ]*)\), \}\s*")
_SIMPLE_KINDS = "biufU"
"""numpy's kinds of types that are accepted: booleans, numbers and texts, but no types that refer to Python objects."""


def read_arrays(
    path: Path, kind: FileKind, layout: Layout | None = None, sizes: Mapping[str, int] | None = None, packed: bool = False
) -> dict[str, Shaped[np.ndarray, "..."]]:
    """Read the arrays of an .npz file; types, shapes and sizes are checked first. Raises the error of `kind`.

    Args:
        path: the .npz file.
        kind: expectations on the file; its `max_bytes` also bounds the total size of all arrays.
        layout: the required arrays, which are the only ones read; None reads all arrays of the file.
        sizes: sizes of named dimensions of the layout that are known beforehand.
        packed: whether the file may be compressed; if not, the size of the file bounds the total size of all arrays.
    """
    with open_file(path, kind) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                members = _members(archive, layout)
                headers = {name: _header(archive, member) for name, member in members.items()}
                _check_sizes(headers, kind.max_bytes if packed else os.fstat(file.fileno()).st_size)
                if layout is not None:
                    _check_layout(headers, layout, {name: size for name, size in (sizes or {}).items()})
                return {name: _array(archive, members[name], header) for name, header in headers.items()}
        except _UnusableError as error:
            raise kind.refusal(path, error) from None
        except Exception as error:
            # For damaged archives, zipfile and its codecs raise many undocumented types of errors: at least RuntimeError,
            # NotImplementedError, EOFError, OSError and the error classes of zlib, lzma and struct.
            raise kind.refusal(path, f"{type(error).__name__}: {one_line(error, 100)}") from None


class _UnusableError(Exception):
    """The reason why an archive is refused."""


@dataclass(frozen=True)
class _Header:
    """The header of an array in an archive, which states the type and the shape of the array."""

    start: int
    """Offset of the array's data in its .npy file inside the archive [bytes]."""
    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    fortran: bool

    @property
    def size(self) -> int:
        return math.prod(self.shape) * self.dtype.itemsize


def _members(archive: zipfile.ZipFile, wanted: Collection[str] | None) -> dict[str, zipfile.ZipInfo]:
    """Return the members of the archive that have to be read, by the names of their arrays."""
    named = [(info.filename.removesuffix(".npy"), info) for info in archive.infolist() if info.filename.endswith(".npy")]
    members = dict(named)
    if len(members) < len(named):
        raise _UnusableError("holds two arrays of one name")
    if missing := sorted(set(wanted or ()) - members.keys()):
        raise _UnusableError(f"lacks the arrays {', '.join(missing)}")
    return members if wanted is None else {name: members[name] for name in wanted}


def _header(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> _Header:
    """Parse a header of numpy's format 1.0 by a regular expression, without evaluating the header."""
    with archive.open(member) as stream:
        start = stream.read(10)
        length = int.from_bytes(start[8:10], "little")
        if not start.startswith(_MAGIC) or length > _MAX_HEADER_BYTES:
            raise _UnusableError(f"array {member.filename!r} has no header of numpy's format 1.0")
        found = _HEADER.fullmatch(stream.read(length))
    if found is None:
        raise _UnusableError(f"array {member.filename!r} has a header with more or less than a simple type and a shape")
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
    """Raise _UnusableError unless types and shapes fit the layout, and named dimensions have the same size everywhere."""
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
