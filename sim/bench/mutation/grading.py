"""`grade`: whether, by which check and how soon the suite `pr` finds a planted bug.

LEXIS runs in another process, with the changed copy first on Python's path. The suite sees it as a black box; LEXIS's own
tests play no part.
"""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lexis.errors import one_line
from sim.bench.mutation.planting import Mutant, planted
from sim.errors import SimError
from sim.suites.examination import COMPLETES

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
    """Plant a mutant into LEXIS, and check the result by a suite that stops at the first failure.

    The mutant is caught if a check fails, or if LEXIS hangs or aborts. If `mutant` is None, LEXIS stays unchanged, and a
    check that fails is a false alarm. Raises `SimError` if the suite cannot check unchanged LEXIS.
    """
    begin = time.perf_counter()
    name = "unchanged" if mutant is None else mutant.name
    with planted(mutant) as folder:
        verdicts = folder / "verdicts.json"
        options = ["--suite", suite, "--seed", str(seed), "-x", "--json", str(verdicts)]
        options += [] if workers is None else ["--workers", str(workers)]
        status, errors = _check(folder, options)
        seconds = time.perf_counter() - begin
        if status in (0, _FAILED) and verdicts.exists():
            return _graded(name, json.loads(verdicts.read_text()), seconds)
    how = "the suite does not end" if status is None else f"the suite ends with status {status}"
    if mutant is None:
        raise SimError(f"unchanged LEXIS: {how}: {one_line(errors, 300)}; valid: a suite that LEXIS completes")
    return Grade(name, how, 0, seconds, one_line(errors, 160))


def _check(folder: Path, options: list[str]) -> tuple[int | None, str]:
    """Run the command in a process group of its own; return its exit status (None: it was stopped) and its errors."""
    path = os.pathsep.join([str(folder), *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-P", "-m", "sim.cli", "check", *options]  # -P: the current folder is not on the path
    process = subprocess.Popen(
        command, env=os.environ | {"PYTHONPATH": path}, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    )  # fmt: skip
    try:
        errors = process.communicate(timeout=_MOST_S)[1]
        return process.returncode, errors
    except subprocess.TimeoutExpired:
        return None, ""
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)  # its workers, too
        process.wait()


def _graded(name: str, data: dict[str, Any], seconds: float) -> Grade:
    failed = [check for check in data["checks"] if check["outcome"] == "fails"]
    scenarios = len(data["results"]) + sum(len(check["failures"]) for check in data["checks"] if check["check"] == COMPLETES)
    if not failed:
        return Grade(name, None, scenarios, seconds, "")
    first = failed[0]
    return Grade(name, f"{first['part']}: {first['check']}", scenarios, seconds, first["failures"][0]["measured"])
