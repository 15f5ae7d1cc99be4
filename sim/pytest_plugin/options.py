"""The options of the plugin, and the settings that follow: the seed of all houses, the markers and the failure folders."""

import argparse
import secrets
from pathlib import Path
from typing import Any

import pytest

from sim.durations import duration_s
from sim.harness.world_tests import SCENARIO, TEST_FIDELITIES

DEFAULT_SEED = 7
PROFILES = ("lexis-pr", "lexis-nightly")
MODULE = "sim.pytest_plugin"
SEED = pytest.StashKey[int]()
"""Key under which pytest stores the seed of all houses of the session."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the plugin's command-line options to pytest."""
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
        type=duration_s,
        metavar="TIME",
        help="run each test in further houses, for an equal share of this time: 90s, 5m or 1h",
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
        raise argparse.ArgumentTypeError(f"{text!r:.60}; valid: a whole number from 0")
    return int(text)


def pytest_configure(config: pytest.Config) -> None:
    """Register the markers and choose the seed. Workers of xdist get the seed from the process that starts them."""
    for fidelity in TEST_FIDELITIES:
        config.addinivalue_line(
            "markers", f"{fidelity}: a test in simulated houses, with fidelity {fidelity!r} of LEXIS-sim"
        )
    config.addinivalue_line("markers", "xdist_group(name): pytest-xdist runs the tests of a group in one process")
    nightly = config.option.lexis_profile == "lexis-nightly"
    given = getattr(config, "workerinput", {}).get("lexis_seed", config.option.lexis_seed)
    fresh = secrets.randbelow(2**31) if nightly else DEFAULT_SEED
    config.stash[SEED] = fresh if given is None else given
    if (out := out_folder(config)).exists() and not out.is_dir():
        raise pytest.UsageError(f"--lexis-out: {out} is no folder; valid: the name of a folder, which is made if needed")
    if (replayed := replayed_file(config)) is not None and not replayed.is_file():
        raise pytest.UsageError(
            f"--lexis-replay: {replayed} does not exist; valid: a scenario file or the folder of a failure"
        )


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Send a worker of xdist the seed, because all workers have to collect the same tests, and how many share the tests.

    This number is 1 unless `--dist` is load or worksteal, because other modes may give all tests to one worker.
    """
    shared = node.config.option.dist in ("load", "worksteal")
    node.workerinput["lexis_seed"] = node.config.stash[SEED]
    node.workerinput["lexis_workers"] = node.workerinput["workercount"] if shared else 1


def pytest_report_header(config: pytest.Config) -> str:
    """Return a line for pytest's header with the seed of the random houses and the folder for failures."""
    seed, profile = config.stash[SEED], config.option.lexis_profile
    return f"lexis: --lexis-seed {seed} ({profile}), failures go to {config.option.lexis_out}"


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Collect no tests from the folders of failures, unless they are named on the command line."""
    return True if collection_path.resolve() == out_folder(config).resolve() else None


def replayed_file(config: pytest.Config) -> Path | None:
    """Return the scenario file that `--lexis-replay` names; None without the option."""
    path: Path | None = config.option.lexis_replay
    if path is None:
        return None
    path = config.invocation_params.dir / path
    return path / SCENARIO if path.is_dir() else path


def out_folder(config: pytest.Config) -> Path:
    """Return the folder that holds the folders of all failures."""
    return Path(config.invocation_params.dir / config.option.lexis_out)


def wants_to_shrink(config: pytest.Config) -> bool:
    """Return whether failing scenarios are made smaller: by default yes, except in a replay; never under a debugger."""
    option: bool | None = config.option.lexis_shrink
    wanted = config.option.lexis_replay is None if option is None else option
    return wanted and not config.option.usepdb


def loading_options(config: pytest.Config) -> list[str]:
    """Return the options with which pytest loads this plugin; empty unless the user has loaded the plugin by `-p`."""
    return ["-p", MODULE] if MODULE in config.option.plugins else []
