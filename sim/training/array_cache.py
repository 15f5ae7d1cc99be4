"""A file cache for arrays that take minutes to make.

Each file contains fingerprints (origins) of the inputs from which its arrays were made. A file whose origins do not match is
rejected, so that arrays of earlier code or settings are never used by mistake.
"""

import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lexis.files.arrays import read_arrays
from lexis.files.reading import FileKind
from lexis.files.replace import replaced_file
from sim.errors import SimError
from sim.training.houses import HouseDraw
from worlds.house import build_house

Arrays = Mapping[str, np.ndarray]
_ORIGINS = "origins"
_FILE = FileKind("a file of an earlier run; delete it to have it made again", 10**12, SimError, unusable="cannot be read")


def cached_arrays(path: Path, origins: tuple[str, ...], make: Callable[[], Arrays]) -> Arrays:
    """Load the arrays of a file. If there is no such file, call `make` and write the file first.

    `origins` are the fingerprints of the inputs. Raises `SimError` as `loaded` does.
    """
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        arrays: dict[str, Any] = {**make(), _ORIGINS: np.array(origins)}
        with replaced_file(path) as beside, beside.open("wb") as file:
            np.savez(file, **arrays)
    return loaded(path, origins)


def loaded(path: Path, origins: tuple[str, ...]) -> Arrays:
    """Load the arrays of a file. The list of fingerprints (origins) in the file has to start with `origins`.

    Raises `SimError` if the file cannot be read or has other origins.
    """
    arrays = read_arrays(path, _FILE)
    if tuple(arrays.pop(_ORIGINS, ()))[: len(origins)] != origins:
        raise SimError(
            f"{path}: made from other houses or settings than the present ones; delete its folder to make it again"
        )
    return arrays


def origin(*sources: object) -> str:
    """Return a SHA-256 fingerprint of the values from which arrays are made, computed from the `repr` of the values."""
    return hashlib.sha256(repr(sources).encode()).hexdigest()


def house_origin(draw: HouseDraw) -> str:
    """Return a fingerprint of a house as the present code builds it: specification, walls, stairs, objects and looks."""
    spec = draw.spec()
    house = build_house(spec)
    things = (*house.furniture, *house.leaves, *house.windows)
    return origin(spec.to_json(), house.walls, house.stairs, things, [thing.parts for thing in things])
