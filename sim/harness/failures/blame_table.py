"""`blame`: reruns a failing scenario with one part of the run replaced at a time; says which changes mend the failure."""

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal

from sim.errors import USER_ERRORS, SimError
from sim.feature_sensor.oracle import Oracle
from sim.fidelity import ORACLE
from sim.harness.adapters.lexis import Lexis
from sim.harness.adapters.true_stages import TrueStages
from sim.harness.run_settings import house_spec
from sim.harness.runner import run
from sim.harness.scenario import Scenario
from sim.harness.shrinking.failure_signature import Signature
from sim.harness.shrinking.failure_test import FailureTest, Observed
from sim.harness.shrinking.house_edits import by_storey, keep_furniture
from sim.harness.shrinking.reducer import Fails
from sim.harness.shrinking.reduction import Reduction
from sim.harness.shrinking.reductions import with_features
from sim.wording import error_text, joined
from worlds.errors import WorldsError
from worlds.spec import HouseSpec
from worlds.validation import built_and_checked
from worlds.variant import in_light, variant

ORIGINAL_S = 60.0
"""Time after which no further run of the original scenario begins [s]. Runs on images take a minute each."""
SMALL_M = 0.5
"""Largest side length of a piece of furniture that counts as clutter [m]."""
Effect = Literal["mends", "does not mend", "changes nothing", "cannot be told"]
_NEEDLESS: Mapping[str, str] = MappingProxyType(
    {
        "perfect odometry": "drift",
        "no faults": "fault",
        "daylight": "special lighting",
        "no clutter": "clutter",
        "openness 0": "open wall",
        "oracle encoder": "error of the encoder",
    }
)
"""What a failure does not need if a substitution, given by its name, changes nothing in the failing scenario."""


@dataclass(frozen=True, eq=False)
class Substitution:
    """The replacement of one part of a failing run, as a changed scenario, a changed SLAM, or both."""

    name: str
    scenario: Scenario
    slam: Lexis | None = None
    """The changed SLAM; None if the SLAM is not changed."""


@dataclass(frozen=True)
class BlameRow:
    """The effect of one substitution on a failure."""

    substitution: str
    effect: Effect
    value: float | None = None
    """Value of the claim's figure in the run with the substitution; None without a claim or without such a run."""
    detail: str = ""
    """Reason why the effect cannot be told; else empty."""


@dataclass(frozen=True)
class BlameTable:
    """The effects of all substitutions on a failure.

    A smaller scenario may fail for another reason than the original scenario. If so, other substitutions mend it. The field
    `original` of the smallest scenario's table therefore holds a second table, about the original scenario.
    """

    rows: tuple[BlameRow, ...]
    """One row for each substitution that was tried."""
    original: "BlameTable | None" = None
    """The table of the original scenario, as far as there was time; None if it has no smaller one, or no row."""
    interrupted: bool = False
    """Whether the user interrupted the search for the smallest scenario, or `blame`, so that rows are missing."""

    def named(self, effect: Effect) -> tuple[str, ...]:
        """Return the names of the substitutions with the given effect."""
        return tuple(row.substitution for row in self.rows if row.effect == effect)

    def __str__(self) -> str:
        """Summarise the table, as in "mended by: oracle encoder. Not mended by: perfect odometry."."""
        mending, others = ", ".join(self.named("mends")), ", ".join(self.named("does not mend"))
        if mending or others:
            return f"mended by: {mending or 'nothing'}." + (f" Not mended by: {others}." if others else "")
        if unknown := [row for row in self.rows if row.effect == "cannot be told"]:
            return f"no replacement could be judged ({unknown[0].substitution}: {unknown[0].detail})."
        if self.not_needed:
            return f"the failure needs {self.not_needed}."
        return "what mends it is unknown, because Ctrl-C ended the search." if self.interrupted else "no change was tried."

    @property
    def another_error(self) -> str:
        """A hint that the original scenario has an error that the smallest one does not have; empty if nothing tells so.

        What mends the smallest scenario then does not mend the original one.
        """
        still_there = self.original.named("does not mend") if self.original is not None else ()
        only_here = [name for name in self.named("mends") if name in still_there]
        if not only_here:
            return ""
        return (
            f"The original scenario has another error, too: {joined(only_here, 'or')} mends only the smallest scenario. "
            "To find the other error, search with a limit closer to the original figure, or with a reference."
        )

    @property
    def not_needed(self) -> str:
        """What the failing scenario does not contain, so that the failure cannot need it: "no drift, fault or clutter".

        Empty if every substitution changes something.
        """
        nouns = [_NEEDLESS.get(name, f"error of {name}") for name in self.named("changes nothing")]
        return f"no {joined(nouns, 'or')}" if nouns else ""


