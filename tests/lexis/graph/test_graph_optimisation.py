import numpy as np
import pytest

from lexis.config import PoseGraphConfig
from lexis.errors import LexisError
from lexis.graph.graph_optimisation import GraphOptimiser, loop_weights
from lexis.maths import se3
from lexis.types import LoopEdge

CONFIG = PoseGraphConfig()
STEP_COVARIANCE = np.diag(np.repeat([0.01, 0.03], 3) ** 2)
LOOP_COVARIANCE = np.diag(np.repeat([0.005, 0.02], 3) ** 2)


def circle(count):
    """Poses on two laps of a circle, facing along it."""
    step = se3.exp(np.array([0.0, 0.0, 4 * np.pi / count, 0.5, 0.0, 0.0]))
    T = [np.eye(4)]
    for _ in range(count - 1):
        T.append(T[-1] @ step)
    return np.stack(T)


@pytest.fixture
def true():
    return circle(40)


@pytest.fixture
def drifting(true, rng):
    """Noisy odometry steps, and the poses that result from chaining them."""
    noise = se3.exp(rng.multivariate_normal(np.zeros(6), STEP_COVARIANCE, len(true) - 1))
    steps = se3.between(true[:-1], true[1:]) @ noise
    T = [true[0]]
    for step in steps:
        T.append(T[-1] @ step)
    return steps, np.stack(T)


def loops_between(true, pairs):
    return [LoopEdge(j, i, se3.between(true[i], true[j]), LOOP_COVARIANCE, 50) for i, j in pairs]


def solve(T, steps, loops, covariance=STEP_COVARIANCE, config=CONFIG):
    return optimiser(T, steps, loops, covariance, config).optimise()


def optimiser(T, steps, loops, covariance=STEP_COVARIANCE, config=CONFIG):
    graph = GraphOptimiser(T[0], config)
    for pose, step in zip(T[1:], steps, strict=True):
        graph.add_keyframe(pose, step, covariance)
    graph.add_loops(loops)
    return graph


def error(T, true):
    return np.linalg.norm(T[:, :3, 3] - true[:, :3, 3], axis=1).max()


def test_odometry_alone_is_a_fixed_point(drifting):
    steps, T = drifting
    np.testing.assert_allclose(solve(T, steps, []), T, atol=1e-6)


def test_perfect_odometry_with_true_loops_is_a_fixed_point(true):
    loops = loops_between(true, [(0, 20), (5, 25)])
    result = solve(true, se3.between(true[:-1], true[1:]), loops)
    np.testing.assert_allclose(result, true, atol=1e-6)
    np.testing.assert_allclose(loop_weights(result, loops, CONFIG), 1.0)


def test_true_loops_take_the_drift_away(true, drifting):
    steps, T = drifting
    loops = loops_between(true, [(k, 20 + k) for k in range(0, 20, 3)] + [(0, 39)])
    result = solve(T, steps, loops)
    assert error(result, true) < 0.5 * error(T, true)
    assert (loop_weights(result, loops, CONFIG) > 0.5).all()


def test_the_first_pose_stays(true, drifting):
    steps, T = drifting
    np.testing.assert_allclose(solve(T, steps, loops_between(true, [(0, 39)]))[0], T[0], atol=1e-6)


def test_the_result_moves_with_the_world_frame(true, drifting, rng):
    steps, T = drifting
    elsewhere = se3.exp(rng.normal(size=6))
    loops = loops_between(true, [(0, 20), (10, 35)])
    here, there = solve(T, steps, loops), solve(elsewhere @ T, steps, loops)
    np.testing.assert_allclose(there, elsewhere @ here, atol=1e-4)


def test_a_false_loop_is_rejected_among_true_ones(true, drifting):
    steps, T = drifting
    loops = loops_between(true, [(k, 20 + k) for k in range(0, 20, 3)])
    false = LoopEdge(30, 3, se3.exp(np.array([0.0, 0, 0.3, 1.0, 1.0, 0.0])), LOOP_COVARIANCE, 50)
    with_false = solve(T, steps, [*loops, false])
    weights = loop_weights(with_false, [*loops, false], CONFIG)
    assert weights[-1] < 0.5
    assert (weights[:-1] > 0.5).all()
    assert error(with_false, true) < error(solve(T, steps, loops), true) + 0.02


def false_loops(rng, count):
    """Loops between random keyframes whose relative poses are random, too."""
    ends = np.sort(rng.choice(40, (count, 2)), axis=1) + [0, 1]
    motions = se3.exp(rng.normal(size=(count, 6)) * [0.0, 0.0, 1.0, 2.0, 2.0, 0.0])
    return [
        LoopEdge(int(min(j, 39)), int(min(i, j - 1)), motion, LOOP_COVARIANCE, 50)
        for (i, j), motion in zip(ends, motions, strict=True)
    ]


@pytest.mark.parametrize("kernel", ["dcs", "gnc"])
def test_as_many_false_loops_as_true_ones_are_rejected(true, drifting, rng, kernel):
    steps, T = drifting
    config = PoseGraphConfig(kernel=kernel)
    loops, false = loops_between(true, [(k, 20 + k) for k in range(0, 20, 2)]), false_loops(rng, 10)
    without, found = (solve(T, steps, each, config=config) for each in (loops, [*loops, *false]))
    weights = loop_weights(found, [*loops, *false], config)
    assert (weights[:10] > 0.5).all() and (weights[10:] < 0.5).all()
    assert error(found, true) < error(without, true) + 0.02


