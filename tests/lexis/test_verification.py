from dataclasses import replace

import numpy as np
import pytest
from helpers.box_room import FORWARD_CAMERA

from lexis.config import PoseGraphConfig, VerificationConfig
from lexis.graph.pose_graph import PoseGraph
from lexis.maths import se3
from lexis.maths.projection import project
from lexis.types import Features, Intrinsics, Keyframe, Landmarks, LoopDecision, LoopEdge
from lexis.verification import plausible, verify

CONFIG = VerificationConfig(ray_sigma_rad=1.5 / FORWARD_CAMERA.intrinsics.fx)
"""Settings for these tests, in which landmarks are exact and key points have an error of at most 0.5 px. With the default,
loops of so few landmarks would be uncertain."""
CONSISTENT = replace(CONFIG, max_contradiction=16.8)
"""Settings with which loops that contradict each other are refused."""
EMBEDDING = np.ones(1, np.float32)
STEP = np.diag(np.repeat([0.01, 0.02], 3) ** 2)


def keyframe(i, T_O_B, points, descriptors, landmarks=True, T_true=None, noise_px=0.0):
    """A keyframe that sees world points from `T_true`, while the odometry estimates `T_O_B`."""
    T_true = T_O_B if T_true is None else T_true
    in_body = se3.transform(se3.inverse(T_true), points)
    pixels = project(se3.transform(se3.inverse(FORWARD_CAMERA.T_B_C), in_body), FORWARD_CAMERA.intrinsics)
    pixels += np.random.default_rng(i).normal(0.0, noise_px, pixels.shape)
    ids = np.arange(len(points) if landmarks else 0)
    features = Features(pixels.astype(np.float32), descriptors)
    return Keyframe(i, i, 10.0 * i, T_O_B, STEP, EMBEDDING, features, Landmarks(in_body[ids], ids))


@pytest.fixture
def world(rng):
    points = rng.uniform([3.0, -2.5, -1.5], [7.0, 2.5, 2.0], (80, 3))
    return points, rng.integers(0, 256, (80, 61), np.uint8)


@pytest.fixture
def true():
    """The true poses of the query and of its candidate (the origin)."""
    return se3.exp(np.array([0.02, -0.03, 0.2, 0.4, -0.3, 0.1]))


def graph_of(*keyframes):
    graph = PoseGraph(PoseGraphConfig())
    for one in keyframes:
        graph.add_keyframe(one)
    return graph


def located(world, true, drift=None, noise_px=0.3, config=CONFIG):
    points, descriptors = world
    estimated = true if drift is None else drift @ true
    match = keyframe(0, np.eye(4), points, descriptors)
    query = keyframe(1, estimated, points, descriptors, landmarks=False, T_true=true, noise_px=noise_px)
    return verify(query, [0], graph_of(match, query), FORWARD_CAMERA, config).edges


def test_the_edge_is_the_true_relative_pose_whatever_the_odometry_drifted_to(world, true):
    drift = se3.exp(np.array([0.0, 0.0, 0.05, 0.3, 0.1, 0.0]))
    (edge,) = located(world, true, drift, noise_px=0.0)
    np.testing.assert_allclose(edge.T_match_query, true, atol=1e-4)
    assert (edge.query, edge.match) == (1, 0)
    assert edge.inliers >= 70


def test_the_covariance_is_that_of_repeated_measurements(world, true):
    points, descriptors = world
    config = replace(
        CONFIG, ray_sigma_rad=0.5 / FORWARD_CAMERA.intrinsics.fx, rotation_sigma_rad=1e-9, translation_sigma_m=1e-9
    )
    squared = []
    match = keyframe(0, np.eye(4), points, descriptors)
    for seed in range(100):
        query = replace(keyframe(seed, true, points, descriptors, landmarks=False, noise_px=0.5), id=1)
        (edge,) = verify(query, [0], graph_of(match, query), FORWARD_CAMERA, config).edges
        error = se3.log(se3.between(edge.T_match_query, true))
        squared.append(error @ np.linalg.solve(edge.covariance, error))
    assert 5.0 < np.mean(squared) < 7.5  # chi² with 6 degrees of freedom


