"""The folder of a failure: the smallest scenario, a test that replays it, and a page that says why it fails."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lexis.evaluation.trajectory import LEAST_POSES
from sim.harness.blame_table import BlameTable
from sim.harness.failure_signature import FailureTest, Observed
from sim.harness.first_wrong import position_errors
from sim.harness.outputs import write_run
from sim.harness.reducer import Reduction
from sim.harness.reductions import ScenarioSize, difference
from sim.harness.runner import Run

_TOP = 3
_LISTED = 8
"""How many passing neighbours why.md lists at most."""
_FAR_M = 0.5
"""Error of a position from which on a frame counts as wrong, in failures of the trajectory [m]."""


@dataclass(frozen=True)
class Replay:
    """How a test runs the SLAM: lines that import, and an expression that runs it on the variable `scenario`."""

    imports: str = "from sim.harness import run"
    run: str = "run(scenario)"


LEXIS_REPLAY = Replay()


@dataclass(frozen=True)
class WrongFrame:
    """The first frame that is wrong in the sense of a claim."""

    stamp: float
    """[s]"""
    room: str
    """Id of the room that holds the camera."""
    what: str
    """True and claimed value in words."""
    similarities: tuple[tuple[str, float], ...] = ()
    """The room names that the SLAM found most similar to the image."""


def write_failure(
    out: Path, reduction: Reduction, test: FailureTest, blamed: BlameTable, replay: Replay = LEXIS_REPLAY
) -> None:
    """Run the smallest scenario once more and write the folder of the failure; one of an earlier run is replaced.

    Besides what `write_run` writes, it has original.json, test_replay.py and why.md. Raises `LexisError` where `out` holds
    anything else or cannot be written, and `SimError` if the SLAM raises an exception, since then there is no run.
    """
    before, after = test.observe(reduction.original), test.observe(reduction.scenario)
    texts = {
        "original.json": json.dumps(reduction.original.data(), indent=1) + "\n",
        "test_replay.py": replay_test(test, replay),
        "why.md": why(reduction, test, blamed, before, after),
    }
    write_run(after.run, after.result, after.trials, out, texts)


def replay_test(test: FailureTest, replay: Replay = LEXIS_REPLAY) -> str:
    """A pytest that runs the scenario beside it and asserts the opposite of the claim: it fails until the SLAM is mended."""
    assert test.claim is not None
    plans = test.claim.is_about_plans
    imports = "Claim, Scenario, evaluate" + (", try_plans" if plans else "")
    trials = ", try_plans(finished)" if plans else ""
    return f'''"""Replays a failure. It fails as long as {str(test.claim)!r} is true of the scenario beside it."""

from pathlib import Path

from sim.harness import {imports}
{replay.imports}


def test_replay():
    scenario = Scenario.load(Path(__file__).with_name("scenario.json"))
    finished = {replay.run}
    result = evaluate(finished{trials})
    wanted = Claim.parse("{test.claim.opposite}")
    assert wanted.outcome(result) == "holds", f"{{wanted.figure}} is {{wanted.value(result)}}; wanted: {{wanted}}"
'''


def why(reduction: Reduction, test: FailureTest, blamed: BlameTable, before: Observed, after: Observed) -> str:
    """The page why.md: what fails, by how much, since which step, in which frame, and what mends it."""
    return "\n".join(
        [
            f"# {test.claim}",
            "",
            f"The claim is true of this run, and must not be: {test.claim.figure if test.claim else ''} is "
            f"{_number(after.value)} here, and was {_number(before.value)} in the original scenario.",
            "",
            reduction.note,
            "",
            *_sizes(*reduction.sizes),
            "",
            "## First wrong frame",
            "",
            *_first_wrong(after.run, test),
            "",
            "## The last scenario that passes",
            "",
            *_passing(reduction),
            "",
            "## What mends it",
            "",
            f"{str(blamed)[0].upper()}{str(blamed)[1:]}",
            "",
            *_blame(blamed),
            "",
        ]
    )


def _number(value: float | None) -> str:
    return "null" if value is None else f"{value:.4g}"


def _sizes(before: ScenarioSize, after: ScenarioSize) -> Iterator[str]:
    yield "| | original | smallest |"
    yield "|---|---|---|"
    for name, old, new in zip(ScenarioSize._fields, before, after, strict=True):
        if name != "rig":
            yield f"| {name} | {old:g} | {new:g} |"


def _first_wrong(run: Run, test: FailureTest) -> Iterator[str]:
    assert test.claim is not None
    frame = first_wrong_frame(run, test.claim.figure)
    if frame is None:
        yield f"No single frame is to blame for {test.claim.figure}."
        return
    yield f"At {frame.stamp:.1f} s in {frame.room}: {frame.what}."
    if frame.similarities:
        said = ", ".join(f"{name} {value:.3f}" for name, value in frame.similarities)
        yield f"Most similar room names: {said}."


def first_wrong_frame(run: Run, figure: str) -> WrongFrame | None:
    """The first frame whose floor, position or label is wrong, as the figure of a claim demands; None without one."""
    kind = figure.partition(".")[0]
    claims = run.estimate
    if kind == "floors" and claims.floors is not None:
        wrong = (claims.floors != run.true_storeys) & ~run.on_stairs
        said = [f"floor {truth}, claimed {claim}" for truth, claim in zip(run.true_storeys, claims.floors, strict=True)]
    elif kind == "trajectory" and claims.T_W_B is not None and len(claims.T_W_B) >= LEAST_POSES:
        errors_m = position_errors(claims.T_W_B, run.true_poses)
        wrong = errors_m > min(_FAR_M, float(errors_m.max()) * 0.999)
        said = [f"the position is {error:.2f} m off" for error in errors_m.tolist()]
    elif claims.labels is not None:
        names = run.room_names
        wrong = claims.labels != run.true_labels
        pairs = zip(run.true_labels, claims.labels, strict=True)
        said = [f"{names[truth]}, claimed {names[claim]}" for truth, claim in pairs]
    else:
        return None
    if not wrong.any():
        return None
    row = int(np.argmax(wrong))
    return WrongFrame(
        float(run.stamps[row]), run.house.rooms[run.true_rooms[row]].id, said[row], run.most_similar(row, _TOP)
    )


def _passing(reduction: Reduction) -> Iterator[str]:
    if reduction.accepted:
        yield f"The last step that kept the failure: {reduction.accepted[-1].step}."
    if not reduction.passing:
        yield "No smaller scenario was run that passes."
        return
    yield "One step further it passes:"
    yield ""
    for change in reduction.passing[:_LISTED]:
        yield f"- {change.step}: {difference(reduction.scenario, change.scenario)}"


def _blame(blamed: BlameTable) -> Iterator[str]:
    yield "| replaced | verdict | figure |"
    yield "|---|---|---|"
    for row in blamed.rows:
        yield f"| {row.substitution} | {row.verdict}{f' ({row.detail})' if row.detail else ''} | {_number(row.value)} |"
