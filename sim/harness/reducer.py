"""`reduce`: from a failing scenario to the smallest one that fails in the same way.

The search is greedy: the steps of `reductions` are tried in a fixed order, every candidate that fails with the same
signature replaces the scenario, and the search ends when no step helps any more. Candidates differ from the scenario in one
step, so their tours differ too; whether they fail is decided by running them.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import Literal

from sim.errors import SimError
from sim.fidelity import Fidelity
from sim.harness.failure_signature import Signature
from sim.harness.reductions import STEPS, ScenarioSize, Step, size, with_features, with_listed_house
from sim.harness.scenario import Scenario
from worlds.errors import WorldsError
from worlds.spec import HouseSpec
from worlds.validation import built_and_checked

DEADLINE_S = 180.0
_SEARCH_SHARE = 0.6
"""Share of the time for the search on features, if the result still has to be confirmed on images."""
_TO_FEATURES = "feature fidelity"

Fails = Callable[[Scenario], Signature | None]
"""Runs a scenario: the signature of its failure, or None. It may raise any exception for a scenario that cannot be run."""
Clock = Callable[[], float]
"""Tells the time [s]."""
Ending = Literal["smallest", "deadline", "interrupted"]
"""No step led to a smaller failure, time was up, or the user interrupted the search."""
Outcome = Literal["fails", "passes", "fails differently", "cannot run", "invalid"]


@dataclass(frozen=True, eq=False)
class Attempt:
    """A candidate that was tried, for progress reports."""

    step: str
    """The step that led to it, a key of `reductions.STEPS`."""
    scenario: Scenario
    outcome: Outcome
    tried: int
    """Number of candidates so far."""
    elapsed_s: float


@dataclass(frozen=True, eq=False)
class Change:
    """A scenario with the step that led to it."""

    step: str
    scenario: Scenario


@dataclass(frozen=True, eq=False)
class Reduction:
    """The smallest failing scenario that was found, and how."""

    original: Scenario
    """The failing scenario with everything in its house listed."""
    scenario: Scenario
    """The smallest scenario that fails with the same signature."""
    signature: Signature
    accepted: tuple[Change, ...]
    """The failing scenarios on the way, from large to small; the last one is `scenario`, unless the list is empty."""
    passing: tuple[Change, ...]
    """Scenarios one step smaller than `scenario` that do not fail, in the order in which they were tried."""
    tried: int
    """Candidates that were looked at; equal ones count once."""
    ended: Ending
    """Why the search ended."""
    searched_on: Fidelity
    """What the candidates were run on; "features" for a scenario of fidelity "render" whose failure exists there too."""
    confirmed: bool
    """Whether `scenario` was run on the fidelity of the original, and failed."""

    @property
    def sizes(self) -> tuple[ScenarioSize, ScenarioSize]:
        """Size of the original and of the smallest scenario."""
        return size(self.original), size(self.scenario)

    @property
    def note(self) -> str:
        """How the search went, in one or two sentences."""
        why = {
            "smallest": "no single step makes it smaller",
            "deadline": "time was up, so a smaller one may exist",
            "interrupted": "the search was interrupted, so a smaller one may exist",
        }[self.ended]
        how = f"{self.tried} candidates, {len(self.accepted)} steps; {why}."
        if self.original.fidelity != "render":
            return how
        if self.searched_on == "render":
            return f"{how} The search ran on rendered images, because the failure does not exist on feature fidelity."
        confirmed = (
            "the result was confirmed on rendered images" if self.confirmed else "nothing was confirmed on images yet"
        )
        return f"{how} The search ran on feature fidelity, and {confirmed}."


def reduce(
    scenario: Scenario,
    fails: Fails,
    deadline_s: float = DEADLINE_S,
    on_progress: Callable[[Attempt], None] | None = None,
    clock: Clock = time.monotonic,
    steps: Mapping[str, Step] = STEPS,
) -> Reduction:
    """Make a failing scenario smaller while the signature of its failure stays the same.

    `steps` are tried in their order. A candidate counts only if its house is valid and its run fails with the same
    signature. When `deadline_s` have passed, or on Ctrl-C, the smallest scenario so far is returned; a run that has begun
    is completed after the deadline.

    If the scenario has images and the failure exists on feature fidelity too, the search runs there. Its results are then
    run on images, from the smallest one up, until one fails. If that is not the smallest one, the search goes on from there
    with images while time is left.

    Raises `SimError` for a scenario that does not fail, and what `fails` raises for it.
    """
    end = clock() + deadline_s
    original = with_listed_house(scenario)
    signature = fails(original)
    if signature is None:
        raise SimError("scenario: it does not fail; valid: a scenario of which the failure is true")
    search = _Search(fails, signature, end, on_progress, clock, steps)
    path, on_features = [Change("the original", original)], list[Change]()
    ended: Ending = "smallest"
    try:
        if original.fidelity == "render":
            search.descend_on_features(with_features(original), on_features, path)
        if len(path) == 1 or len(path) < len(on_features):
            search.descend(path, search.end)
        elif search.is_cut:
            ended = "deadline"
    except _TimeUpError:
        ended = "deadline"
    except KeyboardInterrupt:
        ended = "interrupted"
    return search.reduction(original, path, on_features, ended)


class _TimeUpError(Exception):
    """The deadline has passed."""


@dataclass(eq=False)
class _Search:
    """The state of a search. It remembers all outcomes, so that no scenario is run twice."""

    fails: Fails
    signature: Signature
    end: float
    on_progress: Callable[[Attempt], None] | None
    clock: Clock
    steps: Mapping[str, Step]
    outcomes: dict[str, Outcome] = field(default_factory=dict)
    """Outcome of every scenario that was tried; the key is the content hash of the scenario."""
    is_cut: bool = False
    """Whether the search on features took all of its share of the time."""

    def __post_init__(self) -> None:
        self.begin = self.clock()

    def descend(self, path: list[Change], until: float) -> None:
        """Append smaller failing scenarios to the path until no step finds one. Raises _TimeUpError at the time `until`."""
        moved = True
        while moved:
            moved = False
            for name, step in self.steps.items():
                moved |= self._descend_by(name, step, path, until)

    def _descend_by(self, name: str, step: Step, path: list[Change], until: float) -> bool:
        """Repeat one step, each time from the place in its candidates at which the last one was found."""
        place, moved = 0, False
        while (found := self._first_failing(name, step, path[-1].scenario, place, until)) is not None:
            place, scenario = found
            path.append(Change(name, scenario))
            moved = True
        return moved

    def _first_failing(self, name: str, step: Step, best: Scenario, place: int, until: float) -> tuple[int, Scenario] | None:
        limit = size(best)
        for number, candidate in islice(enumerate(step(best)), place, None):
            if size(candidate) < limit and self.outcome(name, candidate, until) == "fails":
                return number, candidate
        return None

    def outcome(self, step: str, scenario: Scenario, until: float) -> Outcome:
        """Run a scenario unless an equal one was run. Raises _TimeUpError if it is too late for that."""
        key = scenario.content_hash
        if key not in self.outcomes:
            if self.clock() >= until:
                raise _TimeUpError
            self.outcomes[key] = self._run(scenario)
            if self.on_progress is not None:
                elapsed_s = self.clock() - self.begin
                self.on_progress(Attempt(step, scenario, self.outcomes[key], len(self.outcomes), elapsed_s))
        return self.outcomes[key]

    def _run(self, scenario: Scenario) -> Outcome:
        if not is_valid(scenario):
            return "invalid"
        try:
            signature = self.fails(scenario)
        except Exception:  # whatever a SLAM raises in a run that it cannot do
            return "cannot run"
        if signature is None:
            return "passes"
        return "fails" if signature == self.signature else "fails differently"

    def descend_on_features(self, start: Scenario, found: list[Change], path: list[Change]) -> None:
        """Search on features; then run the results on images, from the smallest up, and append the first that fails there.

        `found` gets the failing scenarios on features. It is emptied if none of them, tried in steps of 1, 2, 4 ... back,
        fails on images.
        """
        if self.outcome(_TO_FEATURES, start, self.end) != "fails":
            return
        found.append(Change(_TO_FEATURES, start))
        try:
            self.descend(found, self.begin + _SEARCH_SHARE * (self.end - self.begin))
        except _TimeUpError:  # of this part of the search; the rest of the time is for images
            self.is_cut = True
        back = 1
        while back < len(found):
            rendered = [replace(change.scenario, fidelity="render") for change in found[1 : len(found) - back + 1]]
            if self.outcome(found[-back].step, rendered[-1], self.end) == "fails":
                path += [Change(c.step, scenario) for c, scenario in zip(found[1:], rendered, strict=False)]
                return
            back *= 2
        found.clear()

    def reduction(self, original: Scenario, path: list[Change], on_features: list[Change], ended: Ending) -> Reduction:
        """The result; if time was up before anything was confirmed on images, that of the search on features."""
        unconfirmed = len(path) == 1 and len(on_features) > 1
        accepted = on_features if unconfirmed else path
        best = accepted[-1].scenario
        return Reduction(
            original,
            best,
            self.signature,
            tuple(accepted[1:]),
            tuple(self._passing(best)),
            len(self.outcomes),
            ended,
            "features" if on_features else original.fidelity,
            not unconfirmed,
        )

    def _passing(self, best: Scenario) -> Iterator[Change]:
        """Those of the candidates next to a scenario that were run and do not fail."""
        for name, step in self.steps.items():
            for candidate in step(best):
                if self.outcomes.get(candidate.content_hash) == "passes":
                    yield Change(name, candidate)


def is_valid(scenario: Scenario) -> bool:
    """Whether the house of a scenario can be written, read, built, and walked through; see `worlds.validate`."""
    try:
        if scenario.house is not None:
            built_and_checked(HouseSpec.from_json(scenario.house.to_json()))
    except WorldsError:
        return False
    return True
