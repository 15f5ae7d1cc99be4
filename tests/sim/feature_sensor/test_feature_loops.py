"""Loops without key points: they are confirmed at the fitted rates, from the surfaces that two views truly share."""

from dataclasses import fields, replace
from itertools import combinations

import numpy as np
import pytest
from helpers.viewpoints import turned

from lexis.config import PoseGraphConfig, VerificationConfig
from lexis.graph.pose_graph import PoseGraph
from lexis.maths import se3
from lexis.types import NO_FEATURES, NO_LANDMARKS, Keyframe, LoopArrays, LoopEdge
from sim.feature_fitting.fit_loops import Trials, fit_loops, judged
from sim.feature_sensor.covisibility_verifier import (
    PREDICTORS,
    CovisibilityVerifier,
    LoopModel,
    MeasuredEdges,
    fit_logistic,
    predictors,
)
from sim.feature_sensor.ray_origins import RayGrid
from sim.feature_sensor.surroundings import survey
from sim.feature_sensor.true_view import mistaken_by, true_views
from sim.feature_sensor.visible_shares import look
from sim.render.camera import wide_camera
from worlds.house import build_house
from worlds.presets import sample_house
from worlds.spec import HouseSpec, RoomSpec, StoreySpec

CAMERA = wide_camera()
ANYWHERE = VerificationConfig(gate_m=100.0, gate_rad=4.0, max_edges=1000)
EMPTY = MeasuredEdges(np.zeros((0, 6)), np.zeros((0, 6, 6)), np.zeros(0, int), np.zeros(0, int))
SOME = MeasuredEdges(np.array([[0.01, 0, 0, 0.02, 0, 0]]), np.eye(6)[None] * 1e-4, np.array([40]), np.array([20]))
FAR = MeasuredEdges(np.array([[0, 0, 1.0, 3.0, 0, 0]]), np.eye(6)[None] * 1e-4, np.array([17]), np.array([20]))


def model(log_odds=0.0, query_share=0.0, false_rate=0.0):
    return LoopModel(np.array([log_odds, 0.0, 0.0, 0.0, 0.0]), query_share, false_rate, SOME, FAR)


def two_offices(seed=None):
    """A house with two offices of equal shape; with a seed, they also have the same finish."""

    def room(name, x):
        corners = ((x, 0.0), (x + 6.0, 0.0), (x + 6.0, 5.0), (x, 5.0))
        return RoomSpec(id=name, label="office", polygon_m=corners, seed=seed)

    return build_house(HouseSpec(storeys=(StoreySpec(rooms=(room("a", 0.0), room("b", 6.0)), furniture=(), windows=()),)))


@pytest.fixture(scope="module")
def house():
    return two_offices()


def sight(house, x, y, yaw, storey=0):
    T_W_B = np.eye(4)
    T_W_B[:3, :3], T_W_B[:3, 3] = turned(yaw), (x, y, house.storeys[storey].floor_m + 1.4)
    return true_views(look(survey(house), T_W_B[None], CAMERA), T_W_B[None], CAMERA)[0]


def shared(first, second):
    return predictors([first], [second])[0, PREDICTORS.index("covisibility")]


def test_a_view_shares_all_with_itself_and_nothing_with_another_room_or_its_back(house):
    here = sight(house, 2.0, 2.5, 0.3)
    assert shared(here, here) > 0.99
    assert shared(here, sight(house, 8.0, 2.5, 0.3)) == 0.0
    assert shared(here, sight(house, 2.0, 2.5, 0.3 + np.pi)) < 0.05


def test_what_is_shared_is_mutual_and_falls_with_turn_and_distance(house):
    here = sight(house, 1.5, 2.5, 0.0)
    turns = [shared(here, sight(house, 1.5, 2.5, yaw)) for yaw in (0.0, 0.4, 0.8, 1.2)]
    steps = [shared(here, sight(house, 1.5 + step, 2.5, 0.0)) for step in (0.0, 0.5, 1.5, 3.0)]
    assert (np.diff(turns) < 0).all() and (np.diff(steps) < 0).all()
    there = sight(house, 2.5, 3.0, 0.5)
    np.testing.assert_allclose(predictors([here], [there]), predictors([there], [here]), atol=1e-9)


