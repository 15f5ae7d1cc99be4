"""`TextureArea`: a rectangle of pixels with its size in metres, and the random noise that patterns are made of."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Int64
from numpy.random import Generator

Shade = Float32[np.ndarray, "height width"]
"""Factors near 1, one per pixel, by which the colour of a surface is multiplied."""
Planes = Float32[np.ndarray, "3 height width"]
"""A shade (factor on the colour) for each of red, green and blue."""


@dataclass(frozen=True)
class TextureArea:
    """An area of `height` x `width` pixels that covers `height_m` x `width_m` metres."""

    height: int
    width: int
    height_m: float
    width_m: float

    @property
    def transposed(self) -> "TextureArea":
        """The same area with its two axes exchanged."""
        return TextureArea(self.width, self.height, self.width_m, self.height_m)

    @property
    def px_per_m(self) -> float:
        """Resolution along the better resolved axis [px/m]."""
        return max(self.width / self.width_m, self.height / self.height_m)

    def noise(
        self, rng: Generator, cell_m: float, octaves: int = 4, gain: float = 0.7, stretch: float = 1.0
    ) -> Float32[np.ndarray, "height width"]:
        """Draw smooth random values, one per pixel, of zero mean and about unit variance (value noise).

        The noise is a sum of octaves, each of which has random values on a grid. The coarsest grid has cells of `cell_m` [m]
        (times `stretch` along the width). Each further octave has cells half as wide and `gain` times the amplitude; octaves
        with cells below two pixels are left out. Before each octave is added, the sum so far is enlarged to the grid of that
        octave, so that all octaves together cost little more than the finest.
        """
        columns, rows = self.width_m / (cell_m * stretch), self.height_m / cell_m
        field: Shade = np.zeros((2, 2), np.float32)
        amplitude, power = 1.0, 0.0
        for _ in range(octaves):
            grid = (min(math.ceil(rows) + 1, self.height), min(math.ceil(columns) + 1, self.width))
            layer = rng.random(grid, dtype=np.float32)
            layer -= 0.5
            layer *= amplitude
            layer += cv2.resize(field, grid[::-1], interpolation=cv2.INTER_LINEAR)
            field = layer
            power += amplitude**2
            amplitude, rows, columns = amplitude * gain, 2.0 * rows, 2.0 * columns
            if 2.0 * rows > self.height and 2.0 * columns > self.width:
                break
        field *= math.sqrt(12.0 / power)
        enlarged: Shade = cv2.resize(field, (self.width, self.height), interpolation=cv2.INTER_CUBIC)
        return enlarged

    def scatter(self, rng: Generator, per_m2: float, most: int = 250) -> list[tuple[float, float]]:
        """Draw random points (x, y) [px]: about `per_m2` per square metre, but at least 1 and at most `most`."""
        count = min(max(1, int(rng.poisson(per_m2 * self.width_m * self.height_m))), most)
        return [(x * self.width, y * self.height) for x, y in rng.random((count, 2)).tolist()]


@dataclass(frozen=True, eq=False)
class Courses:
    """A surface laid in rows (courses) of pieces such as bricks, tiles or planks; the pieces of a row are numbered."""

    row_of: Int64[np.ndarray, " height"]
    """For every line of pixels, the number of the row of pieces that the line belongs to."""
    piece_of: Int64[np.ndarray, "rows width"]
    """For every row of pieces and every column of pixels, the number of the piece at this column."""
    line_joint: Bool[np.ndarray, " height"]
    """For every line of pixels, whether it belongs to the joint between two rows."""
    pieces: int
    """Upper bound on the number of pieces in a row."""

    def spread(self, rng: Generator, light: float, tint: float, joint: float) -> Planes:
        """Draw a random shade near 1 for each piece, and a random shade near `joint` for each joint between pieces.

        `light` is the standard deviation of the brightness of pieces. `tint` is the standard deviation with which red, green
        and blue of a piece deviate from its brightness.
        """
        rows = len(self.piece_of)
        shades = 1.0 + rng.normal(0.0, light, (rows, self.pieces, 1)) + rng.normal(0.0, tint, (rows, self.pieces, 3))
        table = shades.astype(np.float32)[np.arange(rows)[:, None], self.piece_of]
        # Each joint gets a shade of its own: a grid of equal joints would look the same everywhere.
        ends = np.diff(self.piece_of, axis=1, prepend=self.piece_of[:, :1]) != 0
        table[ends] = joint + rng.normal(0.0, 0.06, (int(ends.sum()), 1))
        planes = np.ascontiguousarray(table.transpose(2, 0, 1)).take(self.row_of, axis=1)
        planes[:, self.line_joint] = joint + rng.normal(0.0, 0.06, (int(self.line_joint.sum()), 1))
        return planes


def courses(
    rng: Generator, surface: TextureArea, course_m: float, piece_m: float, vary: float, aligned: bool = False
) -> Courses:
    """Divide a surface into rows of height `course_m` [m], and each row into pieces about `piece_m` [m] long.

    The lengths of the pieces differ from `piece_m` by up to the share `vary`. With `aligned`, the joints of all rows lie one
    above the other, as between tiles.
    """
    scale_y, scale_x = surface.height_m / surface.height, surface.width_m / surface.width
    row_of = ((np.arange(surface.height) + 0.5) * scale_y / course_m + rng.random()).astype(np.int64)
    rows, pieces = int(row_of[-1]) + 1, math.ceil(surface.width_m / (piece_m * (1.0 - vary))) + 2
    lengths = piece_m * (1.0 + vary * rng.uniform(-1.0, 1.0, (1 if aligned else rows, pieces)))
    starts = np.cumsum(lengths, axis=1) - piece_m * rng.random((len(lengths), 1))
    cuts = np.broadcast_to((starts / scale_x).astype(np.int64), (rows, pieces))
    marks = np.zeros((rows, surface.width), np.int64)
    row, piece = np.nonzero((cuts > 0) & (cuts < surface.width))
    marks[row, cuts[row, piece]] = 1
    joint = np.diff(row_of, prepend=row_of[0]) != 0
    return Courses(row_of, np.cumsum(marks, axis=1), joint, pieces + 1)
