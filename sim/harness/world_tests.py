"""`worlds`: the decorator that runs a test on fresh houses, and the random choice of these houses.

The decorator stores its arguments on the test, where the pytest plugin (`sim.pytest_plugin`) reads them. This module loads
nothing heavy: while pytest collects tests, houses are names and seeds, and they are built when a test runs.
"""

import hashlib
import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import wraps
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Literal, ParamSpec, Protocol, TypeVar, get_args, runtime_checkable

from sim.errors import SimError
from sim.fidelity import ENCODERS_ON_FEATURES, ORACLE, may_be_imitated
from sim.number_checks import check_count
from sim.odometry.config import ODOMETRY_PRESETS
from worlds.floor_plans.preset_names import MAX_ROOMS_ASKED, MAX_STOREYS_ASKED, MIN_ROOMS_ASKED, PRESETS
from worlds.valid_names import did_you_mean

if TYPE_CHECKING:
    from sim.faults import Fault
    from sim.harness.scenario import Scenario

TestFidelity = Literal["layout", "features", "render"]
"""What a test checks. layout: houses only. features, render: runs of this fidelity (`sim.fidelity.Fidelity`)."""
TEST_FIDELITIES: tuple[TestFidelity, ...] = get_args(TestFidelity)
ATTRIBUTE = "lexis_worlds"
"""Attribute of a decorated test that holds its `WorldFamily`."""
HOUSE_SEEDS = 1_000_000
"""Fresh houses have seeds below this number. Seeds from this number upwards are reserved for acceptance tests."""
MOST_WORLDS = 10_000
FEATURES_FRAME_RATE_HZ, RENDER_FRAME_RATE_HZ = 2.0, 10.0
"""Default frame rates of runs with fidelity "features" and "render" [Hz]. Only landmarks need a high rate, and LEXIS
triangulates no landmarks on features."""
SCENARIO = "scenario.json"
"""File of a run, of a failure or of a crash: what was run. It identifies the folder of a failed test."""
TEST_REPLAY = "test_replay.py"
"""File with a test that replays the failure of its folder."""
_NOT_IN_NAMES = re.compile(r"[^\w.]+")
WITH_PARAMETERS = "+"
"""Character between a test's name and its parameters in the name of a failure folder. `slug_of` never returns it."""
_LONGEST_NAME = 110
"""Most characters of a name in the name of a failure folder. Two names and a hash fit into the 255 bytes that file systems
allow for the name of a folder."""
_Test = TypeVar("_Test", bound=Callable[..., object])
_Arguments = ParamSpec("_Arguments")
_Decorator = TypeVar("_Decorator")


@runtime_checkable
class World(Protocol):
    """Interface of a named scenario that is built on demand."""

    @property
    def name(self) -> str:
        """Short and stable name of the world, which pytest appends to the test's name."""

    def scenario(self) -> "Scenario":
        """Build the scenario. Raises `SimError` or `worlds.WorldsError`."""


def usual_rate_hz(fidelity: TestFidelity) -> float:
    """Return the default frame rate of runs of this fidelity [Hz]."""
    return RENDER_FRAME_RATE_HZ if fidelity == "render" else FEATURES_FRAME_RATE_HZ


