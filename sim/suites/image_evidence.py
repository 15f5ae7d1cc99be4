"""Laws about what a SLAM takes from images: the similarities of a frame from its own image, and loops from its geometry."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from lexis.types import Image, Observation, Percept
from sim.harness.estimate import Estimate
from sim.harness.figures import EvaluatedRun
from sim.harness.scenario import Scenario
from sim.suites.checks import CheckFinding, NewSlam, run_on_change
from sim.suites.stream_changes import NoChange

_TILES = 6, 8
"""Rows and columns of tiles of a jumbled image."""
_RECOGNISED, _LOOPS = 0.12, 10
"""Largest number of loop closures of jumbled images, as a share of their number without the change; and least number without
the change for a judgement."""
_SAME = 1e-5
"""Tolerance for rounding: two similarities that should be equal may differ by this share of the largest similarity."""


@dataclass(frozen=True)
class OtherImages(NoChange):
    """The image of every second observation is replaced by a black image.

    In runs on features, every second observation gets one fixed embedding instead, and no points.
    """

    def observations(self, observation: Observation, previous: Observation | None) -> Iterator[Observation]:
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
    """A law about estimated similarities: if every second image is replaced, the similarities of the other images stay."""

    name: str = "similarities follow the images"
    says: str = (
        "If every second image is replaced by one and the same, the similarities of the other frames stay, and those of the "
        "replaced ones are equal. Tolerance: rounding."
    )
    rate: float | None = None

    def examine(self, base: EvaluatedRun, new_slam: NewSlam) -> CheckFinding:
        """Run the SLAM on the changed images, and compare the similarities of the frames that both runs have."""
        first, change = base.run.estimate, OtherImages()
        if first.similarities is None:
            return CheckFinding(None, "the SLAM estimates no similarities")
        finished = run_on_change(change, base.run, new_slam)
        if isinstance(finished, CheckFinding):
            return finished
        second = finished.estimate
        if second.similarities is None:
            return CheckFinding(False, "only the run on the unchanged images estimates similarities")
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


@dataclass(frozen=True)
class JumbledImages(NoChange):
    """From some observation on, each image consists of tiles that show a part of the image beside their own.

    Details still look right, but no camera sees them in this arrangement. Each image is jumbled in another way.
    """

    first: int = 150
    """Index of the first observation with jumbled images."""
    most_px: int = 24
    """Largest distance in each direction between a tile and what it shows [px]."""
    seed: int = 0

    def observations(self, observation: Observation, previous: Observation | None) -> Iterator[Observation]:
        """Yield the observation, with its images jumbled if the observation's index is at least `first`."""
        if observation.index < self.first:
            yield observation
            return
        rng = np.random.default_rng((self.seed, observation.index))
        yield observation.with_images([self._jumbled(image, rng) for image in observation.images])

    def matters(self, scenario: Scenario, slam: object) -> bool:
        """Return whether the SLAM gets images."""
        return scenario.fidelity == "render"

    def _jumbled(self, image: Image | Percept, rng: np.random.Generator) -> Image:
        assert not isinstance(image, Percept)
        y, x = np.indices(image.shape[:2])
        tile = y * _TILES[0] // image.shape[0], x * _TILES[1] // image.shape[1]
        down, right = rng.integers(-self.most_px, self.most_px + 1, (2, *_TILES))
        rows = np.clip(y + down[tile], 0, image.shape[0] - 1)
        columns = np.clip(x + right[tile], 0, image.shape[1] - 1)
        return np.ascontiguousarray(image[rows, columns])


@dataclass(frozen=True)
class JumbledImagesAreNotRecognised:
    """A law about loop closures: images whose details are out of place lead to hardly any."""

    name: str = "jumbled images are not recognised"
    says: str = (
        "In the later part of the walk, each image is cut into tiles, whose contents are shifted in different ways by up to "
        f"{JumbledImages().most_px} px. These images lead to at most {_RECOGNISED:.0%} of the loop closures that the "
        "unchanged images lead to, because their geometry fits no view."
    )
    rate: float | None = 0.95
    change: JumbledImages = JumbledImages()

    def examine(self, base: EvaluatedRun, new_slam: NewSlam) -> CheckFinding:
        """Run the SLAM on the changed images, and count the loop closures of these images in both runs."""
        before = _loops_from(base.run.estimate, self.change.first)
        if before < _LOOPS:
            return CheckFinding(None, f"the later part of the walk has {before} loop closures, too few to judge")
        second = run_on_change(self.change, base.run, new_slam)
        if isinstance(second, CheckFinding):
            return second
        after = _loops_from(second.estimate, self.change.first)
        found = f"{after} loop closures are left of {before} in the later part of the walk"
        return CheckFinding(after <= _RECOGNISED * before, found)


def _loops_from(estimate: Estimate, first: int) -> int:
    """Return the number of loop closures whose query is the observation with index `first` or a later one."""
    return 0 if estimate.loops is None else int((estimate.frames[estimate.loops.query] >= first).sum())


def _other(image: Image | Percept) -> Image | Percept:
    if not isinstance(image, Percept):
        return np.zeros_like(image)
    same = np.zeros_like(image.embedding)
    same[0] = 1.0
    return replace(image, embedding=same, points=image.points[:0])
