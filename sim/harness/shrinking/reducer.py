"""`reduce`: finds the smallest scenario that fails in the same way as a given scenario.

The search is greedy. The steps of `reductions` are tried in a fixed order; each yields candidates, which are simpler
scenarios. A candidate whose run fails with the same signature replaces the scenario. The search ends when no step helps any
more. The tour of a candidate may differ from the tour of the scenario, so only a run shows whether the candidate fails.
"""

import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import islice

from sim.errors import USER_ERRORS, SimError
from sim.fidelity import Fidelity
from sim.harness.run_settings import with_listed_house
from sim.harness.scenario import Scenario
from sim.harness.shrinking.failure_signature import Signature
from sim.harness.shrinking.reduction import CandidateOutcome, Change, Ending, Reduction
from sim.harness.shrinking.reductions import STEPS, Step, for_images, with_features
from sim.harness.shrinking.scenario_size import size
from worlds.errors import WorldsError
from worlds.spec import HouseSpec
from worlds.validation import built_and_checked

DEADLINE_S = 180.0
_SEARCH_SHARE = 0.6
"""Share of the time that the search on features may use, if its result still has to be confirmed on images."""
_TO_FEATURES = "feature fidelity"

Fails = Callable[[Scenario], Signature | None]
"""A function that runs a scenario and returns the signature of its failure, or None if the run passes. It may raise any
exception."""
Clock = Callable[[], float]
"""A function that returns the time [s], like `time.monotonic`."""


@dataclass(frozen=True, eq=False)
class TriedCandidate:
    """A candidate that was tried, for progress reports."""

    step: str
    """Name of the step that made the candidate, such as a key of `reductions.STEPS`."""
    scenario: Scenario
    outcome: CandidateOutcome
    tried: int
    """Number of candidates that were tried so far, this one included."""
    elapsed_s: float