def test_the_covariance_depends_on_directions_and_not_on_the_shape_of_pixels(world, true):
    match, query = keyframe(0, np.eye(4), *world), keyframe(1, true, *world)
    (edge,) = verify(query, [0], graph_of(match, query), FORWARD_CAMERA, CONFIG).edges
    of = FORWARD_CAMERA.intrinsics
    tall = replace(FORWARD_CAMERA, intrinsics=Intrinsics(of.width, 2 * of.height, of.fx, 2 * of.fy, of.cx, 2 * of.cy))
    high = replace(query, features=replace(query.features, keypoints=query.features.keypoints * np.float32([1, 2])))
    (same,) = verify(high, [0], graph_of(match, high), tall, CONFIG).edges
    np.testing.assert_allclose(same.covariance, edge.covariance, rtol=1e-2, atol=1e-6)


@pytest.mark.parametrize(
    ("drift", "gates"),
    [([0.0, 0.0, 0.0, 1.0, 0.0, 0.0], {"gate_m": 1.5}), ([0.0, 0.0, 0.3, 0.0, 0.0, 0.0], {"gate_rad": 0.4})],
)
def test_a_loop_too_far_from_the_estimate_or_too_much_turned_is_refused(world, true, drift, gates):
    far = se3.exp(np.array(drift))
    assert located(world, true, far) == ()
    assert len(located(world, true, far, config=replace(CONFIG, **gates))) == 1


@pytest.mark.parametrize("tilt", [0.0, 0.4])
def test_heights_have_to_fit_better_than_places_because_they_drift_less(world, tilt):
    """After a walk of 60 m back to its start, an edge may be 2 m off in the plan, but not in height."""
    points, descriptors = world
    tilted = se3.exp(np.array([tilt, tilt, 0.7, 0.0, 0.0, 0.0]))
    poses = [tilted.copy() for _ in range(3)]
    poses[1][0, 3] = 30.0
    graph = graph_of(*(keyframe(i, pose, points, descriptors) for i, pose in enumerate(poses)))
    cases = {
        (2.05, -0.92, 0.0): True,
        (0.0, 0.0, 1.0): True,
        (0.0, 0.0, 1.2): False,
        (0.0, 0.0, -2.0): False,
        (3.0, 0.0, 0.0): False,
    }
    for off, accepted in cases.items():
        moved = poses[2].copy()
        moved[:3, 3] += off
        edge = LoopEdge(2, 0, se3.between(poses[0], moved), 1e-4 * np.eye(6), 50)
        assert bool(plausible([(LoopDecision(2, 0, "accepted"), edge)], graph, VerificationConfig()).edges) is accepted


def test_another_place_is_refused(world, true, rng):
    points, descriptors = world
    match = keyframe(0, np.eye(4), points, rng.integers(0, 256, descriptors.shape, np.uint8))
    query = keyframe(1, true, points, descriptors)
    assert verify(query, [0], graph_of(match, query), FORWARD_CAMERA, CONFIG).edges == ()


def test_the_same_key_points_in_another_arrangement_are_refused(world, true, rng):
    points, descriptors = world
    match = keyframe(0, np.eye(4), points, descriptors)
    query = keyframe(1, true, rng.permutation(points), descriptors)
    assert verify(query, [0], graph_of(match, query), FORWARD_CAMERA, CONFIG).edges == ()


def test_inliers_in_one_corner_of_the_image_are_not_enough(world, true):
    points, descriptors = world
    poster = np.array([5.0, 1.0, 0.5]) + 0.05 * (points - points.mean(axis=0))
    assert located((poster, descriptors), true) == ()


def test_two_sightings_of_a_landmark_count_once(world, true, rng):
    """Ten landmarks, seen from two keyframes, agree. The other key points match but are geometrically inconsistent."""
    points, descriptors = world
    shuffled = np.concatenate([points[:10], rng.permutation(points[10:])])
    first, second = keyframe(0, np.eye(4), points, descriptors), keyframe(1, se3.exp(np.full(6, 0.01)), points, descriptors)
    query = keyframe(2, true, shuffled, descriptors)
    graph = graph_of(first, second, query)
    assert verify(query, [0, 1], graph, FORWARD_CAMERA, CONFIG).edges == ()
    assert len(verify(query, [0, 1], graph, FORWARD_CAMERA, replace(CONFIG, min_inliers=10)).edges) == 2


