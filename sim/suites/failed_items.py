"""The folder of a failed item of `slam_checks`, and the replay of the item on the scenario in the folder."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from lexis.errors import one_line
from sim.errors import USER_ERRORS
from sim.harness.failures.failed_test import FailedPytest, folder_of
from sim.harness.scenario import Scenario
from sim.harness.world_tests import TEST_REPLAY
from sim.suites.checks import ClaimCheck, NewSlam
from sim.suites.replay_folder import write_replay_folder
from sim.suites.report import CheckVerdict
from sim.wording import error_text, qualified_name

if TYPE_CHECKING:
    import pytest


def replayed_scenario(item: "pytest.Item") -> Scenario | None:
    """Return the scenario of `--lexis-replay`; None without the option. Raises `SimError` for a file that is no scenario."""
    from sim.pytest_plugin.options import replayed_file  # imports pytest, which is optional

    file = replayed_file(item.config) if _has_plugin(item) else None
    return None if file is None else Scenario.load(file)


def about_failure(item: "pytest.Item", verdict: CheckVerdict, new_slam: NewSlam) -> str:
    """Write the folder of an item whose check fails; return lines with the folder and the commands that use it.

    The folder holds the first scenario in which the check fails, why.md, and a test that replays the failure. Without the
    plugin (`-p no:lexis`), nothing is written or returned. If the folder cannot be written, a line says why.
    """
    from sim.pytest_plugin.explanation import replay_lines, shown_folder
    from sim.pytest_plugin.options import loading_options, out_folder

    if not _has_plugin(item):
        return ""
    scenario = verdict.failures[0].scenario
    folder = folder_of(out_folder(item.config), item.nodeid, scenario)
    try:
        _write(folder, verdict, FailedPytest(item.nodeid, item.nodeid, tuple(loading_options(item.config))))
    except USER_ERRORS as problem:
        return f"\nfolder: cannot be written: {one_line(error_text(problem), 160)}"
    shown = shown_folder(item, folder)
    lines = replay_lines(item, item.nodeid, shown)
    condition = _condition(verdict)
    if condition is not None and isinstance(new_slam, type) and new_slam.__qualname__.isidentifier():
        options = ["--slam", qualified_name(new_slam), "--fails", condition, "-o", "failure"]
        lines.append(f"smallest scenario: {shlex.join(['lexis-sim', 'shrink', str(shown), *options])}")
    return "".join(f"\n{line}" for line in lines)


def _condition(verdict: CheckVerdict) -> str | None:
    """Return the condition by which `lexis-sim shrink` knows the failure; None for laws and invalid estimates."""
    if isinstance(verdict.checked, ClaimCheck):
        return str(verdict.checked.claim.opposite)
    return "crash" if verdict.failures[0].findings[verdict.check].is_crash else None


def _write(folder: Path, verdict: CheckVerdict, test: FailedPytest) -> None:
    first = verdict.failures[0]
    page = (
        f"# {verdict.name}",
        verdict.says,
        f"In this scenario: {first.findings[verdict.check].measured}",
        f"In all scenarios of the part: {str(verdict).splitlines()[0]}",
        f"`pytest {TEST_REPLAY}` in this folder checks this scenario again.",
    )
    write_replay_folder(folder, first.scenario, page, test.replay)


def _has_plugin(item: "pytest.Item") -> bool:
    return hasattr(item.config.option, "lexis_replay")
