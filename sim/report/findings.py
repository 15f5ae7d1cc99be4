"""The summary of a report: a few sentences that say what went wrong in a run, where, and how badly."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import compress
from typing import Any

import numpy as np

from lexis.evaluation.trajectory import LEAST_POSES, STRETCHES_M, ate_rmse, rpe_translation
from lexis.graph.trusted_loops import TRUSTED_WEIGHT
from sim.report.data import UNKNOWN, KeyframeTable, PlanPath, ReportData
from sim.report.room_errors import SUBSTANTIAL, Groups, room_errors, surplus
from sim.wording import counted, joined
from worlds.valid_names import listed

_EXAMPLES = 3
"""Largest number of rooms or plans that one finding names."""
WELL_COVERED = 0.95
"""The map counts as complete if it covers at least this share of the walk. The report then mentions no missing share."""

_REMOVING = ("dropped", "kidnap")
"""Names of the faults that remove frames."""


@dataclass(frozen=True)
class Finding:
    """A sentence about a run, whether the sentence is good news, and a keyframe that illustrates it, if there is one."""

    good: bool
    text: str
    keyframe: int | None = None


def findings(data: ReportData) -> list[Finding]:
    """Return the findings about a run: first bad news, then good news, both in the order of the SLAM's stages."""
    stages = (_mistakes, _coverage, _faults, _confusions, _refinement, _rooms, _floors, _loops, _trajectory, _plans)
    return sorted((finding for stage in stages for finding in stage(data)), key=lambda finding: finding.good)


def coverage_gap(result: Mapping[str, Any], rooms: Sequence[str]) -> str | None:
    """Return sentences on what the map does not cover. None if no room and at most 5 % of the walk are missing.

    Args:
        result: the contents of result.json.
        rooms: names of the rooms on the walk that contain no keyframe.
    """
    sentences = []
    covered = (result.get("coverage") or {}).get("path_covered")
    if rooms or (covered is not None and covered < WELL_COVERED):
        sentences.append(_extent(result))
    sentences.append(rooms_without_keyframe(rooms))
    return " ".join(filter(None, sentences)) or None


def _extent(result: Mapping[str, Any]) -> str | None:
    coverage: Mapping[str, Any] = result.get("coverage") or {}
    if coverage.get("path_covered") is None:
        return None
    rooms = f"{coverage['rooms_visited']} of {coverage['rooms']} rooms"
    return f"The map covers {rooms} and {coverage['path_covered']:.0%} of the walk."


def idle_faults(result: Mapping[str, Any]) -> str | None:
    """Return a sentence on the faults that changed no frame, from the contents of result.json; None if there are none.

    A fault that removes frames has an effect even if it changes none of those that remain.
    """
    faults = result.get("faults") or {}
    frames, lost = faults.get("frames") or {}, faults.get("delivered", 0) < (result.get("run") or {}).get("frames", 0)
    if idle := [name for name, count in frames.items() if not count and not (lost and name in _REMOVING)]:
        which = f"fault {idle[0]}" if len(idle) == 1 else f"faults {', '.join(idle)}"
        return f"The {which} changed no frame; a fault that begins after the end of the walk has no effect."
    return None


def rooms_without_keyframe(rooms: Sequence[str]) -> str | None:
    """Return a sentence that names the rooms without a keyframe, which no figure covers; None if `rooms` is empty."""
    if not rooms:
        return None
    names = joined(rooms, "and")
    count = counted(len(rooms), "room")
    return f"No keyframe was taken in {count} of the walk, so the figures of labels and rooms do not cover {names}."


def _coverage(data: ReportData) -> Iterator[Finding]:
    if text := coverage_gap(data.result, data.unseen_rooms):
        yield Finding(False, text)
    elif text := _extent(data.result):
        yield Finding(True, text)


def _mistakes(data: ReportData) -> Iterator[Finding]:
    return (Finding(False, text) for text in data.mistakes)


def _faults(data: ReportData) -> Iterator[Finding]:
    if text := idle_faults(data.result):
        yield Finding(False, text)


