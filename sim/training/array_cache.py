"""Arrays that take minutes to make, kept in files that say what they were made from; files of another origin are refused."""

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
    """The arrays in a file, made and written first where there is none. Raises as `loaded` does."""
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        arrays: dict[str, Any] = {**make(), _ORIGINS: np.array(origins)}
        with replaced_file(path) as beside, beside.open("wb") as file:
            np.savez(file, **arrays)
    return loaded(path, origins)


def loaded(path: Path, origins: tuple[str, ...]) -> Arrays:
    """The arrays in a file whose origins begin with these.

    Raises `SimError` for a file that cannot be read, and for arrays that were made from anything else.
    """
    arrays = read_arrays(path, _FILE)
    if tuple(arrays.pop(_ORIGINS, ()))[: len(origins)] != origins:
        raise SimError(f"{path}: made of other houses or in another way than today; delete its folder to have it made again")
    return arrays


def origin(*sources: object) -> str:
    """A digest of what arrays are made from, by its `repr`."""
    return hashlib.sha256(repr(sources).encode()).hexdigest()


def house_origin(draw: HouseDraw) -> str:
    """A digest of a house as it is drawn and built today: its shell, what stands there, and what that looks like."""
    spec = draw.spec()
    house = build_house(spec)
    things = (*house.furniture, *house.leaves, *house.windows)
    return origin(spec.to_json(), house.walls, house.stairs, things, [thing.parts for thing in things])
