"""Grades a suite, by default `pr`, on a planted bug: whether the suite finds the bug, by which check, and how soon.

LEXIS runs in another process, with the changed copy first on Python's path. The suite sees it as a black box; LEXIS's own
tests play no part.
"""

import hashlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from lexis.errors import one_line
from sim.bench.mutation.planting import Mutant, mutated_copy
from sim.errors import SimError
from sim.harness.crash import COMPLETES
from sim.processes import ONE_THREAD
from sim.suites.suite_means import name_of_mean
from sim.verdicts import load_results

COMPARED = "worse than before"
"""Beginning of `Grade.caught_by` for a mutant that passes the suite, but has worse figures than unchanged LEXIS."""
_HANGS = "the suite does not end"
_ENDS = "the suite ends with status"
"""`Grade.caught_by` begins with one of these two texts for a suite that ended without verdicts."""
_CANNOT_RUN = 2
"""Exit status of `lexis-sim check` if it cannot check the SLAM."""
_MOST_S = 3600.0
_RUNNING: set[subprocess.Popen[str]] = set()
"""The commands that check mutants at this moment."""


@dataclass(frozen=True)
class Grade:
    """Whether and how a suite found one mutant."""

    mutant: str
    suite: str
    """Name of the suite."""
    seed: int
    caught_by: str | None
    """The first check of the suite that failed. If no check failed, the name of a mean that is too bad, or `COMPARED` and
    what became worse. If the suite did not end as usual, how it ended. None if the suite found nothing."""
    scenarios: int
    """Number of scenarios that were examined."""
    seconds: float
    """Wall time until the suite wrote its verdicts, or ended without them [s]."""
    measured: str
    """What the failing check measured in its first failing scenario. If no check failed, the means that are too bad, the
    figures that are worse than those of unchanged LEXIS, or the error output of the suite."""
    smallest: str = ""
    """Size of the smallest scenario in which the check fails, such as "2 rooms, 4 m"; "" if there is none."""
    blamed: str = ""
    """The replacement that makes the failure in the smallest scenario disappear, such as "mended by: perfect odometry."; ""
    if there is no such scenario, or if the failing check is a law instead of a claim about figures."""
    also: tuple[str, ...] = ()
    """The other checks that fail by then. The scenario in which the first check fails is evaluated by all checks of its
    part."""
    changed: int | None = None
    """Number of scenarios in which any figure differs from that of unchanged LEXIS, if no check finds the mutant. With 0,
    the mutant is equivalent to LEXIS on these scenarios. None if LEXIS's results are not given."""
    searched: bool = False
    """Whether the smallest scenario was searched."""
    fingerprint: str = ""
    """`Mutant.fingerprint`, so that a grade of another LEXIS is not taken for one of this LEXIS; "" for unchanged LEXIS."""
    against: str = ""
    """Hash of the results of unchanged LEXIS with which the figures were compared; "" without a comparison."""

    @property
    def is_caught(self) -> bool:
        """Whether the suite found the mutant."""
        return self.caught_by is not None

    def says(self, smallest: bool, against: str) -> bool:
        """Return whether the grade answers what is asked.

        Args:
            smallest: whether the smallest scenario is asked for.
            against: hash of the results with which figures are to be compared; "" for none. A mutant that a check has caught
                needs no comparison.
        """
        if smallest and not self.searched:
            return False
        if self.caught_by is not None and not self.caught_by.startswith(COMPARED):
            return True
        return self.against == against or (not against and self.caught_by is None)


