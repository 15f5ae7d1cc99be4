"""Methods of the user's own beside LEXIS: segmentations of the true map, and methods of place recognition.

Their exceptions, and what they return if it is not valid, become errors that name the method and the house.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass

import numpy as np

from lexis.errors import one_line
from sim.baselines.places.place_method import PlaceMethod, Scores, SeenKeyframes
from sim.baselines.rooms.cells import Free, Segments
from sim.baselines.rooms.map_rooms import MapSegmentation
from sim.bench.peers.place_walks import PlaceWalk
from sim.errors import USER_ERRORS, SimError
from sim.harness.crash import place_in_own_code
from sim.wording import class_of, error_text


class OwnMethodError(SimError):
    """A method of the user's own has raised an exception, or has returned what is not valid."""


@dataclass(frozen=True)
class OwnSegmentation:
    """A segmentation of the user's own, under the name of its rows in tables."""

    name: str
    method: MapSegmentation

    def segments(self, free: Free, resolution_m: float) -> Segments:
        """Return the segments that the method finds; see `MapSegmentation.segments`.

        Raises `OwnMethodError` if the method raises an exception, or returns anything but an array of whole numbers from 0
        that has the shape of `free`.
        """
        call = f"{self.name}: segments()"
        with _calling(call):
            found = self.method.segments(free, resolution_m)
        _check_array(call, found, free.shape, "iu")
        if found.min(initial=0) < 0:
            raise OwnMethodError(f"{call} returns {found.min()} for a cell; valid: 1 or more, or 0 for a cell without room")
        return found.astype(np.int32)


@dataclass(frozen=True)
class OwnPlaces:
    """A method of place recognition of the user's own, under the name of its rows in tables."""

    name: str
    method: PlaceMethod

    def scores(self, seen: SeenKeyframes) -> Scores:
        """Return the scores of the method, with -inf for keyframes that are not eligible; see `PlaceMethod.scores`.

        Raises `OwnMethodError` if the method raises an exception, or returns anything but an n x n array of numbers, where n
        is the number of keyframes. The score of an eligible keyframe must be finite or -inf.
        """
        call = f"{self.name}: scores()"
        with _calling(call):
            found = self.method.scores(deepcopy(seen))  # the method may write into the arrays
        _check_array(call, found, seen.eligible.shape, "fiu")
        scores = seen.only_eligible(found.astype(np.float64))
        if (wrong := scores[np.isnan(scores) | np.isposinf(scores)]).size:
            raise OwnMethodError(f"{call} returns {wrong[0]}; valid: finite numbers, and -inf for a keyframe not proposed")
        return scores


def scores_on(walk: PlaceWalk, method: PlaceMethod) -> Scores:
    """Return the scores of a method for the keyframes of a walk. An `OwnMethodError` names the house of the walk."""
    with naming_run(f"{walk.preset}, seed {walk.seed}"):
        return method.scores(walk.seen)


@contextmanager
def naming_run(run: str) -> Iterator[None]:
    """Let the message of an `OwnMethodError` in the block begin with the name of a run, such as "home, seed 500"."""
    try:
        yield
    except OwnMethodError as error:
        raise OwnMethodError(f"{run}: {error}") from error.__cause__


@contextmanager
def _calling(call: str) -> Iterator[None]:
    """Turn an exception in the block into an `OwnMethodError` whose message names the call."""
    try:
        yield
    except USER_ERRORS as error:
        raise OwnMethodError(f"{call} raises {one_line(error_text(error), 160)}{place_in_own_code(error)}") from error


def _check_array(call: str, found: object, shape: tuple[int, ...], kinds: str) -> None:
    """Raise `OwnMethodError` unless the result of a call is an array of this shape, with one of these kinds of numbers."""
    if isinstance(found, np.ndarray) and found.shape == shape and found.dtype.kind in kinds:
        return
    returned = f"{found.dtype} of shape {found.shape}" if isinstance(found, np.ndarray) else class_of(found)
    numbers = "numbers" if "f" in kinds else "whole numbers"
    raise OwnMethodError(f"{call} returns {returned}; valid: an array of {numbers} of shape {shape}")