@pytest.mark.parametrize(("part", "setting"), [(slice(3, 6), "sure_sigma_m"), (slice(0, 3), "sure_sigma_rad")])
def test_a_loop_is_sure_up_to_its_largest_standard_deviation(world, true, part, setting):
    """The estimate is 0.4 m off: a sure loop may correct it, and an uncertain one may not."""
    drift = se3.exp(np.array([0.0, 0.0, 0.0, 0.4, 0.0, 0.0]))
    (edge,) = located(world, true, drift)
    worst = float(np.sqrt(np.linalg.eigvalsh(edge.covariance[part, part])[-1]))
    assert located(world, true, drift, config=replace(CONFIG, **{setting: 0.99 * worst})) == ()
    assert len(located(world, true, drift, config=replace(CONFIG, **{setting: 1.01 * worst}))) == 1


@pytest.mark.parametrize("angle", [0.09, 0.11])
def test_a_loop_with_inliers_in_few_cells_may_shift_the_estimate_but_not_turn_it(world, true, angle):
    """The estimate is 0.4 m off, and turned by a little less or a little more than the limit of 0.1 rad."""
    points, descriptors = world
    drift = se3.exp(np.array([0.0, 0.0, angle, 0.4, 0.0, 0.0]))
    match, query = keyframe(0, np.eye(4), points, descriptors), keyframe(1, drift @ true, points, descriptors, T_true=true)

    def decision(**settings):
        (found,) = verify(query, [0], graph_of(match, query), FORWARD_CAMERA, replace(CONFIG, **settings)).decisions
        return found

    cells = decision(gate_rad_m=0.05).cells
    assert cells > CONFIG.min_cells
    assert decision(gate_rad_m=0.05, min_cells_turned=cells).outcome == "accepted"
    turned = decision(gate_rad_m=0.05, min_cells_turned=cells + 1).outcome
    assert turned == ("uncertain pose" if angle > CONFIG.gate_rad else "accepted")


@pytest.mark.parametrize(
    ("off", "accepted"),
    [
        ((0.3, 0.0, 0.0, 0.0), True),
        ((0.4, 0.0, 0.0, 0.0), False),
        ((0.0, 0.0, 0.3, 0.0), True),
        ((0.0, 0.0, 0.4, 0.0), False),
        ((0.0, 0.0, 0.0, 0.09), True),
        ((0.0, 0.0, 0.0, 0.11), False),
    ],
)
def test_an_uncertain_loop_may_confirm_the_estimate_but_not_change_it_however_long_the_path(world, off, accepted):
    """After a walk of 60 m, a sure loop may be 2.3 m and 0.4 rad off; an uncertain one may be 0.35 m and 0.1 rad off."""
    points, descriptors = world
    poses = [np.eye(4) for _ in range(3)]
    poses[1][0, 3] = 30.0
    graph = graph_of(*(keyframe(i, pose, points, descriptors) for i, pose in enumerate(poses)))
    measured = se3.exp(np.array([0.0, 0.0, off[3], *off[:3]]))

    def outcome(sigma):
        edge = LoopEdge(2, 0, measured, sigma**2 * np.eye(6), 50)
        return plausible([(LoopDecision(2, 0, "accepted"), edge)], graph, VerificationConfig()).decisions[0].outcome

    assert outcome(0.01) == "accepted"
    assert outcome(0.1) == ("accepted" if accepted else "uncertain pose")


def test_neighbours_lend_their_landmarks(world, true):
    points, descriptors = world
    first = keyframe(0, np.eye(4), points[:12], descriptors[:12])
    second = keyframe(1, se3.exp(np.full(6, 0.01)), points[12:24], descriptors[12:24])
    query = keyframe(2, true, points, descriptors)
    graph = graph_of(first, second, query)
    assert verify(query, [0], graph, FORWARD_CAMERA, replace(CONFIG, pool=0)).edges == ()
    (edge,) = verify(query, [0], graph, FORWARD_CAMERA, CONFIG).edges
    np.testing.assert_allclose(edge.T_match_query, true, atol=1e-3)