def grade(
    mutant: Mutant | None,
    seed: int = 0,
    suite: str = "pr",
    workers: int | None = None,
    laws: bool = True,
    smallest: bool = True,
    before: Path | None = None,
) -> Grade:
    """Plant a mutant into LEXIS, and check the changed LEXIS by a suite that stops at the first failure.

    The mutant is caught if a check or a mean over all scenarios fails, if a figure is worse than in `before`, or if the
    suite ends without verdicts because LEXIS hangs or aborts.

    Args:
        mutant: the mutant. If it is None, LEXIS stays unchanged, and a failing check is a false alarm.
        seed: the seed of the suite.
        suite: the name of the suite.
        workers: the number of worker processes; None for the default of `lexis-sim check`.
        laws: whether the suite checks laws as well as claims about figures.
        smallest: whether the smallest scenario in which the check fails is searched. The time of the grade does not include
            this search.
        before: a file with verdicts on unchanged LEXIS. If the suite finds nothing, its figures are compared with these.

    Raises `SimError` if the suite cannot check unchanged LEXIS, if the text that the mutant replaces is not in LEXIS, or if
    the suite cannot run for another reason than LEXIS, for example because `before` has none of its scenarios.
    """
    begin = time.time()  # wall-clock time, because it is compared with the time of the file of verdicts
    start = "unchanged" if mutant is None else mutant.name, suite if laws else f"{suite} without laws", seed
    fingerprint = "" if mutant is None else mutant.fingerprint
    with mutated_copy(mutant) as folder:
        verdicts = folder / "verdicts.json"
        options = ["--suite", suite, "--seed", str(seed), "-x", "--json", str(verdicts)]
        options += ["--out", str(folder / "smallest")] if smallest else []
        options += [] if workers is None else ["--workers", str(workers)]
        options += [] if laws else ["--no-laws"]
        options += [] if before is None else ["--against", str(before)]
        status, shown, errors = _check(folder, options)
        if verdicts.exists():
            data = json.loads(verdicts.read_text(encoding="utf-8"))
            graded = _graded(start, data, shown, verdicts.stat().st_mtime - begin)
            graded = replace(graded, searched=smallest, fingerprint=fingerprint)
            if before is None or any(check["outcome"] == "fails" for check in data["checks"]):
                return graded
            return replace(graded, changed=_changed(_stored(before), data["results"]), against=hash_of(before))
        seconds = time.time() - begin
    how = _HANGS if status is None else f"{_ENDS} {status}"
    if mutant is None or status == _CANNOT_RUN:
        what = "unchanged LEXIS" if mutant is None else f"mutant {mutant.name!r}"
        raise SimError(f"{what}: {how}: {one_line(errors, 300)}; valid: a suite that LEXIS completes")
    return Grade(*start, how, 0, seconds, one_line(errors, 160), searched=smallest, fingerprint=fingerprint)


def hash_of(file: Path | None) -> str:
    """Return the hash of a file of results, as grades hold it; "" without a file."""
    return "" if file is None else hashlib.sha256(file.read_bytes()).hexdigest()[:16]


def end_suites() -> None:
    """End all suites that `grade` is running in any thread. Each of these calls returns soon, and its grade is void."""
    for process in tuple(_RUNNING):
        _kill(process)


def write_grade(grade: Grade, file: Path) -> None:
    """Append a grade to a file, so that a grading that is interrupted can go on from there."""
    with file.open("a", encoding="utf-8") as lines:
        lines.write(json.dumps(asdict(grade)) + "\n")


def read_grades(file: Path) -> list[Grade]:
    """Return the grades in a file, or none if the file does not exist. Raises `SimError` for a line that is no grade."""
    grades = []
    try:
        lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    except (OSError, UnicodeDecodeError) as error:
        why = one_line(error, 160)
        raise SimError(f"{file}: cannot be read: {why}; valid: a file that this benchmark has written") from None
    for number, line in enumerate(lines, 1):
        try:
            data = json.loads(line)
            grades.append(Grade(**data | {"also": tuple(data.get("also", ()))}))
        except (AttributeError, TypeError, ValueError):
            raise SimError(f"{file}: line {number} is no grade; valid: a file that this benchmark has written") from None
    return grades


def usable_grades(
    grades: Iterable[Grade], mutants: Iterable[Mutant], suite: str, seed: int, smallest: bool, before: Path | None
) -> dict[str, Grade]:
    """Return the grades that need not be made again, by mutant. The last usable grade of each mutant counts.

    The other arguments are those of `grade`; grades of other mutants, suites or seeds are left out.
    """
    now, against = {(mutant.name, suite, seed, mutant.fingerprint) for mutant in mutants}, hash_of(before)
    return {
        each.mutant: each
        for each in grades
        if (each.mutant, each.suite, each.seed, each.fingerprint) in now and each.says(smallest, against)
    }


def markdown_table(grades: Sequence[Grade]) -> str:
    """Return the grades as a table in Markdown, one row for each mutant."""
    head = "| mutant | caught by | scenarios | seconds | smallest scenario | blame |\n|---|---|---|---|---|---|"
    rows = (
        f"| {grade.mutant} | {grade.caught_by or _missed(grade)} | {grade.scenarios} | {grade.seconds:.0f} "
        f"| {grade.smallest} | {grade.blamed} |"
        for grade in grades
    )
    return "\n".join([head, *rows])


