"""Laws of textures: shape and colour as given, newly drawn each time, never periodic, rich in features at any distance."""

import cv2
import numpy as np
import pytest

from worlds.errors import WorldsError
from worlds.furniture.finishes import finish_of
from worlds.labels import ROOM_LABELS
from worlds.visuals.materials import PATTERNS, texture, tileable

COLOUR = (0.7, 0.6, 0.5)


def _grey(image):
    return cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)


def _paint(pattern, seed=0, shape=(160, 512), metres=(8.0, 2.5)):
    return texture(pattern, COLOUR, np.random.default_rng(seed), shape, metres)


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize(
    ("shape", "metres"), [((128, 128), (1.0, 1.0)), ((16, 300), (9.0, 0.2)), ((1, 1), (0.01, 3.0)), ((90, 17), (0.05, 2.0))]
)
def test_any_surface_can_be_painted(pattern, shape, metres):
    image = _paint(pattern, shape=shape, metres=metres)
    assert image.shape == (*shape, 3)
    assert image.dtype == np.uint8


@pytest.mark.parametrize("pattern", PATTERNS)
def test_the_generator_alone_decides(pattern):
    assert np.array_equal(_paint(pattern, 1), _paint(pattern, 1))
    assert not np.array_equal(_paint(pattern, 1), _paint(pattern, 2))


@pytest.mark.parametrize(
    "pattern", ["plain", "plaster", "wood", "parquet", "tile", "carpet", "concrete", "metal", "ceramic", "fabric"]
)
def test_mean_colour_is_the_colour_asked_for(pattern):
    mean = np.mean([_paint(pattern, seed).mean(axis=(0, 1)) / 255 for seed in range(4)], axis=0)
    assert np.allclose(mean, COLOUR, atol=0.08)


@pytest.mark.parametrize("pattern", sorted(set(PATTERNS) - {"bare"}))
def test_no_shift_brings_a_texture_back_to_itself(pattern):
    shade = _grey(_paint(pattern)).astype(float)
    padded = np.zeros((shade.shape[0], 2 * shade.shape[1]))
    padded[:, : shade.shape[1]] = shade - shade.mean()
    correlation = np.fft.irfft(np.abs(np.fft.rfft(padded, axis=1)) ** 2, axis=1).sum(axis=0)[:256]
    overlap = 1.0 - np.arange(256) / shade.shape[1]
    likeness = correlation / overlap / correlation[0]
    assert likeness[16:].max() < 0.85


def _seen_from(image, distance_m):
    """The middle of a wall of 8 x 2.5 m at 64 px/m, seen frontally by a 100 degree camera 480 px wide, with image noise."""
    scale = 480 / 2 / np.tan(np.radians(50)) / distance_m / 64
    view = cv2.resize(
        _grey(image), None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    )
    noise = np.random.default_rng(0).normal(0.0, 2.0, view.shape)
    return np.clip(view + noise, 0, 255).astype(np.uint8), scale


@pytest.mark.parametrize(
    "pattern",
    ["plain", "plaster", "concrete", "wood", "parquet", "tile", "brick", "paving", "carpet", "marble", "wallpaper", "grass"],
)
def test_walls_and_floors_keep_their_key_points_when_the_camera_comes_closer(pattern):
    akaze = cv2.AKAZE_create(threshold=3e-4)
    image = _paint(pattern)
    points, scales = [], []
    for distance in (2.5, 2.0):
        view, scale = _seen_from(image, distance)
        points.append(np.array([p.pt for p in akaze.detect(view, None)]).reshape(-1, 2))
        scales.append(scale)
    assert len(points[0]) > 50
    moved = points[0] * scales[1] / scales[0]
    nearest = np.min(np.linalg.norm(moved[:, None] - points[1][None], axis=2), axis=1)
    assert np.mean(nearest < 2.0) > 0.4


def test_bare_paint_has_next_to_no_key_points():
    akaze = cv2.AKAZE_create(threshold=3e-4)
    bare, plain = (len(akaze.detect(_seen_from(_paint(pattern), 2.0)[0], None)) for pattern in ("bare", "plain"))
    assert bare < 0.05 * plain


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_tile_laid_beside_itself_has_no_seam(pattern):
    tile = tileable(pattern, COLOUR, np.random.default_rng(0), 90, 1.0).astype(float)
    for axis in (0, 1):
        steps = np.abs(np.diff(np.concatenate([tile, tile], axis=axis), axis=axis)).mean(axis=(1 - axis, 2))
        assert steps[89] <= 1.05 * steps.max(initial=0.0, where=np.arange(179) != 89) + 1.0


@pytest.mark.parametrize("label", ROOM_LABELS)
def test_every_room_has_a_finish_of_known_materials(label):
    for seed in range(10):
        finish = finish_of(label, np.random.default_rng(seed))
        for pattern, colour in (finish.floor, finish.wall, finish.ceiling):
            assert pattern in PATTERNS
            assert all(0.0 < value <= 1.0 for value in colour)


def test_unknown_names_and_sizes_are_refused():
    rng = np.random.default_rng(0)
    with pytest.raises(WorldsError, match="velvet"):
        texture("velvet", COLOUR, rng, (8, 8), (1.0, 1.0))
    with pytest.raises(WorldsError, match="valid: above 0"):
        texture("wood", COLOUR, rng, (8, 8), (0.0, 1.0))
    with pytest.raises(WorldsError, match="dungeon"):
        finish_of("dungeon", rng)
