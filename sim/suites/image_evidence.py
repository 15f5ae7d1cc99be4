"""The law that the similarities a SLAM claims for a frame come from the image of this frame, and from no other."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from lexis.types import Image, Observation, Percept
from sim.suites.checks import CheckFinding, Examined, NewSlam, attempted, reaches
from sim.suites.stream_changes import NoChange

_SAME = 1e-5
"""Tolerance for rounding: two similarities that should be equal may differ by this share of the largest similarity."""


@dataclass(frozen=True)
class OtherImages(NoChange):
    """The image of every second observation is replaced by a black image.

    In runs on features, every second observation gets one fixed embedding instead, and no points.
    """

    def observations(self, observation: Observation, number: int, previous: Observation | None) -> Iterator[Observation]:
        """Yield the observation, with its image replaced if the observation's index is odd."""
        yield (
            observation.with_images(map(_other, observation.images)) if self.is_replaced(observation.index) else observation
        )

    @staticmethod
    def is_replaced(frame: int) -> bool:
        """Return whether the image of the observation with this index is replaced."""
        return frame % 2 == 1


@dataclass(frozen=True)
class SimilaritiesFollowImages:
    """A law about claimed similarities: if every second image is replaced, the similarities of the other images stay."""

    name: str = "similarities follow the images"
    says: str = (
        "If every second image is replaced by one and the same, the similarities of the other frames stay, and those of the "
        "replaced ones are equal. Tolerance: rounding."
    )
    rate: float | None = None

    def examine(self, base: Examined, new_slam: NewSlam) -> CheckFinding:
        """Run the SLAM on the changed images, and compare the similarities of the frames that both runs have."""
        first, change = base.run.estimate, OtherImages()
        if not reaches(change, base.run):
            return CheckFinding(None, "the change does not reach this SLAM")
        if first.similarities is None:
            return CheckFinding(None, "the SLAM claims no similarities")
        finished = attempted(base.run.scenario, new_slam, change)
        if isinstance(finished, CheckFinding):
            return finished
        second = finished.estimate
        if second.similarities is None:
            return CheckFinding(False, "only the run on the unchanged images claims similarities")
        frames, rows_a, rows_b = np.intersect1d(first.frames, second.frames, return_indices=True)
        replaced = np.array([change.is_replaced(frame) for frame in frames.tolist()], bool)
        if replaced.all() or not replaced.any():
            return CheckFinding(None, "the two runs have too few frames in common")
        kept = np.abs(first.similarities[rows_a] - second.similarities[rows_b])[~replaced].max()
        equal = np.ptp(second.similarities[rows_b][replaced], axis=0).max()
        return CheckFinding(
            bool(max(kept, equal) <= _SAME * np.abs(first.similarities).max()),
            f"similarities of frames with unchanged images change by up to {kept:.2g}; those of frames with the same image "
            f"differ by up to {equal:.2g}",
        )


def _other(image: Image | Percept) -> Image | Percept:
    if not isinstance(image, Percept):
        return np.zeros_like(image)
    same = np.zeros_like(image.embedding)
    same[0] = 1.0
    return replace(image, embedding=same, points=image.points[:0])
