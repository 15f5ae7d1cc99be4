"""Descriptors of images: the strongest corners come first, and a blank image has none."""

import cv2
import numpy as np
from helpers.textured import textured

from sim.baselines.places import descriptors as module
from sim.baselines.places.descriptors import described, strongest_orb


def test_the_strongest_corners_come_first():
    image = textured(1)
    every = strongest_orb(image)
    orb = cv2.ORB.create(nfeatures=module.ORB_FEATURES, fastThreshold=7)
    keypoints, found = orb.detectAndCompute(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), None)
    strongest = int(np.argmax([keypoint.response for keypoint in keypoints]))
    np.testing.assert_array_equal(every[0], found[strongest])
    assert sorted(map(bytes, every)) == sorted(map(bytes, found))


def test_every_image_has_its_descriptors_and_a_blank_one_has_none():
    found = described([textured(1), np.full((240, 320, 3), 127, np.uint8), textured(2)])
    assert [len(each) > 50 for each in found.orb] == [len(each) > 50 for each in found.akaze] == [True, False, True]
    assert len(found.orb[1]) == len(found.akaze[1]) == 0