def _confusions(data: ReportData) -> Iterator[Finding]:
    table, names = data.keyframes, data.label_names
    if not table.is_labelled:
        return
    wrong = np.flatnonzero(table.wrong)
    if len(wrong) == 0:
        yield Finding(True, "Every keyframe carries the label of its room.")
    pairs = Counter((int(table.true_labels[k]), int(table.predicted_labels[k])) for k in wrong)
    for (true, said), count in pairs.most_common(_EXAMPLES):
        those = np.flatnonzero((table.true_labels == true) & (table.predicted_labels == said))
        verb = _suiting(count, "has", "have") if said == UNKNOWN else _suiting(count)
        what = "no label" if said == UNKNOWN else f"labelled {names[said]}"
        here = table.true_labels == true
        total, rooms = counted(int(np.sum(here)), "keyframe"), len(set(compress(table.true_rooms, here)))
        where = names[true] if rooms == 1 else f"{rooms} rooms with the true label {names[true]}"
        text = f"{count} of {total} in the {where} {verb} {what}."
        yield Finding(False, text, int(those[0]))


def _refinement(data: ReportData) -> Iterator[Finding]:
    table = data.keyframes
    if not (table.is_labelled and table.is_labelled_before):
        return
    before, after = table.baseline_labels == table.true_labels, ~table.wrong
    mended, spoiled = int(np.sum(~before & after)), int(np.sum(before & ~after))
    if mended or spoiled:
        first = int(np.flatnonzero(before & ~after)[0]) if spoiled else None
        wrong, right = counted(mended, "wrong label"), counted(spoiled, "correct label")
        text = f"Refinement corrected {wrong} and made {right} wrong."
        yield Finding(mended >= spoiled, text, first)


def _rooms(data: ReportData) -> Iterator[Finding]:
    true, predicted = data.keyframes.true_rooms, data.keyframes.predicted_rooms
    if not data.keyframes.has_rooms:
        return
    errors = room_errors(true, predicted)
    if errors.splits:
        splits = counted(surplus(errors.splits), "split")
        text = f"{splits} (several estimated rooms lie mostly in one true room): {_listed(errors.splits, ' = ')}."
        yield Finding(False, text, true.index(next(iter(errors.splits))))
    if errors.merges:
        merges = counted(surplus(errors.merges), "merge")
        rooms = listed(
            [f"estimated {room} = {joined(others, 'and')}" for room, others in errors.merges.items()],
            _EXAMPLES,
            separator="; ",
        )
        text = f"{merges} (several true rooms lie mostly in one estimated room): {rooms}."
        yield Finding(False, text, predicted.index(next(iter(errors.merges))))
    if errors.partial_losses:
        have = _suiting(len(errors.partial_losses), "has at least {:.0%} of its", "have at least {:.0%} of their")
        losses = f"{len(errors.partial_losses)} of {counted(len(set(true)), 'true room')}"
        text = (
            f"{losses} {have.format(SUBSTANTIAL)} keyframes in an estimated room that lies mostly elsewhere, "
            "which counts as neither split nor merge: "
            f"{_listed(errors.partial_losses, ' partly in ')}."
        )
        yield Finding(False, text, true.index(next(iter(errors.partial_losses))))


def _listed(groups: Groups, joint: str) -> str:
    """List true rooms with their estimated rooms: "bedroom 0.1 = estimated rooms 4 (kitchen) and 5 (living room)"."""
    return listed([f"{room}{joint}{_estimated(others)}" for room, others in groups.items()], _EXAMPLES, separator="; ")


def _estimated(rooms: Sequence[str]) -> str:
    names = joined([room.removeprefix("room ") for room in rooms], "and")
    return f"estimated {_suiting(len(rooms), 'room', 'rooms')} {names}"


def _floors(data: ReportData) -> Iterator[Finding]:
    accuracy = (data.result.get("floors") or {}).get("accuracy")
    if accuracy is not None and accuracy < 1.0:
        share = f"{1 - accuracy:.1%}" if accuracy <= 0.999 else "Less than 0.1%"
        yield Finding(False, f"{share} of the keyframes off the stairs are assigned to a wrong floor.")


