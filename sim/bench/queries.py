"""`lexis-sim bench queries`: everyday questions to the maps of generated houses, as `lexis query` answers them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64, Int

from lexis.encoder.open_clip_encoder import load_encoder
from lexis.perception import TextEncoder
from lexis.query.answers import ask
from lexis.query.calibration import Calibration, calibration_of
from lexis.types import LexisMap
from sim.bench.everyday_questions import HELD_OUT, TUNING, EverydayQuestion
from sim.harness import RunConfig, run
from worlds.house import House
from worlds.truth import objects, room_at

SETS = {"tuning": TUNING, "held out": HELD_OUT}


class Answered(NamedTuple):
    """A question to a map, and what became of it."""

    question: EverydayQuestion
    has_answer: bool
    """Whether a room of the map answers it."""
    first: str
    """Label of the true room that was ranked first."""
    right: bool
    """Whether that room answers it."""
    unknown: bool
    """Whether `lexis query` says that nothing fits."""

    @property
    def succeeded(self) -> bool:
        """A right room is told as such, or it is said that there is none."""
        return self.right and not self.unknown if self.has_answer else self.unknown


@dataclass(frozen=True)
class QueriesRow:
    """Figures of some questions; None where nothing was asked."""

    questions: int
    """Those with an answer in the house."""
    ranked_first: float | None
    """Share of them whose best room is an answer."""
    answered: float | None
    """Share of them whose best room is an answer and reaches the probability from which on it is told."""
    vain: int
    """Those without an answer."""
    refused: float | None
    """Share of these to which nothing is told to fit."""


def ask_houses(config: RunConfig, seeds: Sequence[int]) -> Iterator[tuple[int, str, list[Answered]]]:
    """One run per seed, all else as in `config`; the answers to every set of questions."""
    encoder = load_encoder(config.encoder)
    calibration = calibration_of(encoder)
    for seed in seeds:
        finished = run(replace(config, seed=seed), encoder)
        rooms = true_rooms(finished.house, finished.map, finished.true_poses)
        for name, questions in SETS.items():
            yield seed, name, [ask_one(q, finished.house, finished.map, rooms, encoder, calibration) for q in questions]


def ask_one(
    question: EverydayQuestion,
    house: House,
    lexis_map: LexisMap,
    rooms: Int[np.ndarray, "rooms"],
    encoder: TextEncoder,
    calibration: Calibration | None,
) -> Answered:
    """Ask a map one question. `rooms`: the true room of each of its rooms, by index into `house.rooms`."""
    answers = answering_rooms(question, house)
    answer = ask(lexis_map, question.text, encoder, calibration)
    first = rooms[next(i for i, room in enumerate(lexis_map.rooms) if room.id == answer.rooms[0].room.id)]
    return Answered(question, bool(answers[rooms].any()), house.rooms[first].label, bool(answers[first]), answer.unknown)


def answering_rooms(question: EverydayQuestion, house: House) -> Bool[np.ndarray, "rooms"]:
    """Whether each room of the house answers the question."""
    holding = {thing.room for thing in objects(house) if thing.kind in question.kinds}
    answers = np.array([room.label in question.labels or room.id in holding for room in house.rooms])
    return ~answers if question.negated else answers


def true_rooms(house: House, lexis_map: LexisMap, T_W_B: Float64[np.ndarray, "n 4 4"]) -> Int[np.ndarray, "rooms"]:
    """The true room in which most keyframes of every room of the map were taken, by index into `house.rooms`."""
    owner = room_at(house, T_W_B[:, :3, 3])
    return np.array([np.bincount(owner[list(room.keyframes)] + 1)[1:].argmax() for room in lexis_map.rooms], int)


def row_of(answered: Sequence[Answered]) -> QueriesRow:
    """Figures of these questions."""
    asked = [one for one in answered if one.has_answer]
    vain = [one for one in answered if not one.has_answer]
    return QueriesRow(
        len(asked),
        _share([one.right for one in asked]),
        _share([one.succeeded for one in asked]),
        len(vain),
        _share([one.succeeded for one in vain]),
    )


def _share(values: Sequence[bool]) -> float | None:
    return float(np.mean(values)) if values else None
