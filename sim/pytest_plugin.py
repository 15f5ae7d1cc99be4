"""The pytest plugin: tests that are decorated with `sim.harness.worlds` run a SLAM in fresh simulated houses.

A user overrides the fixture `slam`; the fixture `run` is the `RunResult` of the SLAM in one house. A failed test leaves a
folder that replays the failure. pytest loads this module at every start, so it loads nothing heavy until a test needs it.
"""

import argparse
import re
import secrets
import shlex
import time
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from itertools import count
from os.path import relpath
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from _pytest.runner import runtestprotocol

from sim.errors import SimError
from sim.harness.world_tests import (
    ATTRIBUTE,
    SCENARIO,
    TIERS,
    FreshWorld,
    StoredWorld,
    World,
    WorldFamily,
    stored_failures,
)

if TYPE_CHECKING:
    from sim.harness.failed_test import FinishedRun
    from sim.harness.failure_signature import Signature
    from sim.harness.results import RunResult
    from sim.harness.scenario import Scenario
    from sim.harness.slam_under_test import SlamUnderTest
    from worlds.house import House

DEFAULT_SEED = 7
PROFILES = ("lexis-pr", "lexis-nightly")
_UNITS_S = {"": 1.0, "s": 1.0, "m": 60.0, "h": 3600.0}


@dataclass
class _Attempt:
    """One execution of a decorated test on one scenario, as far as it came."""

    world: World
    scenario: "Scenario | None" = None
    done: float = 0.0
    """Share of the frames that the SLAM has taken."""
    finished: "FinishedRun | None" = None
    failure: "_Failure | None" = None


@dataclass(frozen=True)
class _Failure:
    """An exception, of the test's body or of the SLAM."""

    kind: str
    where: str
    """File and line."""
    statement: str
    message: str


@dataclass(frozen=True)
class _Chosen:
    """A scenario that is at hand, as a `World`."""

    chosen: "Scenario"
    name: str = "chosen"

    def scenario(self) -> "Scenario":
        """Return the scenario."""
        return self.chosen


_ATTEMPT = pytest.StashKey[_Attempt]()
_SEED = pytest.StashKey[int]()
_SHARE_S = pytest.StashKey[float]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options."""
    group = parser.getgroup("lexis", "simulated houses (LEXIS-sim)")
    group.addoption(
        "--lexis-seed",
        type=_seed,
        metavar="N",
        help=f"seed of all houses (default: {DEFAULT_SEED}, or fresh with lexis-nightly)",
    )
    group.addoption(
        "--lexis-profile",
        choices=PROFILES,
        default=PROFILES[0],
        help="lexis-pr: the same houses every time. lexis-nightly: fresh houses every time, and stored failures first "
        "(default: %(default)s)",
    )
    group.addoption(
        "--lexis-budget",
        type=_duration_s,
        metavar="TIME",
        help="go on with further houses inside every test until all tests together have used this time: 90s, 5m or 1h",
    )
    group.addoption(
        "--lexis-replay",
        type=Path,
        metavar="PATH",
        help="run on this scenario alone: a scenario file or the folder of a failure",
    )
    group.addoption(
        "--lexis-out",
        type=Path,
        default=Path(".lexis-failures"),
        metavar="DIR",
        help="where the folders of failures are written (default: %(default)s)",
    )
    group.addoption(
        "--lexis-shrink",
        action=argparse.BooleanOptionalAction,
        default=None,
        help="make the scenario of a failure as small as possible (default: yes, unless --lexis-replay is given)",
    )


def _seed(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is no seed; valid: a whole number from 0")
    return int(text)


def _duration_s(text: str) -> float:
    match = re.fullmatch(r"(\d+(?:\.\d+)?)([smh]?)", text)
    if match is None:
        raise argparse.ArgumentTypeError(f"{text!r} is no time; valid: a number with s, m or h, such as 5m")
    return float(match[1]) * _UNITS_S[match[2]]


def pytest_configure(config: pytest.Config) -> None:
    """Register the markers, and decide on the seed, which the workers of xdist get from the process that starts them."""
    for tier in TIERS:
        config.addinivalue_line("markers", f"{tier}: a test in simulated houses, on the tier {tier!r} of LEXIS-sim")
    nightly = config.option.lexis_profile == "lexis-nightly"
    given = getattr(config, "workerinput", {}).get("lexis_seed", config.option.lexis_seed)
    fresh = secrets.randbelow(2**31) if nightly else DEFAULT_SEED
    config.stash[_SEED] = fresh if given is None else given
    if (replayed := _replayed_file(config)) is not None and not replayed.is_file():
        raise pytest.UsageError(
            f"--lexis-replay: {replayed} does not exist; valid: a scenario file or the folder of a failure"
        )


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Tell a worker of xdist the seed: all workers have to collect the same tests."""
    node.workerinput["lexis_seed"] = node.config.stash[_SEED]


