"""`lexis-sim bench queries`: how well `lexis query` answers everyday questions on maps of generated houses."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Int

from lexis.encoder.open_clip_encoder import load_encoder
from lexis.perception import TextEncoder
from lexis.questions.answers import ask
from lexis.questions.calibration import Calibration, find_calibration
from lexis.types import LexisMap
from sim.bench.everyday_questions import HELD_OUT, TUNING, EverydayQuestion
from sim.harness import Run, Scenario, run
from sim.harness.adapters import Lexis
from worlds.house import House
from worlds.truth import objects

SETS = {"tuning": TUNING, "held out": HELD_OUT}


class Answered(NamedTuple):
    """The answer of a map to one question, compared with the truth."""

    question: EverydayQuestion
    has_answer: bool
    """Whether the map contains a room that is a right answer."""
    first: str
    """True label of the room that was ranked first."""
    right: bool
    """Whether the room that was ranked first is a right answer."""
    unknown: bool
    """Whether `lexis query` reported that no room fits."""

    @property
    def succeeded(self) -> bool:
        """Whether a right room was reported, or "unknown" if the map has no right room."""
        return self.right and not self.unknown if self.has_answer else self.unknown


@dataclass(frozen=True)
class QueriesRow:
    """Figures over several questions. A share is None if there are no questions to compute it from."""

    questions: int
    """Number of questions with a right answer in the map."""
    ranked_first: float | None
    """Share of `questions` for which the room that is ranked first is a right answer."""
    answered: float | None
    """Share of `questions` for which the room that is ranked first is right, and probable enough to be reported."""
    vain: int
    """Number of questions without a right answer in the map."""
    refused: float | None
    """Share of the `vain` questions for which "unknown" is reported."""


def ask_houses(scenario: Scenario, seeds: Sequence[int]) -> Iterator[tuple[int, str, list[Answered]]]:
    """Make one run per seed, with all other settings from `scenario`, and ask all questions about its map.

    Yields (seed, name of the set of questions as in `SETS`, answers).
    """
    encoder = load_encoder(scenario.encoder)
    slam, calibration = Lexis(encoder), find_calibration(encoder)
    for seed in seeds:
        finished, lexis_map = run(replace(scenario, seed=seed), slam), slam.map
        rooms = true_rooms(finished, lexis_map)
        for name, questions in SETS.items():
            yield seed, name, [ask_one(q, finished.house, lexis_map, rooms, encoder, calibration) for q in questions]


def ask_one(
    question: EverydayQuestion,
    house: House,
    lexis_map: LexisMap,
    rooms: Int[np.ndarray, "rooms"],
    encoder: TextEncoder,
    calibration: Calibration | None,
) -> Answered:
    """Ask a map one question. `rooms` gives the true room of each room of the map, as an index into `house.rooms`."""
    answers = answering_rooms(question, house)
    answer = ask(lexis_map, question.text, encoder, calibration)
    first = rooms[next(i for i, room in enumerate(lexis_map.rooms) if room.id == answer.rooms[0].room.id)]
    return Answered(question, bool(answers[rooms].any()), house.rooms[first].label, bool(answers[first]), answer.unknown)


def answering_rooms(question: EverydayQuestion, house: House) -> Bool[np.ndarray, "rooms"]:
    """Return for each room of the house whether it is a right answer to the question."""
    holding = {thing.room for thing in objects(house) if thing.kind in question.kinds}
    answers = np.array([room.label in question.labels or room.id in holding for room in house.rooms])
    return ~answers if question.negated else answers


def true_rooms(finished: Run, lexis_map: LexisMap) -> Int[np.ndarray, "rooms"]:
    """Return for every room of the map the true room that contains most of its keyframes, as an index into `house.rooms`.

    The map is that of the finished run.
    """
    return np.array([np.bincount(finished.true_rooms[list(room.keyframes)]).argmax() for room in lexis_map.rooms], int)


def row_of(answered: Sequence[Answered]) -> QueriesRow:
    """Compute the figures of several answers."""
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
