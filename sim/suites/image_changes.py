"""Changes of the images, after which a SLAM must claim other similarities, or must not label rooms better."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from lexis.types import Image, Observation, Percept
from sim.harness.scenario import Scenario
from sim.suites.stream_changes import NoChange


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
class _ChangedPixels(NoChange):
    """Base class of the changes of pixels. They do not reach a SLAM that is given percepts."""

    def observations(self, observation: Observation, number: int, previous: Observation | None) -> Iterator[Observation]:
        """Yield the observation with the changed image."""
        yield observation.with_images(
            image if isinstance(image, Percept) else self.pixels(image) for image in observation.images
        )

    def pixels(self, image: Image) -> Image:
        """Return the changed image."""
        raise NotImplementedError

    def matters(self, scenario: Scenario, slam: object) -> bool:
        """Return whether the scenario is rendered."""
        return scenario.fidelity == "render"


@dataclass(frozen=True)
class ExchangedColours(_ChangedPixels):
    """Red and blue are exchanged in all images."""

    def pixels(self, image: Image) -> Image:
        """Return the image as BGR."""
        return np.ascontiguousarray(image[..., ::-1])


@dataclass(frozen=True)
class DarkerImages(_ChangedPixels):
    """All images are half as bright."""

    def pixels(self, image: Image) -> Image:
        """Return the image with half the values, rounded down."""
        return image // 2


def _other(image: Image | Percept) -> Image | Percept:
    if not isinstance(image, Percept):
        return np.zeros_like(image)
    same = np.zeros_like(image.embedding)
    same[0] = 1.0
    return replace(image, embedding=same, points=image.points[:0])