def _loops(data: ReportData) -> Iterator[Finding]:
    if not data.estimates_loops:
        return
    false = sorted((loop for loop in data.loops if not loop.true), key=lambda loop: -loop.weight)
    if not data.loops:
        yield Finding(False, "No loop was closed.")
    elif not false:
        count = len(data.loops)
        yield Finding(True, _suiting(count, "The only loop edge is true.", f"All {count} loop edges are true."))
    else:
        worst = false[0]
        ends = data.keyframes.true_poses[[worst.query, worst.match], :3, 3]
        wrong = f"{worst.error_m:.1f} m and {math.degrees(worst.error_rad):.0f}°"
        ignored = worst.weight < TRUSTED_WEIGHT
        held = ", but the optimiser gives little weight to any of them" if ignored else ""
        edges = f"{len(false)} of {counted(len(data.loops), 'loop edge')} {_suiting(len(false))}"
        yield Finding(
            ignored,
            f"{edges} false{held}; the strongest has weight {worst.weight:.2f} and "
            f"connects keyframe {worst.query} to keyframe {worst.match}, which are truly "
            f"{np.linalg.norm(ends[0] - ends[1]):.1f} m apart; its relative pose is wrong by {wrong}.",
            worst.query,
        )


def _trajectory(data: ReportData) -> Iterator[Finding]:
    table = data.keyframes
    if len(table.stamps) < LEAST_POSES or not data.estimates_poses:
        return
    worst = int(np.argmax(table.estimated_errors))
    off, drift = round(table.estimated_errors[worst], 2), round(table.odometry_errors[worst], 2)
    place = f"keyframe {worst} in {table.true_rooms[worst]}"
    if off > 0.0:
        text = f"The largest position error is {off:.2f} m, at {place} (odometry there: {drift:.2f} m)."
        yield Finding(bool(off <= drift), text, worst)
    if data.loops:
        yield from _drift(table)


def _drift(table: KeyframeTable) -> Iterator[Finding]:
    """Compare the errors before and after loop closing, over the whole trajectory and over parts of fixed length."""
    truth, odometry, estimated = table.true_poses, table.odometry_poses, table.estimated_poses
    ate = [ate_rmse(poses[:, :3, 3], truth[:, :3, 3]) for poses in (odometry, estimated)]
    yield from _compared("the ATE", *ate)
    for delta in STRETCHES_M:
        rpe = [rpe_translation(poses, truth, delta) for poses in (odometry, estimated)]
        yield from _compared(f"the relative error over stretches of {delta:.0f} m (RPE)", *rpe)


def _compared(error: str, before: float | None, after: float | None) -> Iterator[Finding]:
    if before is not None and after is not None:
        before, after = round(before, 3), round(after, 3)
        worse = ", which is worse" if after > before else ""
        changed = f"changed {error} from {before:.3f} m to {after:.3f} m{worse}"
        yield Finding(after <= before, f"Loop closing {changed if after != before else f'left {error} at {before:.3f} m'}.")


def _plans(data: ReportData) -> Iterator[Finding]:
    failed, count = data.failed, len(data.paths)
    if failed:
        examples = listed(failed, _EXAMPLES, shown=_failure, separator="; ")
        what = f"{counted(count, 'plan')} did not reach {_suiting(len(failed), 'its', 'their')} room"
        yield Finding(False, f"{len(failed)} of {what}: {examples}.")
    elif count:
        yield Finding(True, _suiting(count, "The only plan reached its room.", f"All {count} plans reached their room."))


def _suiting(count: int, one: str = "is", more: str = "are") -> str:
    """Return the words that suit a count: `one` after 1, otherwise `more`."""
    return one if count == 1 else more


def _failure(path: PlanPath) -> str:
    return f"from {path.start} to {path.goal}" + (f" ({path.reason})" if path.reason else "")
