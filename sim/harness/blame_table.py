"""`blame`: run a failing scenario again with one thing replaced at a time, and say which replacement mends it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Literal

from sim.fidelity import ORACLE
from sim.harness.adapters.lexis import Lexis
from sim.harness.failure_signature import FailureTest, Runner
from sim.harness.house_reductions import keep_furniture
from sim.harness.parts import house_spec
from sim.harness.reductions import with_features, with_listed_house
from sim.harness.runner import Progress, Run, run
from sim.harness.scenario import Scenario
from worlds.errors import WorldsError
from worlds.spec import HouseSpec
from worlds.variant import variant

SMALL_M = 0.5
"""Pieces of furniture of which no side is longer count as clutter [m]."""
Verdict = Literal["mends", "does not mend", "changes nothing", "cannot be told"]


@dataclass(frozen=True, eq=False)
class Substitution:
    """A scenario in which one thing is replaced, or a SLAM in which one is."""

    name: str
    scenario: Scenario
    runner: Runner | None = None
    """Runs the changed SLAM; None: that of the failure."""


@dataclass(frozen=True)
class BlameRow:
    """What one substitution does to a failure."""

    substitution: str
    verdict: Verdict
    value: float | None = None
    """The figure of the claim in the run with the substitution."""
    detail: str = ""
    """Why it cannot be told, if so."""


@dataclass(frozen=True)
class BlameTable:
    """What all substitutions do."""

    rows: tuple[BlameRow, ...]

    def named(self, verdict: Verdict) -> tuple[str, ...]:
        """The substitutions with that verdict."""
        return tuple(row.substitution for row in self.rows if row.verdict == verdict)

    def __str__(self) -> str:
        """Such as "mended by: oracle encoder. Not mended by: perfect odometry."."""
        mending, others = ", ".join(self.named("mends")), ", ".join(self.named("does not mend"))
        return f"mended by: {mending or 'nothing'}." + (f" Not mended by: {others}." if others else "")


def blame(
    scenario: Scenario, test: FailureTest, is_lexis: bool = False, on_row: Callable[[BlameRow], None] | None = None
) -> BlameTable:
    """Try all substitutions on a failing scenario; `is_lexis` says whether the SLAM of the test is LEXIS.

    Raises `WorldsError` for a house that cannot be built.
    """
    rows = []
    listed = with_listed_house(scenario)
    for substitution in substitutions(listed, is_lexis):
        rows.append(_judged(listed, substitution, test))
        if on_row is not None:
            on_row(rows[-1])
    return BlameTable(tuple(rows))


def substitutions(scenario: Scenario, is_lexis: bool) -> Iterator[Substitution]:
    """The substitutions that need no access to the inside of a SLAM; for LEXIS also those that do."""
    spec = house_spec(scenario)
    yield Substitution("perfect odometry", replace(scenario, odometry="perfect", overconfidence=1.0))
    yield Substitution("no faults", replace(scenario, faults=()))
    if scenario.fidelity == "render":  # features have no lighting
        yield Substitution("daylight", replace(scenario, house=_in_daylight(spec)))
    yield Substitution("no clutter", replace(scenario, house=without_clutter(spec)))
    closed = _closed(spec)
    if closed is not None:
        yield Substitution("openness 0", replace(scenario, house=closed))
    if is_lexis:
        yield from _of_lexis(scenario)


def _of_lexis(scenario: Scenario) -> Iterator[Substitution]:
    on_features = with_features(scenario)
    if scenario.fidelity == "render":
        yield Substitution("feature sensor", on_features)
    yield Substitution("oracle encoder", replace(on_features, encoder=ORACLE))
    yield Substitution("loops off", scenario, _without_loops)


def _without_loops(scenario: Scenario, progress: Progress | None) -> Run:
    return run(scenario, Lexis(scenario.encoder, loops=False), progress)


def _judged(scenario: Scenario, substitution: Substitution, test: FailureTest) -> BlameRow:
    name = substitution.name
    if substitution.runner is None and substitution.scenario == scenario:
        return BlameRow(name, "changes nothing")
    changed = test if substitution.runner is None else replace(test, runner=substitution.runner)
    try:
        if changed.claim is None:
            return BlameRow(name, "mends" if changed(substitution.scenario) is None else "does not mend")
        observed = changed.observe(substitution.scenario)
    except Exception as error:  # of the scenario, or of any SLAM
        return BlameRow(name, "cannot be told", detail=f"{type(error).__name__}: {error}")
    if observed.value is None:
        return BlameRow(name, "cannot be told", detail=f"{changed.claim.figure} is null")
    return BlameRow(name, "does not mend" if observed.signature else "mends", observed.value)


def without_clutter(spec: HouseSpec) -> HouseSpec:
    """The house without the pieces of furniture of which no side is longer than `SMALL_M`; it has to list its furniture."""
    pieces = [piece for storey in spec.storeys for piece in storey.furniture or ()]
    return keep_furniture(spec, {piece.id for piece in pieces if max(piece.size_m) > SMALL_M})


def _in_daylight(spec: HouseSpec) -> HouseSpec:
    return spec.model_copy(update={"appearance": spec.appearance.model_copy(update={"light": "day"})})


def _closed(spec: HouseSpec) -> HouseSpec | None:
    """The house with all inner walls closed by doors; None where the walls are too short for doors."""
    try:
        return variant(spec, openness=0.0)
    except WorldsError:
        return None