@dataclass(frozen=True)
class WorldFamily:
    """What a test requires of its houses and runs: the arguments of the decorator `worlds`; see its docstring."""

    presets: tuple[str, ...]
    openness: tuple[float, float] | None
    storeys: int | None
    max_rooms: int | None
    n: int
    fidelity: TestFidelity
    plans: bool
    length_m: float | None
    frame_rate_hz: float
    odometry: str
    encoder: str
    faults: tuple["Fault", ...]

    def draw(self, seed: int, index: int) -> "FreshWorld":
        """Draw the world with number `index` for a seed. Tests with equal requirements get equal worlds.

        The random numbers are hashes of seed and index instead of a numpy Generator's, because collecting tests loads no
        numpy.
        """

        def share(what: str) -> float:
            digest = hashlib.sha256(f"{seed}/{index}/{what}".encode()).digest()
            return int.from_bytes(digest[:6], "big") / 2**48

        openness, rooms = None, None
        if self.openness is not None:
            low, high = self.openness
            openness = min(max(round(low + (high - low) * share("openness"), 3), low), high)
        if self.max_rooms is not None:
            fewest = min(self.max_rooms, max(3, 2 * (self.storeys or 1)))
            rooms = fewest + math.floor((self.max_rooms - fewest + 1) * share("rooms"))
        preset = self.presets[index % len(self.presets)]
        return FreshWorld(self, index, preset, math.floor(HOUSE_SEEDS * share("house")), openness, rooms)


@dataclass(frozen=True)
class FreshWorld:
    """Preset, seed and properties of a house that was drawn for a test, with the run that the test requires in it."""

    family: WorldFamily
    index: int
    preset: str
    seed: int
    openness: float | None
    rooms: int | None

    @property
    def name(self) -> str:
        """Preset and seed, such as "home-4711"."""
        return f"{self.preset}-{self.seed}"

    def scenario(self) -> "Scenario":
        """Generate the house, and return the scenario.

        The scenario contains the house, so that a stored failure stays the same when the generator of houses changes.
        """
        from sim.harness.run_settings import TOUR_LENGTH_M
        from sim.harness.scenario import Scenario
        from sim.harness.walk import with_walk_m
        from worlds.presets import sample_house

        family = self.family
        house = sample_house(self.preset, self.seed, openness=self.openness, rooms=self.rooms, storeys=family.storeys)
        usual_m = TOUR_LENGTH_M.get(self.preset) if self.rooms is None else None
        scenario = Scenario(
            house=house,
            seed=self.seed,
            length_m=usual_m,
            frame_rate_hz=family.frame_rate_hz,
            odometry=family.odometry,
            fidelity="render" if family.fidelity == "render" else "features",
            encoder=family.encoder,
            faults=family.faults,
        )
        return scenario if family.length_m is None else with_walk_m(scenario, family.length_m)


@dataclass(frozen=True)
class StoredWorld:
    """A scenario that was stored in a file, such as the scenario of an earlier failure."""

    file: Path
    name: str

    def scenario(self) -> "Scenario":
        """Read the scenario from the file."""
        from sim.harness.scenario import Scenario

        return Scenario.load(self.file)


def slug_of(name: str) -> str:
    """Convert a test's name for use in a folder's name: "tests/test_a.py::test_b" becomes "tests-test_a-test_b"."""
    return _NOT_IN_NAMES.sub("-", name.replace(".py::", "-"))[-_LONGEST_NAME:].strip("-.")


def stored_failures(out: Path, name: str) -> list[StoredWorld]:
    """Return the scenarios of a test's earlier failures, each once, sorted by the names of the failure folders.

    Failures with any parameters of the test are included.
    """
    pattern = re.compile(re.escape(slug_of(name)) + rf"(?:{re.escape(WITH_PARAMETERS)}.+)?-([0-9a-f]{{16}})")
    folders = sorted(out.iterdir()) if out.is_dir() else []
    matches = [(folder / SCENARIO, pattern.fullmatch(folder.name)) for folder in folders]
    files = {match[1]: file for file, match in matches if match and file.is_file()}
    return [StoredWorld(file, f"failed-{scenario[:8]}") for scenario, file in files.items()]


