"""Shows why loop candidates were accepted or refused: counts by reason, and lists of false loops and of missed revisits."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from sim.report.data import CandidateMark, ReportData

_MOST = 12
"""Largest number of candidates in each list."""


@dataclass(frozen=True)
class ReasonCount:
    """Numbers of loop candidates with the same reason: `revisits` are truly at the same place, `others` are not."""

    reason: str
    accepted: bool
    revisits: int
    others: int


@dataclass(frozen=True)
class CandidateList:
    """Loop candidates to look at: false loops, or missed revisits."""

    title: str
    meaning: str
    figures: tuple[str, ...]
    """Names of all figures that occur among the shown candidates."""
    shown: tuple[CandidateMark, ...]
    more: int
    """Number of candidates that are not shown."""


def reason_counts(data: ReportData) -> list[ReasonCount]:
    """Count the candidates by reason: reasons for acceptance before reasons for refusal, then frequent reasons first."""
    counts = Counter((mark.accepted, mark.reason, mark.revisit) for mark in data.candidates)
    reasons = {(accepted, reason) for accepted, reason, _ in counts}
    rows = [
        ReasonCount(reason, accepted, counts[accepted, reason, True], counts[accepted, reason, False])
        for accepted, reason in reasons
    ]
    return sorted(rows, key=lambda row: (not row.accepted, -row.revisits - row.others, row.reason))


def candidate_lists(data: ReportData) -> list[CandidateList]:
    """Return the lists of false loops and of missed revisits; empty lists are left out."""
    false = {(loop.query, loop.match) for loop in data.loops if not loop.true}
    closed = {loop.query for loop in data.loops if loop.true}
    wrong = [mark for mark in data.candidates if mark.accepted and (mark.query, mark.match) in false]
    missed = [m for m in data.candidates if m.revisit and not m.accepted and m.query not in closed]
    lists = [
        _list("False loops", "Accepted, although the measured relative pose is wrong.", wrong),
        _list("Missed revisits", "Refused, although at one place, and the keyframe got no other true loop edge.", missed),
    ]
    return [each for each in lists if each.shown]


def _list(title: str, meaning: str, marks: Sequence[CandidateMark]) -> CandidateList:
    """Return a list of the candidates with the largest figures, which are the most instructive, in the order of time."""
    best = sorted(marks, key=lambda mark: (-len(mark.figures), *(-value for value in mark.figures.values())))[:_MOST]
    shown = sorted(best, key=lambda mark: (mark.query, mark.match))
    figures = tuple(dict.fromkeys(name for mark in shown for name in mark.figures))
    return CandidateList(title, meaning, figures, tuple(shown), len(marks) - len(shown))