def pytest_report_header(config: pytest.Config) -> str:
    """Say how the houses of this session are drawn."""
    seed, profile = config.stash[_SEED], config.option.lexis_profile
    return f"lexis: --lexis-seed {seed} ({profile}), failures go to {config.option.lexis_out}"


def _replayed_file(config: pytest.Config) -> Path | None:
    path: Path | None = config.option.lexis_replay
    if path is None:
        return None
    path = config.invocation_params.dir / path
    return path / SCENARIO if path.is_dir() else path


def _out(config: pytest.Config) -> Path:
    return Path(config.invocation_params.dir / config.option.lexis_out)


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave out the folders of failures, whose tests run if they are named on the command line."""
    return True if collection_path == _out(config) else None


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Turn a decorated test into one test for each of its worlds."""
    family = _family(metafunc.function)
    if family is None:
        return
    if "scenario" not in metafunc.fixturenames:
        name = metafunc.definition.nodeid
        raise pytest.UsageError(
            f"{name} is decorated with @worlds and takes no house; valid: the argument run, house or scenario"
        )
    if family.fidelity == "layout" and "run" in metafunc.fixturenames:
        name = metafunc.definition.nodeid
        raise pytest.UsageError(f"{name}: no SLAM runs with fidelity 'layout'; valid: the argument house instead of run")
    chosen = _worlds_of(family, metafunc.config, metafunc.definition.nodeid)
    mark = getattr(pytest.mark, family.fidelity)
    metafunc.parametrize("scenario", [pytest.param(world, marks=mark, id=world.name) for world in chosen], indirect=True)


def _worlds_of(family: WorldFamily, config: pytest.Config, name: str) -> Sequence[World]:
    if (replayed := _replayed_file(config)) is not None:
        return [StoredWorld(replayed, "replay")]
    stored = stored_failures(_out(config), name) if config.option.lexis_profile == "lexis-nightly" else []
    return [*stored, *(family.draw(config.stash[_SEED], index) for index in range(family.n))]


def _family(function: object) -> WorldFamily | None:
    family = getattr(function, ATTRIBUTE, None)
    return family if isinstance(family, WorldFamily) else None


def _family_of(item: pytest.Item) -> WorldFamily | None:
    return _family(getattr(item, "function", None))


@pytest.fixture
def scenario(request: pytest.FixtureRequest) -> "Scenario":
    """The scenario of a test that is decorated with `worlds`."""
    attempt: _Attempt | None = request.node.stash.get(_ATTEMPT, None)
    if attempt is None:
        raise SimError(f"{request.node.nodeid}: the test has no houses; valid: a test that is decorated with @worlds(...)")
    attempt.scenario = attempt.world.scenario()
    return attempt.scenario


@pytest.fixture
def house(scenario: "Scenario") -> "House":
    """The house of the scenario, built and checked."""
    from sim.harness.parts import house_spec
    from worlds.validation import built_and_checked

    return built_and_checked(house_spec(scenario))


@pytest.fixture
def slam(scenario: "Scenario") -> "SlamUnderTest":
    """The SLAM under test. Override this fixture to test your own; here it is LEXIS."""
    from sim.harness.adapters.lexis import Lexis

    return Lexis(scenario.encoder)


