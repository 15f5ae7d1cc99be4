"""bench encoders: figures of an encoder that knows what it is said to know, and the ceiling of what is visible."""

import zlib
from dataclasses import fields

import numpy as np
import pytest
import torch

from lexis.encoder import OpenClipEncoder
from lexis.preprocessing import squashing
from lexis.prompts import prompts
from sim.bench import encoders
from sim.bench.encoders import ceiling_of, measure, overall_calibration_error
from sim.errors import SimError
from sim.training.frames import PATCHES, THINGS, Frames
from sim.training.phrases import OBJECT_NAMES, ROOM_ACTIVITIES, ROOM_NAMES
from worlds.labels import ROOM_LABELS

ROOMS = np.repeat([0, 3, 5, 7], 6)


def painted(rooms, rng):
    """Frames whose pixels name the room, where each room has a thing of its own."""
    n = len(rooms)
    things = rng.integers(0, 3, (n, *PATCHES, len(THINGS))).astype(np.uint8)
    things[np.arange(n), ..., rooms] = 60
    images = np.tile(rooms.astype(np.uint8)[:, None, None, None], (1, 6, 8, 3))
    return Frames(images, rooms, things, np.zeros((n, len(ROOM_LABELS)), np.float32), np.ones(n, np.float32))


class Knowing(OpenClipEncoder):
    """Reads the room off the pixels; knows trained names, activities and things, and nothing else."""

    def __init__(self, temperature):
        model = torch.nn.Module()
        model.logit_scale = torch.nn.Parameter(torch.tensor(-np.log(temperature)))
        super().__init__("knowing", model, None, squashing(1, 1))
        self._known = {name: i for i, label in enumerate(ROOM_LABELS) for name in ROOM_NAMES[label]}
        self._known |= {done: i for i, label in enumerate(ROOM_LABELS) for done in ROOM_ACTIVITIES[label]}
        self._known |= {name: i for i in set(ROOMS) for name in OBJECT_NAMES.get(THINGS[i], (THINGS[i],))}

    def encode_image(self, image):
        return np.eye(len(ROOM_LABELS), dtype=np.float32)[image[0, 0, 0]]

    def encode_texts(self, texts):
        said = [max((name for name in self._known if name in text), key=len, default=None) for text in texts]
        return np.array(
            [self._noise(t) if s is None else self._one(self._known[s]) for s, t in zip(said, texts, strict=True)]
        )

    def encode_rooms(self, names):
        known = [name in self._known for name in names]
        return np.array(
            [self._one(self._known[n]) if k else self._noise(prompts(n)[0]) for n, k in zip(names, known, strict=True)]
        )

    def _one(self, i):
        return np.eye(len(ROOM_LABELS), dtype=np.float32)[i]

    def _noise(self, text):
        return np.random.default_rng(zlib.crc32(text.encode())).normal(size=len(ROOM_LABELS)).astype(np.float32)


@pytest.fixture
def houses(monkeypatch):
    monkeypatch.setattr(encoders, "frames_of_house", lambda draw, views: painted(ROOMS, np.random.default_rng(draw.seed)))


def test_what_an_encoder_knows_counts_and_what_it_does_not_know_is_chance(houses):
    (house,) = measure(Knowing(0.1), "home", [4], None)
    row = house.row
    assert house.seed == 4 and row.ceiling is None
    assert row.accuracy == row.trained_names == row.activities_found == row.things_found == 1.0
    assert row.held_out_names < 0.7
    assert row.calibration_error < 1e-3


def test_doubt_of_what_is_right_is_a_calibration_error(houses):
    houses = list(measure(Knowing(10.0), "home", [4, 5], None))
    assert [house.row.accuracy for house in houses] == [1.0, 1.0]
    assert (
        overall_calibration_error(houses) == pytest.approx(houses[0].row.calibration_error) == pytest.approx(0.75, abs=0.05)
    )


def test_the_ceiling_is_what_visible_things_tell(tmp_path):
    pytest.importorskip("sklearn")
    with pytest.raises(SimError, match="no frames"):
        ceiling_of(tmp_path)
    (tmp_path / "frames").mkdir()
    rng = np.random.default_rng(0)
    frames = painted(np.repeat(ROOMS, 5), rng)
    np.savez(tmp_path / "frames" / "a.npz", **{f.name: getattr(frames, f.name) for f in fields(Frames)})
    scores = ceiling_of(tmp_path)(painted(ROOMS, rng))
    assert scores.shape == (len(ROOMS), len(ROOM_LABELS)) and (scores.argmax(axis=1) == ROOMS).all()