def blame(
    reduction: Reduction,
    fails: Fails,
    is_lexis: bool = False,
    on_row: Callable[[BlameRow], None] | None = None,
    original_s: float = ORIGINAL_S,
) -> BlameTable:
    """Run the smallest failing scenario of a search again, each time with one part replaced by the truth or left out.

    The table says which replacements mend the failure. Then the original scenario is run with the replacements of the parts
    outside of the SLAM and, for LEXIS, of the encoder. None of these runs begins after `original_s` seconds. After an
    interruption of the search, nothing is run; after an interruption of these runs, the table has the finished rows.

    `fails` is the function with which `reduce` searched, and `is_lexis` says whether it runs LEXIS. If so, and if `fails` is
    a `FailureTest`, the stages of LEXIS are replaced as well, one at a time, in copies of the LEXIS that failed. If the test
    has not kept the failing run, the run is repeated for this, and its exceptions are passed on. With any other function,
    the encoder is the only part of LEXIS that is replaced. `on_row` is called with every finished row.

    Raises `WorldsError` if the house cannot be built.
    """
    if reduction.ended == "interrupted":
        return BlameTable((), interrupted=True)
    rows: list[BlameRow] = []
    original: list[BlameRow] = []
    interrupted = False
    tell = on_row or (lambda _: None)
    try:
        for substitution in _tried(reduction.scenario, fails, is_lexis):
            rows.append(_row(reduction.scenario, reduction.signature, substitution, fails))
            tell(rows[-1])
        end = time.monotonic() + original_s
        for substitution in _in_any_slam(reduction.original, is_lexis) if reduction.accepted else ():
            if time.monotonic() >= end:
                break
            original.append(_row(reduction.original, reduction.signature, substitution, fails))
            tell(original[-1])
    except KeyboardInterrupt:
        interrupted = True
    return BlameTable(tuple(rows), BlameTable(tuple(original)) if original else None, interrupted)


def _tried(scenario: Scenario, fails: Fails, is_lexis: bool) -> Iterator[Substitution]:
    """Yield the substitutions that `blame` tries. Only a `FailureTest` can run a changed SLAM."""
    if isinstance(fails, FailureTest):
        yield from substitutions(scenario, _lexis_of(scenario, fails) if is_lexis else None)
        return
    yield from _in_any_slam(scenario, is_lexis)


def _in_any_slam(scenario: Scenario, is_lexis: bool) -> Iterator[Substitution]:
    """Yield the substitutions outside of the SLAM and, for LEXIS, that of the encoder."""
    yield from _outside(scenario)
    if is_lexis:
        yield Substitution("oracle encoder", replace(with_features(scenario), encoder=ORACLE))


def _row(scenario: Scenario, signature: Signature, substitution: Substitution, fails: Fails) -> BlameRow:
    """Run a substitution in a scenario whose failure has this signature; a substitution that changes nothing is not run."""
    if substitution.slam is None and substitution.scenario == scenario:
        return BlameRow(substitution.name, "changes nothing")
    try:
        if isinstance(fails, FailureTest):
            return _tested(substitution, fails, signature)
        return _compared(substitution, fails, signature)
    except SimError as error:
        return BlameRow(substitution.name, "cannot be told", detail=f"the SLAM cannot run there: {error}")
    except USER_ERRORS as error:  # raised by the scenario or by any SLAM
        return BlameRow(substitution.name, "cannot be told", detail=error_text(error))


def _compared(substitution: Substitution, fails: Fails, signature: Signature) -> BlameRow:
    """Return the row of a substitution for a failure that no figure describes.

    These failures are compared by their signatures only.
    """
    found = fails(substitution.scenario)
    if found is not None and found != signature:
        return BlameRow(substitution.name, "cannot be told", detail=_differently(found, signature))
    return BlameRow(substitution.name, "mends" if found is None else "does not mend")


def _differently(found: Signature, signature: Signature) -> str:
    """Return why a failure with another signature than `signature` tells nothing about the blame."""
    if found == signature.unavoidable:
        return "a good SLAM fails there, too"
    if found == signature.of_reference:
        return "the reference fails there, too"
    if found == signature.with_other_errors:
        return "it fails by errors of another kind"
    return f"it fails differently: {found}"


