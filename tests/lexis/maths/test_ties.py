"""Ties: values that differ only by rounding lead to the same choice, whatever the order of summation and of neighbours."""

from dataclasses import replace
from itertools import permutations

import numpy as np
from helpers.map_builder import build_map, corridor_with_offices
from hypothesis import given
from hypothesis import strategies as st

from lexis.config import LabelConfig
from lexis.map.folder import load_map, save_map
from lexis.maths.ties import near_pairs, nearest_others, reaches, rounded
from lexis.planning import plan
from lexis.room_labels import label_keyframes, similarities

LAST_BITS = 1e-15
"""Larger than the change caused by another order of summation."""


@given(seed=st.integers(0, 2**32 - 1))
def test_settled_values_of_any_order_of_summation_are_equal(seed):
    rng = np.random.default_rng(seed)
    terms = rng.uniform(-1.0, 1.0, 9)
    sums = [rounded(np.array([rng.permutation(terms).sum()]))[0] for _ in range(10)]
    assert len(set(sums)) == 1


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 30), count=st.integers(1, 9))
def test_nearest_points_are_the_first_by_distance_then_index(seed, n, count):
    """On a grid, most distances occur several times."""
    points = np.random.default_rng(seed).integers(0, 4, (n, 2)).astype(float)
    found = nearest_others(points, count)
    for i, row in enumerate(found):
        others = [j for j in range(n) if j != i]
        ordered = sorted(others, key=lambda j, i=i: (np.linalg.norm(points[j] - points[i]), j))
        assert row.tolist() == sorted(ordered[:count])


@given(seed=st.integers(0, 2**32 - 1), n=st.integers(0, 30), distance=st.sampled_from([0.3, 0.5, 1.0]))
def test_near_pairs_do_not_depend_on_the_last_digits(seed, n, distance):
    """On a grid of 0.1 m, many distances are equal to the limit but for rounding errors."""
    rng = np.random.default_rng(seed)
    points = rng.integers(0, 8, (n, 2)) * 0.1
    expected = [
        [i, j] for i in range(n) for j in range(i + 1, n) if np.linalg.norm(points[i] - points[j]) <= distance + 1e-7
    ]
    for noise in (0.0, 1e-9):
        found = near_pairs(points + noise * rng.standard_normal(points.shape), distance)
        assert sorted(found.tolist()) == expected


def test_steps_that_add_up_to_a_spacing_reach_it_in_every_order(rng):
    """Sums of 0.1 m fall short of 0.3 m or exceed it by the last bit, depending on the order."""
    for _ in range(100):
        steps = rng.uniform(0.0, 1.0, 8)
        spacing = float(np.sum(steps))
        assert all(reaches(sum(rng.permutation(steps).tolist()), spacing) for _ in range(10))
        assert not reaches(spacing - 1e-5, spacing)


def test_nearest_points_do_not_depend_on_the_last_bits_of_positions(rng):
    """On a walk at constant speed, the previous and the next keyframe are equally near."""
    points = np.stack([0.5 * np.arange(40), np.zeros(40), np.zeros(40)], axis=1)
    shaken = points + rng.uniform(-LAST_BITS, LAST_BITS, points.shape)
    assert (nearest_others(points, 4) == nearest_others(shaken, 4)).all()


def plans(lexis_map):
    """All plans between two labels."""
    labels = sorted({room.label for room in lexis_map.rooms})
    return {pair: plan(lexis_map, *pair).keyframes for pair in permutations(labels, 2)}


def test_a_saved_map_plans_as_the_live_one_does(rng, tmp_path):
    """Embeddings are stored in single precision. The live map and the loaded one must still lead to the same decisions."""
    built = corridor_with_offices(rng)
    text = rng.normal(size=(3, 16)).astype(np.float32)
    scores = similarities(np.array([keyframe.embedding for keyframe in built.keyframes]), text)
    live = replace(built, similarities=scores)
    save_map(live, tmp_path / "map")
    loaded = load_map(tmp_path / "map")
    assert loaded.similarities.dtype == live.similarities.dtype and (loaded.similarities == live.similarities).all()
    assert plans(loaded) == plans(live)


def test_the_choice_of_equally_long_paths_does_not_depend_on_the_last_bits(rng):
    """Around a square block, both paths are equally long."""
    side = np.arange(0.0, 3.0, 0.5)
    zero, end = np.zeros(6), np.full(6, 3.0)
    x = np.concatenate([side, end, 3.0 - side, zero])
    y = np.concatenate([zero, side, end, 3.0 - side])
    positions = np.stack([x, y, np.zeros(24)], axis=1)
    positions = np.concatenate([positions, positions[:1] + 1e-4])
    labels = np.array([0] * 3 + [2] * 9 + [1] * 1 + [2] * 12)
    rooms = [("office", range(3)), ("kitchen", [12]), ("corridor", [*range(3, 12), *range(13, 25)])]
    lexis_map = build_map(positions, labels, rooms, ("office", "kitchen", "corridor"), rng)
    chosen = plan(lexis_map, "office", "kitchen").keyframes
    for _ in range(20):
        poses = lexis_map.T_W_B.copy()
        poses[:, :3, 3] += rng.uniform(-1e-12, 1e-12, (25, 3))
        assert plan(replace(lexis_map, T_W_B=poses), "office", "kitchen").keyframes == chosen


def test_labels_do_not_depend_on_the_last_bits(rng):
    """A walk along a corridor and back at constant speed, with images that repeat exactly, gives ties everywhere."""
    x = np.concatenate([np.arange(20), np.arange(20)[::-1]]) * 0.5
    positions = np.stack([x, np.zeros(40), np.zeros(40)], axis=1)
    scores = rng.choice([0.1, 0.2, 0.3], (40, 3))
    expected = label_keyframes(scores, positions, ("kitchen", "office", "corridor"), LabelConfig())
    for _ in range(20):
        shaken = scores + rng.uniform(-LAST_BITS, LAST_BITS, scores.shape)
        moved = positions + rng.uniform(-LAST_BITS, LAST_BITS, positions.shape)
        labels = label_keyframes(shaken, moved, ("kitchen", "office", "corridor"), LabelConfig())
        assert (labels.baseline == expected.baseline).all() and (labels.refined == expected.refined).all()
