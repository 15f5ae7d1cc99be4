"""`lexis-sim house prove`: houses of all families, each validated, and each made again, bit by bit, in another process."""

import hashlib
import json
import multiprocessing
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import repeat

import numpy as np

from worlds.errors import WorldsError
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.truth_json import truth_json
from worlds.validation import validate

_CHUNK = 20
_OPENNESS, _CLUTTER = (None, 0.0, 0.25, 0.5, 0.75, 1.0), (1.0, 1.0, 0.0, 2.0, 4.0)
"""In turn; their numbers have no common divisor, so every pair of them comes up."""


@dataclass(frozen=True)
class Case:
    """A house to be proved."""

    preset: str
    seed: int
    openness: float | None
    clutter: float

    def __str__(self) -> str:
        openness = "" if self.openness is None else f" --openness {self.openness:g}"
        return f"--preset {self.preset} --seed {self.seed}{openness} --clutter {self.clutter:g}"


@dataclass(frozen=True)
class Proof:
    """What came of a house."""

    case: Case
    seconds: float
    """Of one core, for plan, openings, stairs, windows, furniture, truth and validation; whatever else the machine does."""
    failure: str | None
    """Why it is no house, or not the same house in another process."""


@dataclass(frozen=True)
class _Made:
    seconds: float
    digest: str
    failure: str | None


def cases(presets: Sequence[str], seed: int, count: int) -> list[Case]:
    """`count` houses with seeds from `seed` up: presets in turn, every second round with openness and clutter asked for."""
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
    """Prove houses one by one, in order, with `processes` at work (two at least: every house is made in two of them)."""
    # Started afresh, as another run would be: with another hash seed and empty caches.
    context = multiprocessing.get_context("spawn")
    workers = max(1, processes // 2)
    with ProcessPoolExecutor(workers, context) as first, ProcessPoolExecutor(workers, context) as second:
        try:
            once = first.map(_make, wanted, repeat(True), chunksize=_CHUNK)
            again = second.map(_make, wanted, repeat(False), chunksize=_CHUNK)
            for case, one, other in zip(wanted, once, again, strict=True):
                differs = "is another house when generated again" if one.digest != other.digest else None
                yield Proof(case, one.seconds, one.failure or differs)
        finally:
            first.shutdown(cancel_futures=True)
            second.shutdown(cancel_futures=True)


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
    return _Made(seconds, hashlib.sha256((spec.to_json() + json.dumps(truth)).encode()).hexdigest(), None)


@dataclass(frozen=True)
class Summary:
    """Of the houses of a family."""

    preset: str
    houses: int
    failed: int
    median_ms: float
    worst_ms: float


def summaries(proofs: Sequence[Proof]) -> Iterator[Summary]:
    """Family by family, then all of them."""
    for preset in (*dict.fromkeys(proof.case.preset for proof in proofs), "all"):
        here = [proof for proof in proofs if preset in (proof.case.preset, "all")]
        milliseconds = [1e3 * proof.seconds for proof in here]
        failed = sum(proof.failure is not None for proof in here)
        yield Summary(preset, len(here), failed, float(np.median(milliseconds)), max(milliseconds))