@pytest.mark.parametrize("kernel", ["dcs", "gnc", "huber", "none"])
def test_without_false_loops_every_kernel_finds_the_least_squares_solution(true, drifting, kernel):
    steps, T = drifting
    loops = loops_between(true, [(k, 20 + k) for k in range(0, 20, 3)])
    config = PoseGraphConfig(kernel=kernel, outlier_threshold=1e4)
    found = solve(T, steps, loops, config=config)
    np.testing.assert_allclose(found, solve(T, steps, loops, config=PoseGraphConfig(kernel="none")), atol=1e-3)
    np.testing.assert_allclose(loop_weights(found, loops, config), 1.0)


def test_kernels_trust_a_false_loop_less_the_more_robust_they_are(true, drifting):
    steps, T = drifting
    loops = loops_between(true, [(k, 20 + k) for k in range(0, 20, 3)])
    loops.append(LoopEdge(30, 3, se3.exp(np.array([0.0, 0, 0.3, 1.0, 1.0, 0.0])), LOOP_COVARIANCE, 50))
    configs = [PoseGraphConfig(kernel=kernel) for kernel in ("none", "huber", "dcs", "gnc")]
    found = [solve(T, steps, loops, config=config) for config in configs]
    weights = [loop_weights(T_W_B, loops, config)[-1] for T_W_B, config in zip(found, configs, strict=True)]
    assert weights == sorted(weights, reverse=True) and weights[0] == 1.0 and weights[-1] == 0.0
    assert error(found[0], true) > 2 * error(found[2], true)


def test_odometry_that_claims_no_error_still_gives_a_solution(true):
    steps = se3.between(true[:-1], true[1:])
    result = solve(true, steps, loops_between(true, [(0, 20)]), np.zeros((6, 6)))
    np.testing.assert_allclose(result, true, atol=1e-6)


def test_what_comes_later_changes_no_more_than_if_it_had_been_there_at_once(true, drifting):
    """Optimising twice, with keyframes and a loop in between, ends where one optimisation of everything ends."""
    steps, T = drifting
    first, second = loops_between(true, [(0, 20), (3, 23)]), loops_between(true, [(10, 35), (0, 39)])
    growing = optimiser(T[:30], steps[:29], first)
    found = growing.optimise()
    for step in steps[29:]:
        found = np.concatenate([found, (found[-1] @ step)[None]])
        growing.add_keyframe(found[-1], step, STEP_COVARIANCE)
    growing.add_loops(second)
    np.testing.assert_allclose(growing.optimise(), solve(T, steps, [*first, *second]), atol=2e-3)


def test_a_graph_of_one_keyframe_is_solved():
    result = solve(np.eye(4)[None], [], [])
    np.testing.assert_allclose(result, np.eye(4)[None], atol=1e-9)
    assert loop_weights(result, [], CONFIG).shape == (0,)


@pytest.mark.parametrize(("match", "query"), [(0, 40), (-1, 3), (3, 3), (5, 2)])
def test_loops_outside_the_graph_are_named(true, drifting, match, query):
    steps, T = drifting
    with pytest.raises(LexisError, match=f"{match} -> {query}"):
        solve(T, steps, [LoopEdge(query, match, np.eye(4), LOOP_COVARIANCE, 50)])


def test_a_window_of_the_whole_graph_gives_the_same_as_the_whole_graph(true, drifting):
    steps, T = drifting
    loops = loops_between(true, [(k, 20 + k) for k in range(0, 20, 3)])
    for count in (40, 100):
        np.testing.assert_allclose(optimiser(T, steps, loops).optimise_last(count), solve(T, steps, loops), atol=1e-9)


@pytest.mark.parametrize("kernel", ["dcs", "gnc", "huber", "none"])
def test_a_window_is_at_the_optimum_of_the_whole_graph_if_the_poses_before_it_are(true, drifting, rng, kernel):
    steps, T = drifting
    config = PoseGraphConfig(kernel=kernel)
    loops = loops_between(true, [(k, 20 + k) for k in range(0, 20, 2)]) + false_loops(rng, 3)
    best = solve(T, steps, loops, config=config)
    again = optimiser(best, steps, loops, config=config)
    again.optimise()
    np.testing.assert_allclose(again.optimise_last(8), best[-8:], atol=1e-3)


def test_a_window_leaves_earlier_poses_where_they_are_and_moves_with_the_world_frame(true, drifting, rng):
    steps, T = drifting
    loops, elsewhere = loops_between(true, [(5, 36), (8, 39)]), se3.exp(rng.normal(size=6))
    here, there = optimiser(T, steps, loops), optimiser(elsewhere @ T, steps, loops)
    window = here.optimise_last(10)
    assert len(window) == 10 and np.linalg.norm(window[-1, :3, 3] - T[-1, :3, 3]) > 0.005
    np.testing.assert_allclose(there.optimise_last(10), elsewhere @ window, atol=1e-4)
    fixed = optimiser(T, steps, [])
    fixed.optimise_last(10)
    np.testing.assert_allclose(fixed.optimise(), T, atol=1e-6)
