"""Faults of images: blur, exposure, noise, grease on the lens, darkness. They change no other part of an observation."""

from abc import abstractmethod
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from jaxtyping import Float32

from lexis.inputs import pixels
from lexis.types import Image, Observation
from sim.faults.fault import FrameFault, SpanFault, setting
from sim.truth import Stream

_GAMMA = 2.2
"""Exponent of the camera's gamma curve, which maps light to grey levels."""
_HAZE, _HAZE_LEVEL = 0.25, 190.0
"""Share of scattered light in the value of a pixel behind grease, and grey level of the scattered light."""
_PATCH, _EDGE = 0.08, 0.5
"""Grease lies where smoothed noise exceeds a threshold. `_PATCH` is the standard deviation of the smoothing [image widths],
which sets the size of the patches. `_EDGE` is the range of values around the threshold over which a patch fades in [standard
deviations of the smoothed noise]."""


@dataclass(frozen=True)
class ImageFault(FrameFault):
    """A fault that changes each image in its time span."""

    def change(self, observation: Observation, rng: np.random.Generator) -> Observation:
        """Return the observation with the changed images of all cameras."""
        return observation.with_images([self.edit(image, rng) for image in pixels(observation)])

    @abstractmethod
    def edit(self, image: Image, rng: np.random.Generator) -> Image:
        """Return the image with the fault."""


@dataclass(frozen=True)
class Blur(ImageFault):
    """Horizontal motion blur, as if the camera turned while its shutter is open: points become lines along the rows."""

    name = "blur"
    pixels: int = setting(9, 1, 200)
    """Length of the horizontal line to which each point is blurred [px]."""

    def edit(self, image: Image, rng: np.random.Generator) -> Image:
        """Return the image with each pixel averaged over `pixels` neighbours in its row."""
        return np.asarray(cv2.blur(image, (self.pixels, 1), borderType=cv2.BORDER_REPLICATE))


@dataclass(frozen=True)
class Exposure(ImageFault):
    """Wrong exposure: the light is scaled before the camera's gamma curve is applied; values above white are clipped."""

    name = "exposure"
    stops: float = setting(-2.0, -16.0, 16.0)
    """Exposure error in stops: the light is multiplied by `2 ** stops`. Negative values make images darker."""

    def edit(self, image: Image, rng: np.random.Generator) -> Image:
        """Return the image as exposed to `2 ** stops` times the light, clipped at white."""
        return _with_light(image, 2.0**self.stops)


def _with_light(image: Image, factor: float) -> Image:
    table = np.linspace(0.0, 1.0, 256) * factor ** (1.0 / _GAMMA)
    return np.asarray(cv2.LUT(image, np.rint(255.0 * np.minimum(table, 1.0)).astype(np.uint8)))


@dataclass(frozen=True)
class Noise(ImageFault):
    """White noise of the sensor, independent in each pixel and channel."""

    name = "noise"
    sigma: float = setting(12.0, 0.0, 255.0)
    """Standard deviation of the noise [grey levels]."""

    def edit(self, image: Image, rng: np.random.Generator) -> Image:
        """Return the image with noise, clipped to the range of grey levels."""
        return _noisy(image, self.sigma, rng)


def _noisy(image: Image, sigma: float, rng: np.random.Generator) -> Image:
    noise = sigma * rng.standard_normal(image.shape, dtype=np.float32)
    return np.asarray(np.rint(np.clip(image + noise, 0.0, 255.0)), np.uint8)


@dataclass(frozen=True)
class LightsOff(ImageFault):
    """The lights are switched off: little light is left, and the image has the sensor's noise."""

    name = "lights-off"
    left: float = setting(0.002, 0.0, 1.0)
    """Share of the light that is left."""
    sigma: float = setting(3.0, 0.0, 255.0)
    """Standard deviation of the noise [grey levels]."""

    def edit(self, image: Image, rng: np.random.Generator) -> Image:
        """Return the dark image with noise."""
        return _noisy(_with_light(image, self.left), self.sigma, rng)


@dataclass(frozen=True)
class Smear(SpanFault):
    """Grease on the lenses: patches in which images are blurred and hazy. All images have the same patches."""

    name = "smear"
    share: float = setting(0.3, 0.0, 1.0)
    """Share of the image that patches cover."""
    blur_px: float = setting(6.0, 0.1, 100.0)
    """Standard deviation of the blur in the patches [px]."""

    def apply(self, stream: Stream, rng: np.random.Generator) -> Stream:
        """Yield the stream with grease in its images."""
        seed = int(rng.integers(2**63))
        for observation, truth in stream:
            if self.active(truth):
                yield (
                    observation.with_images([self._smeared(image, seed) for image in pixels(observation)]),
                    self.mark(truth),
                )
            else:
                yield observation, truth

    def _smeared(self, image: Image, seed: int) -> Image:
        covered = _patches(image.shape[0], image.shape[1], self.share, seed)
        spread = cv2.GaussianBlur(image, (0, 0), self.blur_px).astype(np.float32)
        greasy = (1.0 - _HAZE) * spread + _HAZE * _HAZE_LEVEL
        return np.asarray(np.rint(image + covered * (greasy - image)), np.uint8)


OF_IMAGES = (ImageFault, Smear)
"""The faults that change images after they were rendered."""


@lru_cache(maxsize=4)
def _patches(height: int, width: int, share: float, seed: int) -> Float32[np.ndarray, "h w 1"]:
    """Return, for each pixel, how much of its light passes through grease, from 0 to 1.

    Patches of grease lie where smooth random noise exceeds a threshold. The threshold is chosen so that the patches cover
    `share` of the image.
    """
    noise = np.random.default_rng(seed).standard_normal((height, width), dtype=np.float32)
    smooth = cv2.GaussianBlur(noise, (0, 0), _PATCH * width)
    edge = _EDGE * float(smooth.std())
    above = smooth - (np.quantile(smooth, 1.0 - share) if share else np.inf)
    return np.asarray(np.clip(above / edge + 0.5, 0.0, 1.0)[..., None], np.float32)
