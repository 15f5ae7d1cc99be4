"""`lexis-sim bench certainty`: the probabilities that LEXIS states for labels, against how often the labels are right."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from sim.harness import Scenario, run
from sim.harness.adapters import Lexis


@dataclass(frozen=True, eq=False)
class Predictions:
    """Labels that LEXIS states, with their probabilities, and whether they are right."""

    stated: Float64[np.ndarray, "n"]
    right: Bool[np.ndarray, "n"]


@dataclass(frozen=True, eq=False)
class Certainty:
    """The predictions about the labels of keyframes and of rooms."""

    keyframes: Predictions
    """Keyframes on a climb are left out, because their label follows from the height and not from probabilities."""
    rooms: Predictions
    """The label of a room is right if it is the most common true label of the room's keyframes."""


def measure_certainty(scenarios: Iterable[Scenario]) -> Certainty:
    """Let LEXIS map houses, and collect the probabilities that it states for its labels, with the truth."""
    keyframes, rooms = zip(*(_predictions(scenario) for scenario in scenarios), strict=True)
    return Certainty(_joined(keyframes), _joined(rooms))


def _predictions(scenario: Scenario) -> tuple[Predictions, Predictions]:
    """Return the predictions about the keyframes and about the rooms of one house."""
    slam = Lexis(scenario.encoder)
    finished = run(scenario, slam)
    map, truth = slam.map, finished.true_labels
    level = np.flatnonzero(map.floors >= 0)
    keyframes = Predictions(map.probabilities[level, map.labels[level]], map.labels[level] == truth[level])
    rooms = [room for room in map.rooms if room.floor is not None]
    majority = [np.bincount(truth[list(room.keyframes)]).argmax() for room in rooms]
    right = [map.room_names.index(room.label) == label for room, label in zip(rooms, majority, strict=True)]
    return keyframes, Predictions(np.array([map.probability_of(room) for room in rooms], float), np.array(right, bool))


def _joined(predictions: Sequence[Predictions]) -> Predictions:
    return Predictions(
        np.concatenate([each.stated for each in predictions]), np.concatenate([each.right for each in predictions])
    )
