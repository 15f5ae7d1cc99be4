import cv2
import numpy as np
import pytest
from helpers.box_room import BoxRoom

from lexis.config import LandmarkConfig
from lexis.features import FeatureExtractor, mutual_matches


@pytest.fixture
def image(rng):
    T = np.eye(4)
    T[:3, 3] = 2.0, 2.0, 1.2
    return BoxRoom((5.0, 4.0, 2.5), rng).render(T)


def brute_force(first, second, ratio, allowed):
    bits = np.bitwise_count(first[:, None] ^ second[None]).sum(axis=2).astype(float)
    bits[~allowed] = np.inf
    pairs = []
    for i, row in enumerate(bits):
        if not np.isfinite(row).any():
            continue
        j, others = row.argmin(), np.sort(np.append(row, np.inf))
        if bits[:, j].argmin() == i and others[0] <= ratio * others[1]:
            pairs.append((i, int(j)))
    return pairs


def test_matches_of_a_warped_image_follow_the_warp(image):
    extractor = FeatureExtractor(LandmarkConfig())
    turn = cv2.getRotationMatrix2D((160, 120), 10, 0.95)
    first = extractor.extract(image)
    second = extractor.extract(cv2.warpAffine(image, turn, (320, 240)))
    pairs = mutual_matches(first.descriptors, second.descriptors, 0.8)
    errors = second.keypoints[pairs[:, 1]] - (first.keypoints[pairs[:, 0]] @ turn[:, :2].T + turn[:, 2])
    assert len(pairs) > 100
    assert np.median(np.linalg.norm(errors, axis=1)) < 0.5
    assert np.abs(np.median(errors, axis=0)).max() < 0.1  # the origin of pixel coordinates is the same for both


def test_no_more_key_points_than_asked_for(image):
    assert len(FeatureExtractor(LandmarkConfig(max_features=50)).extract(image).keypoints) <= 50


def test_a_bare_wall_has_no_features():
    features = FeatureExtractor(LandmarkConfig()).extract(np.full((240, 320, 3), 128, np.uint8))
    assert features.keypoints.shape == (0, 2)
    assert features.descriptors.shape == (0, 61)


@pytest.mark.parametrize(("n", "m"), [(40, 30), (5, 1), (1, 5), (0, 3), (3, 0)])
def test_matching_agrees_with_brute_force(n, m, rng):
    first, second = rng.integers(0, 256, (n, 61), np.uint8), rng.integers(0, 256, (m, 61), np.uint8)
    for i in range(0, min(n, m), 2):  # half of the descriptors are true pairs that differ by a few bits
        second[i] = first[i] ^ (rng.random(61) < 0.2).astype(np.uint8)
    allowed = rng.random((n, m)) < 0.5
    everything = np.ones((n, m), bool)
    assert [tuple(p) for p in mutual_matches(first, second, 0.8).tolist()] == brute_force(first, second, 0.8, everything)
    guided = mutual_matches(first, second, 0.8, allowed)
    assert [tuple(p) for p in guided.tolist()] == brute_force(first, second, 0.8, allowed)


def test_a_lone_candidate_has_to_be_near():
    first, second = np.zeros((1, 61), np.uint8), np.full((1, 61), 255, np.uint8)
    assert len(mutual_matches(first, second, 0.8)) == 1
    assert len(mutual_matches(first, second, 0.8, max_distance=100)) == 0


def test_a_descriptor_that_equals_two_others_is_ambiguous(rng):
    first = rng.integers(0, 256, (3, 61), np.uint8)
    twice = np.concatenate([first, first[:1]])
    assert mutual_matches(first, twice, 0.8)[:, 0].tolist() == [1, 2]
    assert mutual_matches(first, first, 0.8).tolist() == [[0, 0], [1, 1], [2, 2]]