def test_pairs_that_are_computed_together_are_those_computed_alone(house):
    views = [sight(house, *place) for place in ((2.0, 2.5, 0.3), (1.5, 2.5, 0.0), (4.0, 1.0, 1.9), (8.0, 2.5, 0.3))]
    pairs = [(a, b) for a in views for b in views]
    together = predictors([a for a, _ in pairs], [b for _, b in pairs])
    np.testing.assert_allclose(together, np.concatenate([predictors([a], [b]) for a, b in pairs]), atol=1e-12)
    assert 0 < (together[:, PREDICTORS.index("covisibility")] > 0).sum() < len(pairs)


def graph_of(count, step_m=0.0):
    graph = PoseGraph(PoseGraphConfig())
    for i in range(count):
        T_O_B = np.eye(4)
        T_O_B[0, 3] = i * step_m
        graph.add_keyframe(Keyframe(i, i, float(i), T_O_B, np.eye(6), np.ones(1, np.float32), NO_FEATURES, NO_LANDMARKS))
    return graph


def confirmed(house, chosen, seed=0, queries=40, matches=10):
    """Loop edges between equal views, by query."""
    few = RayGrid(*np.float32([[-0.5, 0.5]] * 2))
    seen = {"depth": np.ones((2, 2), np.float32), "thing": np.zeros((2, 2), np.int16)}
    there = sight(house, 2.0, 2.5, 0.3)
    here = replace(there, image=replace(there.image, **seen, grid=few))
    verifier = CovisibilityVerifier(chosen, lambda index: (here,), seed)
    graph = graph_of(matches + queries)
    return [
        verifier(graph.keyframes[query], range(matches), graph, CAMERA, ANYWHERE).edges
        for query in range(matches, matches + queries)
    ]


@pytest.mark.parametrize("log_odds", [-1.5, 0.0, 2.0])
@pytest.mark.parametrize("query_share", [0.0, 0.6])
def test_the_rate_of_success_is_the_fitted_one(house, log_odds, query_share):
    found = sum(map(len, confirmed(house, model(log_odds, query_share), queries=150, matches=4)))
    chance = 1.0 / (1.0 + np.exp(-log_odds))
    assert found / 600 == pytest.approx(chance, abs=0.09 if query_share else 0.06)


def test_candidates_of_a_query_share_a_random_effect(house):
    apart, together = (np.var([len(e) for e in confirmed(house, model(0.0, share), queries=80)]) for share in (0.0, 0.9))
    assert together > 3.0 * apart


def test_false_edges_come_at_their_rate_with_their_error(house):
    edges = [edge for found in confirmed(house, model(-40.0, false_rate=0.3), queries=60) for edge in found]
    assert len(edges) / 600 == pytest.approx(0.3, abs=0.06)
    assert {edge.inliers for edge in edges} == {17}
    np.testing.assert_allclose(edges[0].T_match_query, se3.exp(FAR.error[0]), atol=1e-9)


def test_the_decision_on_an_edge_depends_on_the_number_of_its_cells(house):
    """The edge turns the estimate by 1 rad, which it may if its inliers cover enough of the image."""
    here, graph = sight(house, 2.0, 2.5, 0.3), graph_of(2, step_m=1.0)
    drifting = replace(ANYWHERE, gate_rad=0.1, gate_rad_m=1.0)

    def outcome(cells):
        drawn = replace(FAR, cells=np.array([cells]))
        chosen = LoopModel(np.array([-40.0, 0.0, 0.0, 0.0, 0.0]), 0.0, 1.0, SOME, drawn)
        (decision,) = CovisibilityVerifier(chosen, lambda index: (here,), 0)(
            graph.keyframes[1], [0], graph, CAMERA, drifting
        ).decisions
        assert decision.cells == cells
        return decision.outcome

    assert outcome(6) == "uncertain pose"
    assert outcome(20) == "accepted"


