"""`replay`: what the file test_replay.py in the folder of a failure calls to run the failed test of the user again."""

import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree import ElementTree

import pytest


def replay(folder: Path, test: str, options: Sequence[str] = ()) -> None:
    """Run a test in a pytest session of its own on the scenario in `folder`; fail with the text of its failure.

    If the test is skipped, with all its parameters, the calling test is skipped, too.

    `test` is the name of the test, such as "tests/test_slam.py::test_rooms", and `options` are further options of pytest.
    The session runs in the folder that holds the file of the test. This folder is sought among the parents of `folder` and
    of the current folder.
    """
    folder, file = folder.resolve(), test.partition("::")[0]
    places = [*folder.parents, Path.cwd(), *Path.cwd().parents]
    top = next((place for place in places if (place / file).exists()), None)
    if top is None:
        problem = f"{file} is not found from {folder}; valid: a place below the folder that holds the file"
        pytest.fail(problem, pytrace=False)
    command = [sys.executable, "-m", "pytest", test, *options]
    command += ["--lexis-replay", str(folder), "--lexis-out", str(folder.parent)]
    with TemporaryDirectory(prefix="lexis-replay-") as work:
        report = Path(work) / "report.xml"
        done = subprocess.run([*command, f"--junitxml={report}"], cwd=top, capture_output=True, text=True, errors="replace")
        if done.returncode == pytest.ExitCode.USAGE_ERROR and f"not found: {top / test}" in done.stderr:
            pytest.fail(f"{test} does not exist any more; if it was renamed, delete the folder {folder}", pytrace=False)
        if done.returncode != 0:
            pytest.fail("\n".join(_failures(report)) or done.stdout + done.stderr, pytrace=False)
        reasons = _skips(report)
        if reasons and len(reasons) == len(list(_outcomes(report, "testcase"))):
            pytest.skip(f"the test was skipped, so that nothing was replayed: {'; '.join(reasons)}")


def _failures(report: Path) -> list[str]:
    """Return the texts of all failures and errors in a JUnit report; none without a report."""
    return [found.text.rstrip() for tag in ("failure", "error") for found in _outcomes(report, tag) if found.text]


def _skips(report: Path) -> list[str]:
    """Return why tests in a JUnit report were skipped. Tests that are expected to fail count as run."""
    return [found.get("message", "") for found in _outcomes(report, "skipped") if found.get("type") == "pytest.skip"]


def _outcomes(report: Path, tag: str) -> Iterator[ElementTree.Element]:
    return ElementTree.parse(report).iter(tag) if report.is_file() else iter(())
