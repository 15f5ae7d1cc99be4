"""Results of many runs: writes them to one JSON file, and reads them from such a file or from the folders of the runs."""

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from lexis.errors import one_line
from lexis.files.reading import FileKind, read_json
from lexis.files.replace import replaced_file
from lexis.files.temporary_folder import is_temporary
from sim.errors import SimError
from sim.harness.claims import Claim
from sim.harness.results import RESULT, SCHEMA, RunResult
from sim.verdicts.comparison import Comparison, compare_results

FORMAT = "lexis-results"
_adapter = cache(partial(TypeAdapter, RunResult))
_FILE = FileKind("a file of results, as `lexis-sim check --json` writes it, or result.json of a run", 500_000_000, SimError)


def save_results(results: Sequence[RunResult], path: Path | str) -> None:
    """Write results to one JSON file. Raises `LexisError` if the file cannot be written."""
    with replaced_file(Path(path)) as beside:
        beside.write_text(json.dumps(results_data(results), indent=1) + "\n", encoding="utf-8")


def results_data(results: Sequence[RunResult]) -> dict[str, Any]:
    """Return the contents of a file of results, as `save_results` writes them. A file may have further entries."""
    return {"format": FORMAT, "results": [result.data() for result in results]}


def load_results(path: Path | str) -> tuple[RunResult, ...]:
    """Read the results in a file, or of the run of a folder and of all runs whose folders lie somewhere below it.

    The results are sorted by path. Runs that another process is still writing, or was writing when it was killed, are left
    out.

    Raises `SimError` if there is no result, or if a result is not valid.
    """
    path = Path(path)
    if not path.is_dir():
        return _results_in(path)
    files = sorted(file for file in path.rglob(RESULT) if not is_temporary(file.relative_to(path)))
    if not files:
        raise SimError(
            f"{path}: contains no {RESULT}; valid: the folder of a run, a folder of such folders, or {_FILE.valid}"
        )
    return tuple(result for file in files for result in _results_in(file))


@dataclass(frozen=True)
class SuiteResults:
    """The results of a run of a suite, and the scenarios that it began, some of which may have no result."""

    results: tuple[RunResult, ...]
    begun: frozenset[str] | None = None
    """Hashes of the scenarios that were begun; None if this is not known."""

    @classmethod
    def load(cls, path: Path | str, may_be_empty: bool = False) -> "SuiteResults":
        """Read a file or a folder as `load_results` does. Only files of suites say which scenarios were begun.

        With `may_be_empty`, a suite of which no scenario was completed is not refused.
        """
        path = Path(path)
        if path.is_dir():
            return cls(load_results(path))
        data = read_json(path, _FILE)
        examined = data.get("examined") if isinstance(data, dict) else None
        begun = frozenset(map(str, examined)) if isinstance(examined, list) else None
        if may_be_empty and begun and data.get("format") == FORMAT and data.get("results") == []:
            return cls((), begun)
        return cls(_results_of(data, path), begun)

    def compared_with(
        self, later: "SuiteResults", claims: Sequence[Claim | str] = (), confidence: float = 0.95
    ) -> Comparison | None:
        """Compare the results of a later run with these, as `compare_results` does.

        Scenarios that one of the runs is known not to have begun are left out. This is not known for folders of runs: each
        scenario that only one side has counts against the other there. The result is None if no scenario was completed in
        both runs.
        """
        if not self.completed & later.completed:
            return None
        return compare_results(self.comparable_with(later), later.comparable_with(self), claims, confidence=confidence)

    @property
    def completed(self) -> frozenset[str]:
        """Hashes of the scenarios that have a result."""
        return frozenset(result.scenario for result in self.results)

    @property
    def known(self) -> frozenset[str]:
        """Hashes of the scenarios that were begun, as far as this is known."""
        return self.completed | (self.begun or frozenset())

    def comparable_with(self, other: "SuiteResults") -> tuple[RunResult, ...]:
        """Return the results of this run without those of scenarios that the other run never began.

        A run that stopped early, for example because its budget was used up, thus does not look like one that crashed.
        """
        return tuple(result for result in self.results if other.begun is None or result.scenario in other.begun)


def _results_in(path: Path) -> tuple[RunResult, ...]:
    return _results_of(read_json(path, _FILE), path)


def _results_of(data: Any, path: Path) -> tuple[RunResult, ...]:
    if isinstance(data, dict) and data.get("format") == FORMAT:
        several = data.get("results")
        if not isinstance(several, list):
            raise _FILE.refusal(path, "contains no list of results")
        if not several:
            raise _FILE.refusal(path, "contains no result: no scenario was completed")
        return tuple(_result(each, path, f"results[{i}].") for i, each in enumerate(several))
    return (_result(data, path, ""),)


def _result(data: Any, path: Path, place: str) -> RunResult:
    if not isinstance(data, dict) or data.get("schema") != SCHEMA:
        raise _FILE.refusal(path, f"{place.rstrip('.') or 'it'} is no result with schema {SCHEMA}")
    try:
        result = _adapter().validate_python({name: value for name, value in data.items() if name != "schema"})
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"]))
        raise _FILE.refusal(path, one_line(f"{place}{where}: {first['msg']}")) from None
    for name, value in _numbers(result.data(), place.rstrip(".")):
        if not math.isfinite(value):
            raise _FILE.refusal(path, f"{name} is {value}; a figure that a run does not have is null")
    return result


def _numbers(data: object, place: str) -> Iterator[tuple[str, float]]:
    """Yield the floating-point numbers in nested data, each with its dotted name, which begins with `place`."""
    if isinstance(data, float):
        yield place, data
    nested = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in nested:
        yield from _numbers(value, f"{place}.{key}".lstrip("."))