def test_edges_are_chosen_with_all_their_figures():
    many = MeasuredEdges(np.arange(18.0).reshape(3, 6), np.arange(108.0).reshape(3, 6, 6), np.arange(3), np.arange(5, 8))
    for rows in (np.array([2, 0]), np.array([True, False, True])):
        for field in fields(MeasuredEdges):
            np.testing.assert_array_equal(getattr(many[rows], field.name), getattr(many, field.name)[rows])


def test_nothing_in_common_is_never_truly_confirmed(house):
    sights = [sight(house, 2.0, 2.5, 0.0), sight(house, 8.0, 2.5, 0.0)]
    verifier = CovisibilityVerifier(model(40.0), lambda index: (sights[index],), 0)
    graph = graph_of(2)
    assert verifier(graph.keyframes[1], [0], graph, CAMERA, ANYWHERE).edges == ()


def in_two_offices(house):
    """A verifier that confirms whatever it can, for two views from the same place in either office."""
    sights = [sight(house, 2.0, 2.5, 0.3), sight(house, 8.0, 2.5, 0.3)]
    return CovisibilityVerifier(model(40.0), lambda index: (sights[index],), 0)


def edges_of_two(verifier):
    graph = graph_of(2)
    return verifier(graph.keyframes[1], [0], graph, CAMERA, ANYWHERE).edges


def test_a_room_that_looks_alike_is_taken_for_the_other_one():
    (edge,) = edges_of_two(in_two_offices(two_offices(seed=3)))
    np.testing.assert_allclose(edge.T_match_query, se3.exp(SOME.error[0]), atol=1e-9)
    assert edge.inliers == SOME.inliers[0]


def test_rooms_of_equal_shape_and_other_finish_are_not_mistaken(house):
    assert edges_of_two(in_two_offices(house)) == ()


def test_a_false_edge_is_relative_to_the_room_that_may_be_mistaken():
    sights = [sight(two_offices(seed=3), x, 2.5, 0.3) for x in (2.0, 8.0)]
    chosen = model(-40.0, false_rate=1.0)
    (edge,) = edges_of_two(CovisibilityVerifier(chosen, lambda index: (sights[index],), 0))
    np.testing.assert_allclose(edge.T_match_query, se3.exp(FAR.error[0]), atol=1e-9)


def test_all_cameras_of_a_rig_are_moved_into_the_room_that_looks_alike():
    """The first cameras look away from each other; the second camera of the query sees what the match's first one sees."""
    offices = two_offices(seed=3)
    here, there = sight(offices, 2.0, 2.5, 0.3), sight(offices, 8.0, 2.5, 0.3)
    back = sight(offices, 8.0, 2.5, 0.3 + np.pi)
    seen = [(here, sight(offices, 2.0, 2.5, 0.3 + np.pi)), (back, there)]
    (edge,) = edges_of_two(CovisibilityVerifier(model(40.0), lambda index: seen[index], 0))
    expected = se3.between(here.T_W_B, back.moved(np.array([-6.0, 0.0, 0.0])).T_W_B)
    np.testing.assert_allclose(edge.T_match_query, expected @ se3.exp(SOME.error[0]), atol=1e-9)


def test_no_room_of_another_house_looks_alike():
    verifier = in_two_offices(two_offices(seed=3))
    again = verifier.renumbered(lambda index: index + 1)
    assert len(edges_of_two(verifier.followed_by(again, 1))) == 1
    assert edges_of_two(verifier.followed_by(again, 1, away_m=1000.0)) == ()


def test_the_two_faces_of_a_wall_are_two_surfaces():
    offices = two_offices(seed=3)
    assert shared(sight(offices, 4.5, 2.5, 0.0), sight(offices, 7.5, 2.5, np.pi)) == 0.0
    assert shared(sight(offices, 4.5, 2.5, 0.0), sight(offices, 4.0, 2.5, 0.0)) > 0.3


