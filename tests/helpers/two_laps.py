"""Made-up keyframes of a walk that passes the same places twice, for methods of place recognition."""

from dataclasses import fields, replace

import numpy as np

from lexis.evaluation.place_recognition import at_one_place
from sim.baselines.places.place_method import SeenKeyframes
from sim.bench.peers.place_walks import PlaceWalk

PLACES = 14


def two_laps(rng: np.random.Generator, noise: float = 0.1, flipped: float = 0.03) -> SeenKeyframes:
    """Two laps past `PLACES` places; the images of a place differ by noise, and by a share of flipped bits."""
    places = np.tile(np.arange(PLACES), 2)
    embeddings = rng.normal(size=(PLACES, 32))[places] + noise * rng.normal(size=(2 * PLACES, 32))
    embeddings = (embeddings / np.linalg.norm(embeddings, axis=1, keepdims=True)).astype(np.float32)
    number = np.arange(2 * PLACES)
    apart = number[:, None] - number
    estimated = np.where(apart >= 0, np.abs(places[:, None] - places).astype(float), np.inf)
    every = apart > 0
    return SeenKeyframes(
        embeddings,
        _flipped(rng.integers(0, 256, (PLACES, 60, 32), np.uint8)[places], flipped, rng),
        _flipped(rng.integers(0, 256, (PLACES, 60, 61), np.uint8)[places], flipped, rng),
        _noisy(rng.normal(size=(PLACES, 20, 24))[places], noise, rng),
        apart >= 4,
        estimated,
        np.where(apart >= 0, 0.0, np.inf),
        every,
        every & (places[:, None] // 7 == places // 7),
    )


def walk_of(seen: SeenKeyframes, spacing_m: float = 2.0) -> PlaceWalk:
    """The walk of `two_laps` with its truth: places lie in a row, and half of them in each of two rooms."""
    places = np.tile(np.arange(PLACES), 2)
    poses = np.tile(np.eye(4), (len(places), 1, 1))
    poses[:, 0, 3] = spacing_m * places
    rooms = places // 7
    return PlaceWalk("home", 1, seen, poses, at_one_place(poses), rooms, np.zeros_like(rooms), np.zeros_like(rooms))


def first_keyframes(seen: SeenKeyframes, count: int) -> SeenKeyframes:
    """The beginning of a walk."""
    cut = {each.name: getattr(seen, each.name)[:count] for each in fields(seen)}
    return replace(seen, **{name: value[:, :count] if _is_square(value, seen) else value for name, value in cut.items()})


def replace_embeddings(seen: SeenKeyframes, embeddings: np.ndarray) -> SeenKeyframes:
    """The same walk with other embeddings."""
    return replace(seen, embeddings=embeddings)


def _is_square(value: object, seen: SeenKeyframes) -> bool:
    return isinstance(value, np.ndarray) and value.shape[1] == len(seen.embeddings)


def _flipped(descriptors: np.ndarray, share: float, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    noise = np.packbits(rng.random((*descriptors.shape, 8)) < share, axis=-1)[..., 0]
    return tuple(descriptors ^ noise)


def _noisy(features: np.ndarray, noise: float, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    noisy = features + noise * rng.normal(size=features.shape)
    return tuple((noisy / np.linalg.norm(noisy, axis=-1, keepdims=True)).astype(np.float16))
