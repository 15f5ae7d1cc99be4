"""`lexis-sim house prove`: generates many houses of all families (presets) and checks each of them.

Each house is validated, and generated again in another process. Both results have to be equal bit by bit, because a seed
has to give the same house in every run. Rooms without an essential piece, such as kitchens without a sink, are counted.
"""

import hashlib
import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import repeat

import numpy as np

from sim.processes import process_pool
from worlds.checks.essentials import missing_essentials
from worlds.errors import WorldsError
from worlds.furniture.placing.counts import USUAL
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.truth_json import truth_json
from worlds.validation import validate

_CHUNK = 20
_OPENNESS, _CLUTTER = (None, 0.0, 0.25, 0.5, 0.75, 1.0), (1.0, 1.0, 0.0, 2.0, 4.0)
"""Values of openness and clutter through which the houses cycle. The numbers of values (6 and 5) have no common divisor, so
every pair of values occurs."""


@dataclass(frozen=True)
class Case:
    """A house to be checked, given by the arguments from which it is generated."""

    preset: str
    seed: int
    openness: float | None
    clutter: float

    def __str__(self) -> str:
        openness = "" if self.openness is None else f" --openness {self.openness:g}"
        return f"--preset {self.preset} --seed {self.seed}{openness} --clutter {self.clutter:g}"


@dataclass(frozen=True)
class Proof:
    """The result of checking one generated house."""

    case: Case
    seconds: float
    """Processor time of generating and validating the house once [s]."""
    failure: str | None
    """Why the house is invalid or differs when generated again; None if it passed."""
    rooms: int
    """Number of rooms, if the house has at least the usual amount of furniture; otherwise 0."""
    lacking: int
    """Number of these rooms that lack an essential piece."""


@dataclass(frozen=True)
class _Made:
    seconds: float
    digest: str
    failure: str | None
    rooms: int = 0
    lacking: int = 0


def cases(presets: Sequence[str], seed: int, count: int) -> list[Case]:
    """List `count` houses with consecutive seeds, the first of which is `seed`. The houses cycle through the presets.

    Every other round through the presets also varies openness and clutter.
    """
    rounds = ((i, i // len(presets)) for i in range(count))
    return [
        Case(
            presets[i % len(presets)],
            seed + i,
            _OPENNESS[k // 2 % len(_OPENNESS)] if k % 2 else None,
            _CLUTTER[k // 2 % len(_CLUTTER)] if k % 2 else 1.0,
        )
        for i, k in rounds
    ]


def prove(wanted: Sequence[Case], processes: int) -> Iterator[Proof]:
    """Check houses in several processes, and yield the results in the order of `wanted`.

    At least two processes are used, even for `processes` below 2, because each house is generated in two of them.
    """
    workers = max(1, processes // 2)
    # New processes start as another run would: with another hash seed and with empty caches.
    with process_pool(workers) as first, process_pool(workers) as second:
        once = first.map(_make, wanted, repeat(True), chunksize=_CHUNK)
        again = second.map(_make, wanted, repeat(False), chunksize=_CHUNK)
        for case, one, other in zip(wanted, once, again, strict=True):
            differs = "is another house when generated again" if one.digest != other.digest else None
            yield Proof(case, one.seconds, one.failure or differs, one.rooms, one.lacking)


def _make(case: Case, validated: bool) -> _Made:
    start = time.process_time()
    try:
        spec = sample_house(case.preset, case.seed, openness=case.openness, clutter=case.clutter)
        house = build_house(spec)
        truth = truth_json(house)
        if validated:
            validate(house)
    except WorldsError as error:
        return _Made(time.process_time() - start, "", str(error))
    seconds = time.process_time() - start
    digest = hashlib.sha256((spec.to_json() + json.dumps(truth)).encode()).hexdigest()
    if not validated or case.clutter < USUAL:
        return _Made(seconds, digest, None)
    return _Made(seconds, digest, None, len(house.rooms), len({room for room, _ in missing_essentials(house)}))


@dataclass(frozen=True)
class Summary:
    """Counts and generation times of the houses of one family (preset), or of all families."""

    preset: str
    houses: int
    failed: int
    rooms: int
    lacking: int
    median_ms: float
    worst_ms: float


def summaries(proofs: Sequence[Proof]) -> Iterator[Summary]:
    """Summarise the results of each family, then of all families together (`preset` is "all")."""
    for preset in (*dict.fromkeys(proof.case.preset for proof in proofs), "all"):
        here = [proof for proof in proofs if preset in (proof.case.preset, "all")]
        milliseconds = [1e3 * proof.seconds for proof in here]
        failed = sum(proof.failure is not None for proof in here)
        rooms, lacking = sum(proof.rooms for proof in here), sum(proof.lacking for proof in here)
        yield Summary(preset, len(here), failed, rooms, lacking, float(np.median(milliseconds)), max(milliseconds))