def test_what_things_look_like_does_not_depend_on_the_rest_of_the_house():
    """Without furniture, everything else looks as it did, and things of other kinds look different."""
    spec = sample_house("home", 7)
    empty = spec.model_copy(update={"clutter": 0.0})
    whole, fewer = (survey(build_house(each)) for each in (spec, empty))
    numbers = dict(zip(whole.names, whole.looks.tolist(), strict=True))
    common = [number for number, name in enumerate(fewer.names) if name in numbers]
    assert [numbers[fewer.names[number]] for number in common] == fewer.looks[common].tolist()
    kinds = dict(zip(whole.looks.tolist(), whole.kind.tolist(), strict=True))
    assert [kinds[number] for number in whole.looks.tolist()] == whole.kind.tolist()
    assert len(common) < len(whole.names) and 50 < len(kinds) < len(whole.names)


def test_furniture_of_one_kind_looks_the_same_if_it_has_the_same_size():
    house = build_house(sample_house("ori", 3))
    around = survey(house)
    looks = dict(zip(around.names, around.looks.tolist(), strict=True))
    pieces = [piece for piece in house.furniture if piece.id in looks]
    pairs = [(a, b) for a, b in combinations(pieces, 2) if a.kind == b.kind]
    equal = [np.allclose(a.size, b.size, atol=5e-4) for a, b in pairs]
    assert 0 < sum(equal) < len(pairs)
    assert [looks[a.id] == looks[b.id] for a, b in pairs] == equal


def test_a_room_is_mistaken_for_the_one_nearest_to_the_match(house):
    first, second, opposite = (sight(house, x, 2.5, 0.3) for x in (2.0, 8.0, 11.9))
    np.testing.assert_allclose(mistaken_by(first, second), [-6.0, 0.0, 0.0])
    np.testing.assert_allclose(mistaken_by(second, first), [6.0, 0.0, 0.0])
    np.testing.assert_allclose(first.moved(mistaken_by(second, first)).T_W_B[:3, 3], second.T_W_B[:3, 3])
    assert mistaken_by(first, first) is None
    assert mistaken_by(sight(house, 5.9, 2.5, 0.3), second) is None, "the query is nearer in its own room"
    assert mistaken_by(sight(house, 6.5, 2.5, 1.57), sight(house, 11.5, 2.5, 1.57)) is None, "both are in one room"
    assert mistaken_by(first, sight(house, 2.0, 9.0, 0.3)) is None, "the query is outside of the house"
    np.testing.assert_allclose(mistaken_by(first, opposite), [-6.0, 0.0, 0.0])


def test_only_rooms_of_one_label_are_mistaken():
    """Upstairs, the rooms have the labels that they have downstairs, in the same places."""
    corners = ((0.0, 0.0), (5.0, 0.0), (5.0, 4.0), (0.0, 4.0)), ((5.0, 0.0), (9.0, 0.0), (9.0, 4.0), (5.0, 4.0))

    def storey(number):
        rooms = (
            RoomSpec(id=f"{label}{number}", label=label, polygon_m=own, seed=5)
            for label, own in zip(("office", "kitchen"), corners, strict=True)
        )
        return StoreySpec(rooms=tuple(rooms), furniture=(), windows=())

    stacked = build_house(HouseSpec(storeys=(storey(0), storey(1))))
    views = [sight(stacked, x, 2.0, 0.3, floor) for x in (2.0, 7.0) for floor in (0, 1)]
    height = views[1].T_W_B[2, 3] - views[0].T_W_B[2, 3]
    assert height > 2.0 and all(len(view.image.around.offsets(view.room)) == 1 for view in views)
    np.testing.assert_allclose(mistaken_by(views[0], views[1]), [0.0, 0.0, -height])
    np.testing.assert_allclose(mistaken_by(views[0], views[3]), [0.0, 0.0, -height])
    assert mistaken_by(views[0], views[2]) is None


