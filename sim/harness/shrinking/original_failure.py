"""The failure in the scenario with which a search began: later failures are compared with it."""

from collections import Counter
from collections.abc import Callable, Sequence

from sim.harness.diagnosis.error_kinds import are_alike, error_kinds, most_frequent
from sim.harness.diagnosis.first_wrong import first_wrong
from sim.harness.finished_run import Run
from sim.harness.results import RunResult
from sim.harness.shrinking.good_slam import GoodSlamChoice
from sim.harness.trial import Trial
from sim.wording import counted


class OriginalFailure:
    """Tells whether the run of a smaller scenario shows the same failure as the original run."""

    def __init__(self) -> None:
        """Leave all to the first failing run."""
        self._good_slam = GoodSlamChoice()
        self._labels: dict[str, str] = {}
        self.kinds: Counter[str] | None = None
        """Number of frames with each kind of error in the original run; None before the first failing run."""
        self.first_wrong = ""
        """Where and how the original run first went wrong, as text; "" before the first failing run, or if it is unknown."""

    def is_unavoidable(self, run: Run, trials: Sequence[Trial], passes: Callable[[RunResult], bool]) -> bool:
        """Return whether a good SLAM fails in the situation of a failing run, too; see `good_slam`.

        `passes` evaluates the test or claim on the figures of another SLAM. The first call is for the original run.
        """
        return not self._good_slam.avoids(run, trials, passes)

    def is_like(self, run: Run, figure: str | None) -> bool:
        """Return whether a failing run has the same kinds of errors as the original one, which the first call remembers.

        `figure` is the figure of the failure, such as "rooms.pq"; None if it is not known.
        """
        if self.kinds is None:
            self._labels = {room.id: room.label for room in run.house.rooms}
            self.kinds = error_kinds(run, figure, self._labels)
            self.first_wrong = str(first_wrong(run, figure) or "")
            return True
        return are_alike(error_kinds(run, figure, self._labels), self.kinds)

    def compared(self, run: Run, figure: str | None) -> str:
        """Compare both runs: how many wrong frames have the error that is most frequent in the smallest scenario.

        Return "" for figures without kinds of errors.
        """
        if not (kinds := error_kinds(run, figure, self._labels)):
            return ""
        kind, before = most_frequent(kinds), self.kinds or kinds
        wrong = f"{kinds[kind]} of {counted(kinds.total(), 'wrong frame')} {'is' if kinds[kind] == 1 else 'are'} {kind}"
        return f"Here, {wrong}; in the original scenario, {before[kind]} of {before.total()}."