def test_edges_come_best_first_and_no_more_than_asked_for(world, true):
    points, descriptors = world
    earlier = [keyframe(i, np.eye(4), points[: 30 + 10 * i], descriptors[: 30 + 10 * i]) for i in range(5)]
    query = keyframe(5, true, points, descriptors)
    edges = verify(query, range(5), graph_of(*earlier, query), FORWARD_CAMERA, replace(CONFIG, pool=0, max_edges=2)).edges
    assert [edge.match for edge in edges] == [4, 3]


def test_a_keyframe_without_landmarks_is_refused(world, true):
    points, descriptors = world
    match = keyframe(0, np.eye(4), points, descriptors, landmarks=False)
    query = keyframe(1, true, points, descriptors)
    assert verify(query, [0], graph_of(match, query), FORWARD_CAMERA, CONFIG).edges == ()


def test_the_edge_does_not_depend_on_the_last_bits_of_landmarks(world, true, rng):
    """Processors sum in different orders, and RANSAC can turn a difference in the last digits into another pose."""
    points, descriptors = world
    match = keyframe(0, np.eye(4), points, descriptors)
    query = keyframe(1, true, points, descriptors, landmarks=False, noise_px=2.0)
    (expected,) = verify(query, [0], graph_of(match, query), FORWARD_CAMERA, CONFIG).edges
    for _ in range(5):
        last_bits = rng.uniform(-1e-15, 1e-15, match.landmarks.points.shape)
        shaken = replace(match, landmarks=replace(match.landmarks, points=match.landmarks.points + last_bits))
        (edge,) = verify(query, [0], graph_of(shaken, query), FORWARD_CAMERA, CONFIG).edges
        assert (edge.T_match_query == expected.T_match_query).all() and edge.inliers == expected.inliers


def test_every_candidate_gets_a_decision_that_says_why(world, true, rng):
    points, descriptors = world
    other = rng.integers(0, 256, descriptors.shape, np.uint8)
    poster = np.array([5.0, 1.0, 0.5]) + 0.05 * (points - points.mean(axis=0))

    def decision(seen, known=descriptors, query_points=None, drift=None, config=CONFIG):
        match = keyframe(0, np.eye(4), seen, known)
        estimated = true if drift is None else drift @ true
        query = keyframe(1, estimated, seen if query_points is None else query_points, descriptors, T_true=true)
        verified = verify(query, [0], graph_of(match, query), FORWARD_CAMERA, config)
        (found,) = verified.decisions
        assert (found.query, found.match) == (1, 0)
        assert len(verified.edges) == (found.outcome == "accepted")
        return found

    good = decision(points)
    assert good.outcome == "accepted" and good.matches == good.inliers == 80 and good.cells >= CONFIG.min_cells
    assert good.misfit_m < 1e-3 and good.misfit_rad < 1e-3
    assert decision(points, other).outcome == "few matches"
    scattered = decision(points, query_points=rng.permutation(points))
    assert scattered.outcome == "few inliers" and scattered.inliers < CONFIG.min_inliers <= scattered.matches
    crowded = decision(poster)
    assert crowded.outcome == "crowded inliers" and crowded.cells < CONFIG.min_cells and crowded.misfit_m is None
    aside = se3.exp(np.array([0.0, 0.0, 0.0, 0.4, 0.0, 0.0]))
    assert decision(points * 8.0, drift=aside).outcome == "uncertain pose"
    assert decision(points, drift=aside).outcome == decision(points * 8.0).outcome == "accepted"
    far = decision(points, drift=se3.exp(np.array([0.0, 0.0, 0.0, 3.0, 0.0, 0.0])))
    assert far.outcome == "far from the estimate" and far.misfit_m == pytest.approx(3.0, abs=0.01)