def test_edges_are_judged_by_the_truth_and_by_the_rooms_that_may_be_mistaken():
    """The edge from keyframe 1 or 2 to a match leads to the place `along_x` from the match."""
    offices = two_offices(seed=3)
    views = [sight(offices, x, 2.5, 0.3) for x in (2.0, 8.0, 3.0)]
    true = [(1, 0, 6.0), (2, 0, 1.0), (2, 1, -5.0)]
    mistaken = [(1, 0, 0.0), (2, 1, 1.0)]
    wrong = [(1, 0, 1.0), (2, 0, 3.0), (1, 0, 5.0)]
    errors = [0.0] * len(true) + [0.0] * len(mistaken) + [1.0, 2.0, 5.0]
    edges = []
    for query, match, along_x in (*true, *mistaken, *wrong):
        T_match_query = se3.between(views[match].T_W_B, views[match].moved(np.array([along_x, 0.0, 0.0])).T_W_B)
        edges.append(LoopEdge(query, match, T_match_query, np.eye(6), 20))
    found, is_true, is_mistaken = judged(LoopArrays.of(edges), views)
    assert is_true.tolist() == [True] * 3 + [False] * 5 and is_mistaken.tolist() == [False] * 3 + [True] * 2 + [False] * 3
    np.testing.assert_allclose(np.linalg.norm(found[:, :3, 3], axis=1), errors, atol=1e-9)
    assert len(judged(LoopArrays.of([]), views).errors) == 0


def test_the_decision_on_a_pair_depends_on_that_pair_and_the_seed(house):
    first, again, other = (confirmed(house, model(), seed) for seed in (1, 1, 2))
    names = [[[edge.match for edge in edges] for edges in found] for found in (first, again, other)]
    assert names[0] == names[1] != names[2]
    here = sight(house, 2.0, 2.5, 0.3)
    verifier, graph = CovisibilityVerifier(model(), lambda index: (here,), 1), graph_of(50)
    back = verifier(graph.keyframes[10], [*range(9, -1, -1)], graph, CAMERA, ANYWHERE).edges
    assert sorted(edge.match for edge in back) == sorted(edge.match for edge in first[0])


def test_an_edge_that_contradicts_the_odometry_is_refused(house):
    here = sight(house, 2.0, 2.5, 0.3)
    verifier, graph = CovisibilityVerifier(model(-40.0, false_rate=1.0), lambda index: (here,), 1), graph_of(2)
    accepted, refused = (verifier(graph.keyframes[1], [0], graph, CAMERA, each) for each in (ANYWHERE, VerificationConfig()))
    assert len(accepted.edges) == 1 and refused.edges == ()
    assert (accepted.decisions[0].outcome, refused.decisions[0].outcome) == ("accepted", "far from the estimate")


def test_logistic_regression_finds_its_weights(rng):
    inputs = np.column_stack([np.ones(20000), rng.normal(size=(20000, 2))])
    weights = np.array([-0.5, 1.5, -2.0])
    outcome = rng.random(20000) < 1.0 / (1.0 + np.exp(-inputs @ weights))
    np.testing.assert_allclose(fit_logistic(inputs, outcome.astype(float)), weights, atol=0.12)


@pytest.mark.parametrize("share", [0.0, 0.5, 0.9])
def test_fitting_recovers_the_random_effect_of_queries(rng, share):
    queries, each = 1500, 5
    covisibility = rng.uniform(0.05, 0.9, queries * each)
    rows = np.column_stack([np.ones_like(covisibility), covisibility, covisibility**2, *np.zeros((2, queries * each))])
    query = np.repeat(np.arange(queries), each)
    luck = np.sqrt(share) * np.repeat(rng.normal(size=queries), each) + np.sqrt(1 - share) * rng.normal(size=len(rows))
    from scipy.stats import norm

    chance = 1.0 / (1.0 + np.exp(-(4.0 * covisibility - 2.0)))
    is_true = luck < norm.ppf(chance)
    fitted = fit_loops(Trials(query, rows, is_true, *np.zeros((2, len(rows)), bool), SOME, EMPTY))
    assert fitted.query_share == pytest.approx(share, abs=0.1)
    assert fitted.false_rate == 0.0
    np.testing.assert_allclose(fitted.probability(rows), chance, atol=0.08)


def test_without_candidates_no_view_is_computed(house):
    verifier, graph = CovisibilityVerifier(model(), lambda index: pytest.fail("asked"), 1), graph_of(1)
    assert verifier(graph.keyframes[0], [], graph, CAMERA, replace(ANYWHERE, max_edges=1)).edges == ()
