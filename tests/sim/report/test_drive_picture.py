import cv2
import numpy as np
import pytest

from sim.report.drive_picture import drive_png
from worlds.house import build_house
from worlds.presets import sample_from_rooms, sample_house


def test_the_picture_shows_the_drive_and_marks_its_end():
    house = build_house(sample_from_rooms(("kitchen", "bedroom"), seed=21))
    x, y = house.rooms[0].polygon.representative_point().coords[0]
    way = np.array([[x - 0.5, y, 0.0], [x, y, 0.0], [x + 0.5, y, 0.0]])
    plain, drawn = (
        cv2.imdecode(np.frombuffer(drive_png(house, way, path, ("wall#1",)), np.uint8), cv2.IMREAD_COLOR)
        for path in (way[:1], way)
    )
    assert drawn.shape == plain.shape
    assert mean_column_of_red(drawn) - mean_column_of_red(plain) == pytest.approx(60.0, abs=3.0)  # a metre further right
    unnamed = cv2.imdecode(np.frombuffer(drive_png(house, way, way), np.uint8), cv2.IMREAD_COLOR)
    assert (unnamed != drawn).any()


def mean_column_of_red(picture):
    """Where the ring at the end of a drive is, in pixels from the left."""
    blue, green, red = np.moveaxis(picture.astype(int), -1, 0)
    return np.nonzero((red > 180) & (green < 90) & (blue < 90))[1].mean()


def test_two_visits_to_a_storey_are_not_joined_through_the_walls():
    house = build_house(sample_house("home", 3, clutter=0.0))
    z = house.storeys[1].floor_m
    above = np.array([[2.0, 2.0, z], [2.5, 2.0, z]])

    def drawn(apart_m):
        """Number of pixels that a path with two visits to the ground floor changes."""
        visits = [np.array([[x, 2.0, 0.0], [x + 0.5, 2.0, 0.0]]) for x in (1.0, 1.0 + apart_m)]
        path = np.concatenate([visits[0], above, visits[1], above])
        pictures = [
            cv2.imdecode(np.frombuffer(drive_png(house, above, p), np.uint8), cv2.IMREAD_COLOR) for p in (path, above)
        ]
        return (pictures[0] != pictures[1]).any(axis=2).sum()

    assert 0 < drawn(6.0) < 1.3 * drawn(2.0)