def _lexis_of(scenario: Scenario, test: FailureTest) -> Lexis:
    """Return the LEXIS that failed or, if an exception left no finished run, a LEXIS with its usual settings."""
    outcome = test.outcome(scenario)
    slam = outcome.run.slam if isinstance(outcome, Observed) else None
    return slam if isinstance(slam, Lexis) else Lexis(scenario.encoder)


def substitutions(scenario: Scenario, lexis: Lexis | None) -> Iterator[Substitution]:
    """Yield substitutions, each of which replaces one part of the run by the truth or by a simpler case.

    Parts outside the SLAM come first: the odometry, the faults, the light, the furniture and the openings. With `lexis`, the
    stages of LEXIS follow.
    """
    yield from _outside(scenario)
    if lexis is not None:
        yield from _of_lexis(scenario, lexis)


def _outside(scenario: Scenario) -> Iterator[Substitution]:
    spec = house_spec(scenario)
    yield Substitution("perfect odometry", replace(scenario, odometry="perfect", overconfidence=1.0))
    yield Substitution("no faults", replace(scenario, faults=()))
    if scenario.fidelity == "render":  # features have no lighting
        yield Substitution("daylight", replace(scenario, house=in_light(spec, "day")))
    yield Substitution("no clutter", replace(scenario, house=without_clutter(spec)))
    for name, start in (("openness 0", spec), ("openness 0, furnished anew", _unfurnished(spec))):
        if (closed := _closed(start)) is not None:
            yield Substitution(name, replace(scenario, house=closed))
            break


def _of_lexis(scenario: Scenario, lexis: Lexis) -> Iterator[Substitution]:
    """Yield the substitutions of the input and the stages of LEXIS.

    In a run on images, the first one replaces the images by features. Then each stage is replaced by the truth, in the order
    of the stages. The last substitution switches loop closures off.
    """
    truth, on_features = TrueStages.of(scenario), with_features(scenario)
    told = replace(on_features, encoder=ORACLE)
    if scenario.fidelity == "render":
        yield Substitution("feature sensor", on_features)
    is_told = told == scenario and type(lexis.encoder) is Oracle
    yield Substitution("oracle encoder", told, None if is_told else lexis.with_stages(encoder=ORACLE))
    for name, changed in (
        ("true labels", lexis.with_stages(labeller=truth.label)),
        ("oracle place recognition", lexis.with_stages(place_recogniser=truth.propose)),
        ("oracle verification", lexis.with_stages(verifier=truth.verify)),
        ("oracle loops", lexis.with_stages(place_recogniser=truth.propose, verifier=truth.verify)),
        ("loops off", lexis.with_stages(place_recogniser=lambda *_: ())),
    ):
        yield Substitution(name, scenario, changed)


def _tested(substitution: Substitution, test: FailureTest, signature: Signature) -> BlameRow:
    name, slam = substitution.name, substitution.slam
    runner = test.runner if slam is None else lambda scenario, progress: run(scenario, slam, progress)
    changed = replace(test, runner=runner)  # a copy, so that the test keeps the run of the failure
    if changed.condition is None:
        return _compared(substitution, changed, signature)
    observed = changed.observe(substitution.scenario)
    if observed.value is None:
        return BlameRow(name, "cannot be told", detail=changed.condition.described(observed.result))
    if observed.signature is not None and observed.signature != signature:
        return BlameRow(name, "cannot be told", observed.value, _differently(observed.signature, signature))
    return BlameRow(name, "does not mend" if observed.signature else "mends", observed.value)


def without_clutter(spec: HouseSpec) -> HouseSpec:
    """Return the house without the pieces of furniture whose sides are all at most `SMALL_M` long.

    The house has to list all its furniture.
    """
    pieces = [piece for storey in spec.storeys for piece in storey.furniture or ()]
    return keep_furniture(spec, {piece.id for piece in pieces if max(piece.size_m) > SMALL_M})


def _unfurnished(spec: HouseSpec) -> HouseSpec:
    """Return the house without its list of furniture, so that `build_house` places furniture beside the new doors."""
    return by_storey(spec, lambda storey: {"furniture": None})


def _closed(spec: HouseSpec) -> HouseSpec | None:
    """Return the house with openness 0: doors replace all wider openings.

    None if the walls are too short for doors, or if a door would open into listed furniture.
    """
    try:
        closed = variant(spec, openness=0.0)
        built_and_checked(closed)
    except WorldsError:
        return None
    return closed