def _with_known_arguments(decorator: Callable[_Arguments, _Decorator]) -> Callable[_Arguments, _Decorator]:
    """Let a call of a decorator raise `SimError` for an argument by position, and for a name that the decorator lacks.

    Tracebacks of pytest do not show the lines of the decorator, but end with the user's line.
    """
    valid = list(signature(decorator).parameters)

    @wraps(decorator)
    def checked(*args: _Arguments.args, **kwargs: _Arguments.kwargs) -> _Decorator:
        __tracebackhide__ = True
        name = decorator.__name__
        if args:
            write = f"@{name}()" if callable(args[0]) else f"such as @{name}({valid[0]}={args[0]!r:.60})"
            raise SimError(f"{name} takes keyword arguments; write {write}")
        if unknown := [word for word in kwargs if word not in valid]:
            guess = did_you_mean(unknown[0], valid)
            raise SimError(f"{name}: no argument {unknown[0]!r:.60}{guess}; valid: {', '.join(valid)}")
        try:
            return decorator(*args, **kwargs)
        except SimError as error:
            raise error.with_traceback(None) from None

    return checked


@_with_known_arguments
def worlds(
    *,
    presets: Sequence[str] = ("home",),
    openness: float | tuple[float, float] | None = None,
    storeys: int | None = None,
    max_rooms: int | None = None,
    n: int = 10,
    fidelity: TestFidelity = "features",
    plans: bool | None = None,
    length_m: float | None = None,
    frame_rate_hz: float | None = None,
    odometry: str = "multicam",
    encoder: str = "mini",
    faults: "str | Fault | Sequence[str | Fault]" = (),
) -> Callable[[_Test], _Test]:
    """Decorate a test to run on fresh houses, drawn by the seed `--lexis-seed`; the test takes the fixture `run` or `house`.

    Args:
        presets: families of houses, taken in turn.
        openness: share of the inner walls that is open, or the two ends of a range from which the share is drawn; None: as
            the preset draws it.
        storeys: number of storeys; None: as the preset draws it.
        max_rooms: greatest number of rooms, to which corridors, halls and stairs are added; None: as the preset draws it.
        n: number of houses.
        fidelity: "features" and "render" say what the SLAM gets (see `Scenario.fidelity`); with "layout" no SLAM runs.
        plans: whether a robot drives the plans of the SLAM; None: with fidelity "render" only.
        length_m: length of the tour [m]. If the shortest tour through all rooms is longer, the tour has that length. None:
            140 m for the preset home without `max_rooms`, otherwise the shortest tour through all rooms.
        frame_rate_hz: observations per second [Hz]; None: 10 with fidelity "render", otherwise 2.
        odometry: how the odometry drifts: a key of `sim.odometry.ODOMETRY_PRESETS`.
        encoder: the vision-language model; see `Scenario.encoder`.
        faults: one or more faults in the order in which they act: text in the notation of the command line, such as
            "kidnap:20,skip_s=5", or objects; see `sim.faults`.

    Raises:
        SimError: an argument is not valid.
    """
    _check_names("presets", presets, PRESETS)
    _check_names("fidelity", (fidelity,), TEST_FIDELITIES)
    check_count("worlds: n", n, 1, MOST_WORLDS)
    if storeys is not None:
        check_count("worlds: storeys", storeys, 1, MAX_STOREYS_ASKED)
    if max_rooms is not None:
        check_count("worlds: max_rooms", max_rooms, max(MIN_ROOMS_ASKED, storeys or 1), MAX_ROOMS_ASKED)
    if not isinstance(plans, bool | None):
        raise SimError(f"worlds: plans is {plans!r:.60}; valid: True or False")
    _check_positive("length_m", length_m, "metres")
    _check_positive("frame_rate_hz", frame_rate_hz, "hertz")
    if odometry not in ODOMETRY_PRESETS:
        guess = did_you_mean(str(odometry), ODOMETRY_PRESETS)
        raise SimError(f"worlds: unknown odometry {odometry!r:.60}{guess}; valid: {', '.join(ODOMETRY_PRESETS)}")
    _check_encoder(encoder, fidelity)
    driven = fidelity == "render" if plans is None else plans
    family = WorldFamily(
        tuple(presets), _range(openness), storeys, max_rooms, n, fidelity, driven, length_m,
        frame_rate_hz or usual_rate_hz(fidelity), odometry, encoder, _faults(faults, fidelity),
    )  # fmt: skip

    def decorate(test: _Test) -> _Test:
        __tracebackhide__ = True
        if isinstance(test, type) or not callable(test):
            raise SimError(f"worlds: decorates {test!r:.60}; valid: a test function")
        if hasattr(test, ATTRIBUTE):
            raise SimError(f"worlds: {test.__name__} is decorated twice; valid: one @worlds with several presets")
        setattr(test, ATTRIBUTE, family)
        return test

    return decorate