def counts(grades: Sequence[Grade]) -> str:
    """Return in one line how many mutants were found, and how."""
    compared = sum(str(grade.caught_by).startswith(COMPARED) for grade in grades)
    aborted = sum(str(grade.caught_by).startswith((_HANGS, _ENDS)) for grade in grades)
    checked = sum(grade.is_caught for grade in grades) - compared - aborted
    equivalent = sum(not grade.is_caught and grade.changed == 0 for grade in grades)
    passed = sum(not grade.is_caught for grade in grades) - equivalent
    return (
        f"of {len(grades)} mutants, {checked} are caught by a check, {aborted} abort without verdicts, and {compared} are "
        f"caught by the comparison with unchanged LEXIS; {passed} pass, and {equivalent} change no figure"
    )


def _missed(grade: Grade) -> str:
    """Return what the table says of a mutant that is not caught."""
    if grade.changed is None:
        return "**not caught**"
    return "equivalent: no figure differs" if grade.changed == 0 else f"**not caught**; figures of {grade.changed} differ"


def _stored(before: Path) -> list[dict[str, Any]]:
    """Return stored results as plain data, as JSON has them."""
    return list(json.loads(json.dumps([result.data() for result in load_results(before)])))


def _changed(before: Sequence[Mapping[str, Any]], after: Sequence[Mapping[str, Any]]) -> int:
    """Return in how many scenarios any figure differs between two lists of results; times and versions are no figures."""
    first, second = (
        {each["scenario"]: {name: each[name] for name in each.keys() - {"time", "versions"}} for each in results}
        for results in (before, after)
    )
    common = first.keys() & second.keys()
    if not common:
        raise SimError("the results of unchanged LEXIS are of other scenarios; valid: those of the same suite and seed")
    return sum(first[scenario] != second[scenario] for scenario in common)


def _check(folder: Path, options: list[str]) -> tuple[int | None, str, str]:
    """Run `lexis-sim check` on the copy of LEXIS in `folder`, in a process group of its own.

    Returns the exit status (None if the command was stopped after `_MOST_S` seconds), the output and the error output.
    """
    path = os.pathsep.join([str(folder), *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-P", "-m", "sim", "check", *options]  # -P: the current folder is not on the path
    environment = os.environ | ONE_THREAD | {"PYTHONPATH": path}
    process = subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    _RUNNING.add(process)
    try:
        shown, errors = process.communicate(timeout=_MOST_S)
        return process.returncode, shown, errors
    except subprocess.TimeoutExpired:
        return None, "", ""
    finally:
        _RUNNING.discard(process)
        _kill(process)
        process.wait()


def _kill(process: subprocess.Popen[str]) -> None:
    """Kill a process and its worker processes, which are in its process group."""
    with suppress(ProcessLookupError, PermissionError):  # macOS forbids it for a group that has ended
        os.killpg(process.pid, signal.SIGKILL)


def _graded(start: tuple[str, str, int], data: Mapping[str, Any], shown: str, seconds: float) -> Grade:
    """Make the grade of a mutant for which the suite ran to its end.

    `start` holds the mutant, the suite and the seed. `data` holds the verdicts of the suite. `shown` is what the command
    printed; the size of the smallest failing scenario, and what mends the failure, are read from it.
    """
    failed = [check for check in data["checks"] if check["outcome"] == "fails"]
    scenarios = len(data["results"]) + sum(len(check["failures"]) for check in data["checks"] if check["check"] == COMPLETES)
    means = [mean["claim"] for mean in data["means"] if mean["outcome"] == "fails"]
    if means and not failed:
        return Grade(*start, name_of_mean(means[0]), scenarios, seconds, ", ".join(means))
    if not failed:
        worse = data["worse"]
        return Grade(*start, f"{COMPARED}: {worse[0]}" if worse else None, scenarios, seconds, ", ".join(worse))
    name, *also = (f"{check['part']}: {check['check']}" for check in failed)
    measured = failed[0]["failures"][0]["measured"]
    found = re.search(rf"^{re.escape(name)}: .* -> (.*)\n *(.*)$", shown, re.MULTILINE)
    caught = Grade(*start, name, scenarios, seconds, measured, also=tuple(also))
    if found is None:
        return caught
    blamed = "" if found[2].startswith("replay:") else found[2]  # the smallest scenario of a law can only be replayed
    return replace(caught, smallest=found[1], blamed=blamed)