@pytest.fixture
def run(request: pytest.FixtureRequest, scenario: "Scenario", slam: "SlamUnderTest") -> "RunResult":
    """The result of running the SLAM on the scenario."""
    from sim.harness.failed_test import FinishedRun
    from sim.harness.figures import evaluate
    from sim.harness.planning import try_plans
    from sim.harness.runner import run as run_scenario

    attempt = request.node.stash[_ATTEMPT]

    def progress(share: float) -> None:
        attempt.done = share

    finished = run_scenario(scenario, slam, progress)
    family = _family_of(request.node)
    trials = try_plans(finished) if family is not None and family.plans else []
    result = evaluate(finished, trials)
    attempt.finished = FinishedRun(finished, result, trials)
    return result


def pytest_collection_finish(session: pytest.Session) -> None:
    """Share the budget among the decorated tests; workers of xdist run at the same time."""
    budget_s = session.config.option.lexis_budget
    items = sum(_family_of(item) is not None for item in session.items)
    if budget_s is not None and items:
        workers = getattr(session.config, "workerinput", {}).get("workercount", 1)
        session.config.stash[_SHARE_S] = budget_s * workers / items


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
    """Run a decorated test: on its own house, on further ones within the budget, and on smaller ones if it fails."""
    family = _family_of(item)
    if family is None:
        return None
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    reports, attempt = _within_budget(item, nextitem, family)
    if attempt.failure is not None and attempt.scenario is not None:
        _explain(item, nextitem, attempt, next(report for report in reports if report.failed))
    for report in reports:
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


def _within_budget(
    item: pytest.Item, nextitem: pytest.Item | None, family: WorldFamily
) -> tuple[list[pytest.TestReport], _Attempt]:
    """Reports of the first execution that does not pass, or of the last one within the budget."""
    config = item.config
    ends_s = time.monotonic() + config.stash.get(_SHARE_S, 0.0)
    first = _callspec(item).params["scenario"]
    reports, attempt = _attempt(item, nextitem, first)
    if not isinstance(first, FreshWorld):
        return reports, attempt
    for further in count(1):
        if not all(report.passed for report in reports) or time.monotonic() >= ends_s:
            break
        world = family.draw(config.stash[_SEED], first.index + further * family.n)
        reports, attempt = _attempt(item, nextitem, world)
    return reports, attempt


def _callspec(item: pytest.Item) -> Any:
    """The parameters of an item that `pytest_generate_tests` has made."""
    return item.callspec  # type: ignore[attr-defined]


def _attempt(item: pytest.Item, nextitem: pytest.Item | None, world: World) -> tuple[list[pytest.TestReport], _Attempt]:
    """Set up, run and tear down a test with all its fixtures on one world."""
    item._report_sections.clear()  # otherwise what every execution prints piles up
    attempt = item.stash[_ATTEMPT] = _Attempt(world)
    return runtestprotocol(item, log=False, nextitem=nextitem), attempt


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Remember why a decorated test failed."""
    report = yield
    attempt = item.stash.get(_ATTEMPT, None)
    if attempt is not None and report.failed and call.excinfo is not None and call.when != "teardown":
        attempt.failure = _failure(item, call.excinfo)
    return report


def _failure(item: pytest.Item, error: pytest.ExceptionInfo[BaseException]) -> _Failure:
    """The failure with the last line of the user's code that led to it."""
    own = [entry for entry in error.traceback if _is_own(Path(entry.path), item.config.rootpath)]
    entry = own[-1] if own else error.traceback[-1]
    where = f"{relpath(entry.path, item.config.invocation_params.dir)}:{entry.lineno + 1}"
    lines = error.exconly(tryshort=True).splitlines()
    said = next((k for k, line in enumerate(lines) if line.lstrip().startswith("+")), len(lines))
    return _Failure(error.typename, where, " ".join(str(entry.statement).split()), "\n".join(lines[:said]))


def _is_own(path: Path, project: Path) -> bool:
    return path.is_relative_to(project) and "site-packages" not in path.parts