def _check_names(argument: str, names: object, valid: Sequence[str]) -> None:
    if isinstance(names, str) or not isinstance(names, Sequence) or not names:
        raise SimError(f"worlds: {argument} is {names!r:.60}; valid: a tuple with some of {', '.join(valid)}")
    for name in names:
        if name not in valid:
            guess = did_you_mean(str(name), valid)
            raise SimError(f"worlds: unknown {argument} {name!r:.60}{guess}; valid: {', '.join(valid)}")


def _range(openness: object) -> tuple[float, float] | None:
    if openness is None:
        return None
    ends = tuple(openness) if isinstance(openness, tuple | list) else (openness, openness)
    match ends:
        case (int() | float() as low, int() | float() as high) if 0.0 <= low <= high <= 1.0 and bool not in map(type, ends):
            return float(low), float(high)
    raise SimError(f"worlds: openness is {openness!r:.60}; valid: a number in [0, 1], or two of them in ascending order")


def _check_positive(argument: str, value: object, unit: str) -> None:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if value is not None and not (number and 0.0 < value < math.inf):  # type: ignore[operator]
        raise SimError(f"worlds: {argument} is {value!r:.60}; valid: a number of {unit} greater than 0")


def _check_encoder(encoder: object, fidelity: TestFidelity) -> None:
    """Raise `SimError` for an encoder that cannot be used with this fidelity.

    The names of open_clip are not checked, because loading open_clip takes seconds.
    """
    if not isinstance(encoder, str) or not encoder:
        raise SimError(f"worlds: encoder is {encoder!r:.60}; valid: a name, such as 'mini'")
    if fidelity == "render":
        if encoder == ORACLE:
            raise SimError(
                f"worlds: encoder {ORACLE!r} is told the truth and sees no images; valid: with fidelity 'features'"
            )
    elif not may_be_imitated(encoder):
        guess = did_you_mean(encoder, ENCODERS_ON_FEATURES)
        valid = f"{', '.join(ENCODERS_ON_FEATURES)}; other encoders with fidelity 'render'"
        raise SimError(f"worlds: encoder is {encoder!r:.60}{guess}; valid with fidelity {fidelity!r}: {valid}")


def _faults(given: object, fidelity: TestFidelity) -> tuple["Fault", ...]:
    """Return the faults as objects. Raises `SimError` for an unknown fault, or one that needs images and gets none.

    Only tests with faults import the faults, and the modules that compute with images, while pytest collects them.
    """
    if isinstance(given, Sequence) and len(given) == 0 and given != "":
        return ()
    from sim.faults import Fault, parse_fault
    from sim.harness.scenario import Scenario

    faults = tuple(given) if isinstance(given, Iterable) and not isinstance(given, str) else (given,)
    for fault in faults:
        if not isinstance(fault, str | Fault):
            valid = "faults, or texts such as 'kidnap:20,skip_s=5'"
            raise SimError(f"worlds: faults has {fault!r:.60}; valid: {valid}")
    try:
        parsed = tuple(parse_fault(fault) if isinstance(fault, str) else fault for fault in faults)
        Scenario(fidelity="render" if fidelity == "render" else "features", faults=parsed)
    except SimError as error:
        raise SimError(f"worlds: {error}") from None
    return parsed