def test_candidates_with_fewer_inliers_than_the_best_are_surplus(world, true):
    points, descriptors = world
    earlier = [keyframe(i, np.eye(4), points[: 30 + 10 * i], descriptors[: 30 + 10 * i]) for i in range(5)]
    query = keyframe(5, true, points, descriptors)
    config = replace(CONFIG, pool=0, max_edges=2)
    verified = verify(query, range(5), graph_of(*earlier, query), FORWARD_CAMERA, config)
    assert [decision.outcome for decision in verified.decisions] == ["surplus"] * 3 + ["accepted"] * 2
    assert {edge.match for edge in verified.edges} == {3, 4}


def judged(world, true, errors_m, inliers, order=None, step_m=0.5, config=CONSISTENT):
    """Outcomes of loops from one query to keyframes on a straight path, by match; the loops have errors in x."""
    count = len(errors_m)
    poses = [*(se3.exp(np.array([0.0, 0.0, 0.0, step_m * i, 0.0, 0.0])) for i in range(count)), true]
    graph = graph_of(*(keyframe(i, pose, *world) for i, pose in enumerate(poses)))
    covariance = np.diag(np.repeat([0.005, 0.03], 3) ** 2)
    located = []
    for i in range(count) if order is None else order:
        measured = se3.between(poses[i], true) @ se3.exp(np.array([0.0, 0.0, 0.0, errors_m[i], 0.0, 0.0]))
        located.append((LoopDecision(count, i, "accepted"), LoopEdge(count, i, measured, covariance, inliers[i])))
    verified = plausible(located, graph, config)
    outcomes = {decision.match: decision.outcome for decision in verified.decisions}
    assert {edge.match for edge in verified.edges} == {match for match, outcome in outcomes.items() if outcome == "accepted"}
    return outcomes


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
def test_a_loop_that_contradicts_the_others_of_its_query_is_refused(world, true, order):
    outcomes = judged(world, true, [0.0, 0.3, 0.01], [30, 50, 40], order)
    assert outcomes == {0: "accepted", 1: "contradicted", 2: "accepted"}


def test_of_two_loops_that_contradict_each_other_the_one_with_more_inliers_is_kept(world, true):
    assert judged(world, true, [0.0, 0.3], [30, 50]) == {0: "contradicted", 1: "accepted"}


def test_loops_with_errors_within_their_covariances_agree(world, true):
    assert set(judged(world, true, [0.0, 0.06, -0.06], [30, 50, 40]).values()) == {"accepted"}


def test_no_two_loops_that_are_kept_contradict_each_other(world, true):
    outcomes = judged(world, true, [-0.12, 0.12, 0.0], [50, 40, 30])
    assert outcomes == {0: "accepted", 1: "contradicted", 2: "accepted"}


def test_loops_to_different_places_are_not_compared_because_the_right_one_may_have_fewer_inliers(world, true):
    config = replace(CONSISTENT, gate_m=9.0)
    assert set(judged(world, true, [0.0, 3.0], [30, 50], step_m=10.0, config=config).values()) == {"accepted"}


@pytest.mark.parametrize("sessions", [(0, 0, 1, 1, 1), (0, 0, 0, 1, 1)])
def test_loops_to_two_sessions_are_not_compared_because_nobody_walked_from_one_to_the_other(world, true, sessions):
    covariance = np.diag(np.repeat([0.005, 0.03], 3) ** 2)
    there = se3.exp(np.array([0.0, 0.0, 0.0, 20.0, 0.0, 0.0]))
    poses = [np.eye(4), there, np.eye(4), there, there @ true]
    graph = graph_of(
        *(
            replace(keyframe(i, T, *world), session=session)
            for i, (T, session) in enumerate(zip(poses, sessions, strict=True))
        )
    )
    off = se3.exp(np.array([0.0, 0.0, 0.0, 0.3, 0.0, 0.0]))
    edges = [LoopEdge(4, 1, true, covariance, 50), LoopEdge(4, 3, true @ off, covariance, 40)]
    verified = plausible([(LoopDecision(4, edge.match, "accepted"), edge) for edge in edges], graph, CONSISTENT)
    assert [decision.outcome for decision in verified.decisions] == ["accepted", "accepted"]


def test_by_default_loops_are_not_compared_with_each_other(world, true):
    assert set(judged(world, true, [0.0, 0.3], [30, 50], config=CONFIG).values()) == {"accepted"}
