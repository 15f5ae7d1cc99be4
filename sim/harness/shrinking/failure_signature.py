"""`Signature`: tells failures apart."""

from dataclasses import dataclass, field, replace


@dataclass(frozen=True)
class Signature:
    """Identifies a failure: two runs with equal signatures show the same failure."""

    what: str
    """How the run failed: the condition for a failure that came true, such as "labels.accuracy < 0.7", or what the SLAM did
    in a crash, such as "raises RuntimeError"."""
    value: float | None = field(default=None, compare=False)
    """Value of the figure in the condition `what`, in the run that failed; None if `what` is an exception."""

    @property
    def unavoidable(self) -> "Signature":
        """The signature of the same failure in a scenario in which a good SLAM fails, too; see `good_slam`."""
        return replace(self, what=f"{self.what}, where a good SLAM fails, too")

    @property
    def of_reference(self) -> "Signature":
        """The signature of the same failure in a scenario in which the reference fails, too, or crashes."""
        return replace(self, what=f"{self.what}, where the reference fails, too")

    @property
    def with_other_errors(self) -> "Signature":
        """The signature of a failure whose wrong frames are of other kinds than those of the original failure."""
        return replace(self, what=f"{self.what}, by errors of another kind")

    def __str__(self) -> str:
        return self.what