def _explain(item: pytest.Item, nextitem: pytest.Item | None, attempt: _Attempt, report: pytest.TestReport) -> None:
    """Make the scenario of a failure smaller, write the folder, and put what to know into the report."""
    original = attempt.scenario
    if original is not None and _wants_to_shrink(item.config):
        attempt = _shrunk(item, nextitem, attempt, original)
    text = _text(item, attempt, original if original is not attempt.scenario else None)
    if item.config.option.tbstyle == "auto":
        report.longrepr = text
    else:
        report.sections.append(("lexis", text))


def _wants_to_shrink(config: pytest.Config) -> bool:
    """Whether failures are made smaller. Without the option they are, except in a replay; never under a debugger."""
    option: bool | None = config.option.lexis_shrink
    wanted = config.option.lexis_replay is None if option is None else option
    return wanted and not config.option.usepdb


def _shrunk(item: pytest.Item, nextitem: pytest.Item | None, attempt: _Attempt, scenario: "Scenario") -> _Attempt:
    """The same failure in the smallest scenario that the reducer finds."""
    from sim.harness.reducer import reduce

    signature, last = _signature(attempt), attempt

    def fails(candidate: "Scenario") -> "Signature | None":
        nonlocal last
        _, tried = _attempt(item, nextitem, _Chosen(candidate))
        if _signature(tried) == signature:
            last = tried
        return _signature(tried)

    smallest = reduce(scenario, fails).scenario
    return last if last.scenario == smallest or fails(smallest) == signature else attempt


def _signature(attempt: _Attempt) -> "Signature | None":
    """The signature of a failure: the type of the exception and the line that raised it."""
    from sim.harness.failure_signature import Signature

    failure = attempt.failure
    return None if failure is None else Signature("exception", f"{failure.kind} at {failure.where}")


def _text(item: pytest.Item, attempt: _Attempt, original: "Scenario | None") -> str:
    """What the terminal shows of a failure: what failed, where it first went wrong, the folder and the replay."""
    failure, scenario = attempt.failure, attempt.scenario
    if failure is None or scenario is None:
        return ""
    lines = [failure.message, f"    {failure.where}: {failure.statement}"]
    if place := _first_wrong(attempt, scenario):
        lines.append(f"first wrong: {place}")
    try:
        folder = _folder(item, attempt, scenario, original)
    except Exception as error:  # a SLAM's save() raises anything, and the failure of the test must not be lost
        return "\n".join([*lines, f"folder: cannot be written: {type(error).__name__}: {error}"])
    here = item.config.invocation_params.dir
    test = relpath(item.path, here) + "".join(_name(item).partition("::")[1:])
    shown = folder if item.config.option.lexis_out.is_absolute() else Path(relpath(folder, here))
    command = shlex.join(["pytest", *_plugin_options(item.config), test, "--lexis-replay", str(shown)])
    return "\n".join([*lines, f"folder: {shown}", f"replay: {command}"])


def _first_wrong(attempt: _Attempt, scenario: "Scenario") -> str:
    """Room and time of the first error; "" if nothing is known about them."""
    from sim.harness.first_wrong import first_wrong, raised_at

    if attempt.finished is not None:
        return str(first_wrong(attempt.finished.run) or "")
    return str(raised_at(scenario, attempt.done)) if attempt.done else ""


def _folder(item: pytest.Item, attempt: _Attempt, scenario: "Scenario", original: "Scenario | None") -> Path:
    """Write the folder of a failure, unless it is the folder that is being replayed."""
    from sim.harness.failed_test import folder_of, write_failed_test

    folder = folder_of(_out(item.config), _name(item), scenario)
    replayed = attempt.world.file.parent if isinstance(attempt.world, StoredWorld) else None
    if replayed is not None and replayed.name == folder.name:
        return replayed
    write_failed_test(folder, _name(item), _plugin_options(item.config), scenario, attempt.finished, original)
    return folder


def _name(item: pytest.Item) -> str:
    """File and function of a test, without parameters."""
    return item.nodeid.removesuffix(f"[{_callspec(item).id}]")


def _plugin_options(config: pytest.Config) -> list[str]:
    """What loads this plugin where it is not installed."""
    return [] if config.pluginmanager.has_plugin("lexis") else ["-p", __name__]
