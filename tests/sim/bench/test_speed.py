"""The benchmark of speed releases the GL contexts of its renderers."""

import numpy as np
import pytest

from sim.bench import speed as module
from sim.errors import SimError
from worlds.house import build_house
from worlds.presets import sample_from_rooms


class Renderer:
    """A renderer that does nothing; the class counts how many renderers are open."""

    open = 0

    def __init__(self, *_, **__):
        Renderer.open += 1

    def close(self):
        Renderer.open -= 1


def test_renderers_are_closed_after_an_error(monkeypatch):
    def no_context(*_):
        raise SimError("no GL context")

    monkeypatch.setattr(module, "PlainRenderer", Renderer)
    monkeypatch.setattr(module, "CameraRenderer", no_context)
    house = build_house(sample_from_rooms(("kitchen", "bedroom"), seed=21))
    with pytest.raises(SimError, match="no GL context"):
        list(module._frames(house, np.tile(np.eye(4), (12, 1, 1)), (320, 240)))
    assert Renderer.open == 0
