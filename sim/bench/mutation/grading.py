"""`grade`: whether, by which check and how soon the suite `pr` finds a planted bug.

LEXIS runs in another process, with the changed copy first on Python's path. The suite sees it as a black box; LEXIS's own
tests play no part.
"""

import json
import os
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sim.bench.mutation.planting import Mutant, planted
from sim.errors import SimError

_FAILED = 1
"""Exit status of `lexis-sim check` if a check fails."""
_MOST_S = 3600.0


@dataclass(frozen=True)
class Grade:
    """How the suite fared with one mutant."""

    mutant: str
    caught_by: str | None
    """The check that failed first; None if the suite found nothing."""
    scenarios: int
    """Number of scenarios that were examined."""
    seconds: float
    """Wall time [s]."""
    measured: str
    """What the failing check measured in its first failing scenario."""

    @property
    def is_caught(self) -> bool:
        """Whether a check failed."""
        return self.caught_by is not None


def grade(mutant: Mutant | None, seed: int = 0, suite: str = "pr", workers: int | None = None) -> Grade:
    """Check LEXIS with a mutant by a suite that stops at the first failure. Raises `SimError` if the suite cannot run.

    None as the mutant stands for unchanged LEXIS, in which a check that fails is a false alarm.
    """
    begin = time.perf_counter()
    name = "unchanged" if mutant is None else mutant.name
    with planted(mutant) as folder:
        verdicts = folder / "verdicts.json"
        options = ["--suite", suite, "--seed", str(seed), "-x", "--json", str(verdicts)]
        options += [] if workers is None else ["--workers", str(workers)]
        ended = _check(folder, options)
        if ended.returncode not in (0, _FAILED) or not verdicts.exists():
            raise SimError(f"mutant {name!r}: the suite ended with status {ended.returncode}: {ended.stderr[-300:]}")
        data = json.loads(verdicts.read_text())
    return _graded(name, data, time.perf_counter() - begin)


def _check(folder: Path, options: list[str]) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(folder), *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-P", "-m", "sim.cli", "check", *options]  # -P: the current folder is not on the path
    return subprocess.run(
        command, env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True, timeout=_MOST_S, check=False
    )


def _graded(name: str, data: dict[str, Any], seconds: float) -> Grade:
    failed = [check for check in data["checks"] if check["outcome"] == "fails"]
    scenarios = len(data["results"]) + sum(
        len(check["failures"]) for check in data["checks"] if check["check"] == "the run completes"
    )
    if not failed:
        return Grade(name, None, scenarios, seconds, "")
    first = failed[0]
    return Grade(name, f"{first['part']}: {first['check']}", scenarios, seconds, first["failures"][0]["measured"])
