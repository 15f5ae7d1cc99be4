import cv2
import numpy as np

from sim.report.drive_picture import drive_png
from worlds.house import build_house
from worlds.presets import sample_from_rooms


def test_the_picture_shows_the_drive_and_rings_its_end():
    house = build_house(sample_from_rooms(("kitchen", "bedroom"), seed=21))
    x, y = house.rooms[0].polygon.representative_point().coords[0]
    way = np.array([[x - 0.5, y, 0.0], [x, y, 0.0], [x + 0.5, y, 0.0]])
    plain, drawn = (
        cv2.imdecode(np.frombuffer(drive_png(house, way, path, ("wall#1",)), np.uint8), cv2.IMREAD_COLOR)
        for path in (way[:1], way)
    )
    blue, green, red = np.moveaxis(drawn.astype(int), -1, 0)
    assert ((red > 180) & (green < 90) & (blue < 90)).sum() > 20  # the ring
    assert drawn.shape == plain.shape and (drawn != plain).any()
