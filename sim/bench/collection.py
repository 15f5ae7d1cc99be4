"""Runs many benchmarks as processes of their own and keeps what they print, with where it comes from.

The file of a benchmark begins with its command, the commit, the machine with its versions, and the hashes of all files that
it read and wrote. A benchmark for which all of these are right already is not run again, so that an interrupted collection
can be continued. The command leaves out the name of the collection's folder, so that the folder can be moved.
"""

import hashlib
import json
import os
import shlex
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryFile
from typing import BinaryIO

from lexis.files.replace import replaced_file
from sim.bench.benchmark_list import Benchmark
from sim.doctor import versions
from sim.processes import ONE_THREAD

_HERE = Path(__file__).parent
_LAST_LINES = 3
"""Number of lines of a failed benchmark's error output that are shown."""
_COMMIT_LETTERS = 8
"""Number of letters by which messages name a commit."""
_TABLES = "the text below"
"""Name of what a benchmark printed, in the list of hashes."""


@dataclass(frozen=True)
class BenchmarkRun:
    """How one benchmark of a collection ended."""

    benchmark: Benchmark
    seconds: float | None
    """Wall time [s]; None if its file was there already."""
    processor_s: float = 0.0
    """Processor time of all its processes [s]."""
    error: str = ""
    """The last lines of its error output; empty if it succeeded."""


def collect(benchmarks: Iterable[Benchmark], out: Path, workers: int) -> Iterator[BenchmarkRun]:
    """Run benchmarks and yield how each of them ended, in the order in which they end.

    Args:
        benchmarks: those that measure time run one after the other, after all others.
        out: an existing folder, in which each benchmark gets a file.
        workers: number of benchmarks that run at the same time, each with one thread.
    """
    chosen = tuple(benchmarks)
    for timing, together in ((False, workers), (True, 1)):
        pool = ThreadPoolExecutor(together)
        try:
            begun: list[Future[BenchmarkRun]] = [pool.submit(_run, each, out) for each in chosen if each.is_timing is timing]
            for ended in as_completed(begun):
                yield ended.result()
        finally:
            pool.shutdown(cancel_futures=True)


def source() -> str:
    """Describe what figures depend on besides the command: the commit and its changes, the cores, and the versions."""
    machine = {"cores": os.cpu_count(), **versions()}
    return f"commit {_commit()}\nmachine {json.dumps(machine)}"


def _commit() -> str:
    """Name the commit of this package, with a hash of uncommitted changes; its version if it is not in a repository."""
    if _git("ls-files", "--error-unmatch", __file__) is None:  # not in a repository, or installed into somebody else's
        return f"unknown, version {version('lexis-sim')}"
    commands = ("rev-parse", "HEAD"), ("diff", "HEAD"), ("ls-files", "-z", "--others", "--exclude-standard", ":/*.py")
    commit, changes, added = (_git(*words) or b"" for words in commands)
    changes += b"".join(b"%s\n%s" % (name, (_HERE / os.fsdecode(name)).read_bytes()) for name in added.split(b"\0")[:-1])
    changed = hashlib.sha256(changes).hexdigest()[:12]
    return commit.decode().strip() + (f" with changes {changed}" if changes else "")


def _git(*arguments: str) -> bytes | None:
    """Output of git for the repository of this package; None if there is no repository or no git."""
    try:
        return subprocess.run(("git", *arguments), cwd=_HERE, capture_output=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return None


def why_again(benchmark: Benchmark, out: Path) -> str | None:
    """Say why the earlier file of a benchmark cannot be kept; "" if there is none, and None if it can be kept."""
    file = out / f"{benchmark.name}.txt"
    if not file.is_file():
        return ""
    head, _, tables = file.read_bytes().decode(errors="replace").partition("\n\n")
    earlier, wanted = head.split("\n"), _beginning(benchmark)
    command, commit, machine = [*earlier, "", "", ""][:3]
    if command != wanted[0]:
        return "the earlier file is of another command"
    if commit != wanted[1]:
        name, _, changes = commit.removeprefix("commit ").partition(" ")
        return f"the earlier file is of commit {name[:_COMMIT_LETTERS]} {changes}".rstrip()
    if machine != wanted[2]:
        return "the earlier file is of another machine, or of other versions"
    hashes = {**_hashes_of_inputs(benchmark), **_hashes_of_results(benchmark, out, tables)}
    changed = [name for name, found in hashes.items() if _hash_line(name, found) not in earlier]
    if changed:
        return f"{file.name if changed[0] == _TABLES else changed[0]} is missing or has changed"
    return None


def _beginning(benchmark: Benchmark) -> list[str]:
    """Return the first three lines of a benchmark's file: its command, the commit and the machine."""
    return [f"lexis-sim bench {shlex.join(benchmark.arguments)}", *source().split("\n")]


def _hashes_of_inputs(benchmark: Benchmark) -> dict[str, str]:
    return {str(path): _hash_of_file(path) for path in benchmark.inputs}


def _hashes_of_results(benchmark: Benchmark, out: Path, tables: str) -> dict[str, str]:
    return {name: _hash_of_file(out / name) for name in benchmark.files} | {
        _TABLES: hashlib.sha256(tables.encode()).hexdigest()
    }


def _hash_of_file(path: Path) -> str:
    """Return the SHA-256 of a file; "" if it cannot be read."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""


def _hash_line(name: str, found: str) -> str:
    return f"sha256 {found} {name}"


def _run(benchmark: Benchmark, out: Path) -> BenchmarkRun:
    """Run a benchmark and write its file, unless an earlier one can be kept.

    The file states the commit and the inputs at which the run began.
    """
    if why_again(benchmark, out) is None:
        return BenchmarkRun(benchmark, None)
    beginning, hashes = _beginning(benchmark), _hashes_of_inputs(benchmark)
    start = time.perf_counter()
    command = (sys.executable, "-m", "sim", "bench", *benchmark.arguments_in(out))
    environment = {**os.environ, "PYTHONUTF8": "1"} | ({} if benchmark.is_timing else ONE_THREAD)
    with TemporaryFile() as printed, TemporaryFile() as errors:
        process = subprocess.Popen(command, env=environment, stdout=printed, stderr=errors)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        tables, complaints = (_content(stream) for stream in (printed, errors))
    seconds, processor_s = time.perf_counter() - start, usage.ru_utime + usage.ru_stime
    if process.returncode:
        said = (complaints or tables).strip().splitlines()[-_LAST_LINES:]
        return BenchmarkRun(benchmark, seconds, processor_s, "\n".join(said) or f"exit status {process.returncode}")
    hashes |= _hashes_of_results(benchmark, out, tables)
    took = f"took {seconds:.0f} s, {processor_s:.0f} s of processor time"
    head = [*beginning, took, *(_hash_line(*each) for each in hashes.items())]
    with replaced_file(out / f"{benchmark.name}.txt") as new:
        new.write_bytes("\n".join([*head, "", tables]).encode())
    return BenchmarkRun(benchmark, seconds, processor_s)


def _content(stream: BinaryIO) -> str:
    stream.seek(0)
    return stream.read().decode("utf-8", errors="backslashreplace")