def reduce(
    scenario: Scenario,
    fails: Fails,
    deadline_s: float = DEADLINE_S,
    on_progress: Callable[[TriedCandidate], None] | None = None,
    clock: Clock = time.monotonic,
    steps: Mapping[str, Step] = STEPS,
) -> Reduction:
    """Make a failing scenario smaller while the signature of its failure stays the same.

    `steps` are tried in their order; with images, the steps that make a run quicker come first. A candidate counts only if
    its house is valid and its run fails with the same signature. When `deadline_s` have passed, or on Ctrl-C, the smallest
    scenario so far is returned; a run that has begun is completed after the deadline.

    If the scenario has images and also fails on features, the search runs on features first. The failing scenarios that it
    finds are then run on images, from the smallest one up, until one fails. Unless this is the smallest one, the search goes
    on from there with images while time is left. If none fails on images, the search begins anew at the original with
    images.

    Raises `SimError` for a scenario that does not fail, and what `fails` raises for this scenario.
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
    """A search and its state. The outcomes of all scenarios are remembered, so that no scenario is run twice."""

    fails: Fails
    signature: Signature
    end: float
    on_progress: Callable[[TriedCandidate], None] | None
    clock: Clock
    steps: Mapping[str, Step]
    outcomes: dict[str, CandidateOutcome] = field(default_factory=dict)
    """Outcome of every scenario that was tried; the key is the content hash of the scenario."""
    last_passing: tuple[Scenario, Change] | None = None
    """The last run that passed: the failing scenario from which its candidate was made, and the candidate."""
    best: Scenario | None = None
    """The failing scenario whose candidates are being tried."""
    passing: dict[str, Change] = field(default_factory=dict)
    """The candidates of `best` that pass, by content hash."""
    on_features: CandidateOutcome | None = None
    """Outcome of the original with fidelity "features"; None if this was not tried."""
    from_features: int = 1
    """Length of the path after the search on features."""
    is_cut: bool = False
    """Whether the search on features was stopped because its share of the time was used up."""

    def __post_init__(self) -> None:
        self.begin = self.clock()

    def descend(self, path: list[Change], until: float) -> None:
        """Append smaller failing scenarios to the path until no step finds one. Raises _TimeUpError at the time `until`."""
        moved = True
        while moved:
            moved = False
            for name, step in self.steps_on(path[-1].scenario.fidelity).items():
                moved |= self._descend_by(name, step, path, until)

    def steps_on(self, fidelity: Fidelity) -> Mapping[str, Step]:
        """Return the steps in the order in which they are tried on scenarios of the given fidelity."""
        return for_images(self.steps) if fidelity == "render" else self.steps

    def _descend_by(self, name: str, step: Step, path: list[Change], until: float) -> bool:
        """Append smaller failing scenarios to the path by one step until it finds no more; return whether it found any.

        After each success, the step is applied to the scenario that it found. Candidates before the position of the
        successful one are not tried again.
        """
        place, moved = 0, False
        while (found := self._first_failing(name, step, path[-1].scenario, place, until)) is not None:
            place, scenario = found
            path.append(Change(name, scenario))
            moved = True
        return moved

    def _first_failing(self, name: str, step: Step, best: Scenario, place: int, until: float) -> tuple[int, Scenario] | None:
        if best is not self.best:
            self.best, self.passing = best, {}
        limit = size(best)
        for number, candidate in islice(enumerate(step(best)), place, None):
            if size(candidate) < limit:
                outcome = self.outcome(name, candidate, until)
                if outcome == "fails":
                    return number, candidate
                if outcome == "passes":
                    self.last_passing = best, Change(name, candidate)
        return None

    def outcome(self, step: str, scenario: Scenario, until: float) -> CandidateOutcome:
        """Return the outcome of a scenario; run the scenario if needed. Raises _TimeUpError if it is too late for a run."""
        key = scenario.content_hash
        if key not in self.outcomes:
            if self.clock() >= until:
                raise _TimeUpError
            self.outcomes[key] = self._run(scenario)
            if self.on_progress is not None:
                elapsed_s = self.clock() - self.begin
                self.on_progress(TriedCandidate(step, scenario, self.outcomes[key], len(self.outcomes), elapsed_s))
        if self.outcomes[key] == "passes":
            self.passing.setdefault(key, Change(step, scenario))
        return self.outcomes[key]

    def _run(self, scenario: Scenario) -> CandidateOutcome:
        if not is_valid(scenario):
            return "invalid"
        try:
            signature = self.fails(scenario)
        except USER_ERRORS:  # of a SLAM in a run that it cannot do
            return "cannot run"
        if signature is None:
            return "passes"
        if signature == self.signature.unavoidable:
            return "unavoidable"
        if signature == self.signature.of_reference:
            return "reference fails"
        return "fails" if signature == self.signature else "fails differently"

    def descend_on_features(self, start: Scenario, found: list[Change], path: list[Change]) -> None:
        """Search on features, then run the found scenarios on images, from the smallest one up, until one fails there.

        `found` gets the scenarios that fail on features, from large to small. The last scenario of `found` is run on images
        first, then the scenarios 1, 3, 7, ... places before it. The scenarios up to the one that fails on images are
        appended to `path`. If none of the scenarios that were run fails on images, `found` is emptied.
        """
        self.on_features = self.outcome(_TO_FEATURES, start, self.end)
        if self.on_features != "fails":
            return
        found.append(Change(_TO_FEATURES, start))
        try:
            self.descend(found, self.begin + _SEARCH_SHARE * (self.end - self.begin))
        except _TimeUpError:  # the time for features is up; the rest is for images
            self.is_cut = True
        back = 1
        while back < len(found):
            rendered = [replace(change.scenario, fidelity="render") for change in found[1 : len(found) - back + 1]]
            if self.outcome(found[-back].step, rendered[-1], self.end) == "fails":
                path += [Change(c.step, scenario) for c, scenario in zip(found[1:], rendered, strict=False)]
                self.from_features = len(path)
                return
            back *= 2
        found.clear()

    def reduction(self, original: Scenario, path: list[Change], on_features: list[Change], ended: Ending) -> Reduction:
        """Make the result of the search from its `path`.

        If time was up before any smaller scenario failed on images, the result is the unconfirmed result of the search on
        features.
        """
        unconfirmed = len(path) == 1 and len(on_features) > 1
        accepted = on_features if unconfirmed else path
        best, counts = accepted[-1].scenario, Counter(self.outcomes.values())
        return Reduction(
            original=original,
            scenario=best,
            signature=self.signature,
            accepted=tuple(accepted[1:]),
            passing=tuple(self._passing(best)),
            last_passing=self.last_passing,
            tried=len(self.outcomes),
            unavoidable=counts["unavoidable"],
            of_reference=counts["reference fails"],
            different=counts["fails differently"],
            ended=ended,
            searched_on="features" if on_features else original.fidelity,
            ended_on="features" if on_features and len(path) <= self.from_features else original.fidelity,
            confirmed=not unconfirmed,
            on_features=self.on_features,
        )

    def _passing(self, best: Scenario) -> list[Change]:
        """Return the scenarios one step smaller than `best` that passed, in the order of the steps.

        They have the fidelity of `best`. Only outcomes that the search already knows are used, because time may be up.
        """
        if self.best not in (best, with_features(best)):
            return []
        places = list(self.steps_on(best.fidelity))
        near = [change for change in self.passing.values() if change.step in places]
        found = (Change(change.step, replace(change.scenario, fidelity=best.fidelity)) for change in near)
        return sorted(found, key=lambda change: places.index(change.step))


def is_valid(scenario: Scenario) -> bool:
    """Return whether the house of a scenario can be saved, loaded and built, and is valid; see `worlds.validation`."""
    try:
        if scenario.house is not None:
            built_and_checked(HouseSpec.from_json(scenario.house.to_json()))
    except WorldsError:
        return False
    return True
