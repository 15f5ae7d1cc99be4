"""The plan of a wrong frame shows the true path, the estimate and the estimates, each with an entry of the legend."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import ImageColor
from shapely.geometry import LineString, Polygon
from shapely.ops import unary_union

from sim.harness import Scenario
from sim.harness.scenario_sessions import picture_session
from sim.report.drawing import STYLES, Drawing, Mark
from sim.report.frame_picture import FrameEstimates, frame_marks, place_image
from sim.report.legend import LegendEntry, with_legend
from sim.report.palette import instance_colours, label_colours
from worlds.labels import ROOM_LABELS
from worlds.presets import sample_from_rooms, sample_house

FRAME = 20


@pytest.fixture(scope="module")
def session():
    house = sample_from_rooms(("kitchen", "bedroom"), seed=21)
    return picture_session(Scenario(house=house, seed=5, length_m=15.0, frame_rate_hz=4.0, fidelity="features"))


@pytest.fixture(scope="module")
def estimates(session):
    """Every second frame, estimated half a metre north of the truth, in two rooms; the last frame is in a wrong one."""
    frames = np.arange(0, len(session), 2)
    poses = session.tour.T_W_B[frames].copy()
    poses[:, 1, 3] += 0.5
    groups = tuple(f"room {k % 2}" for k in range(len(frames)))
    wrong = np.arange(len(frames)) == len(frames) - 1
    return FrameEstimates(frames, poses, groups, wrong, {"room 0": "#0072b2", "room 1": "#e69f00"})


def of_style(marks, style):
    return [mark for mark in marks if mark.style == style]


def test_the_whole_true_path_and_the_walk_so_far_are_drawn(session):
    marks, legend = frame_marks(session, FRAME)
    whole, so_far = (np.concatenate([mark.points for mark in of_style(marks, style)]) for style in ("walk", "walked"))
    np.testing.assert_array_equal(whole, session.tour.T_W_B[:, :2, 3])
    np.testing.assert_array_equal(so_far, session.tour.T_W_B[: FRAME + 1, :2, 3])
    assert not of_style(marks, "estimated") and "estimated path" not in [entry.text for entry in legend]


def test_a_line_leads_from_the_true_to_the_estimated_position(session, estimates):
    marks, legend = frame_marks(session, FRAME, replace(estimates, groups=()))
    (line,) = of_style(marks, "error")
    np.testing.assert_array_equal(line.points[0], session.tour.T_W_B[FRAME, :2, 3])
    np.testing.assert_allclose(line.points[1] - line.points[0], [0.0, 0.5])
    (whole,), (so_far,) = of_style(marks, "belief"), of_style(marks, "estimated")
    np.testing.assert_array_equal(whole.points, estimates.T_W_B[:, :2, 3])
    np.testing.assert_array_equal(so_far.points, estimates.T_W_B[: FRAME // 2 + 1, :2, 3])
    assert {"estimated path", "from the true to the estimated position"} <= {entry.text for entry in legend}


def test_every_frame_is_a_dot_in_the_colour_of_its_estimate_at_its_true_position(session, estimates):
    marks, legend = frame_marks(session, FRAME, estimates)
    later, colours = estimates.frames > FRAME, np.array([estimates.colours[group] for group in estimates.groups])
    assert later.any() and not later.all()
    for style, rows in (("estimate", ~later), ("later-estimate", later)):
        dots = of_style(marks, style)
        assert [mark.colour for mark in dots] == colours[rows].tolist()
        places = np.concatenate([mark.points for mark in dots])
        np.testing.assert_array_equal(places, session.tour.T_W_B[estimates.frames[rows], :2, 3])
        rings = [mark.points for mark in of_style(marks, style.replace("estimate", "wrong-estimate"))]
        wrong = session.tour.T_W_B[estimates.frames[estimates.wrong & rows], :2, 3]
        np.testing.assert_array_equal(np.concatenate([np.zeros((0, 2)), *rings]), wrong)
    assert {("room 0", "#0072b2"), ("room 1", "#e69f00")} <= {(entry.text, entry.colour) for entry in legend}
    assert "ringed: wrong" in [entry.text for entry in legend]


def test_names_of_rooms_are_above_dots_and_dots_above_the_rings_of_wrong_ones():
    order = list(STYLES)
    assert order.index("walked") < order.index("wrong-estimate") < order.index("estimate") < order.index("name")
    assert STYLES["estimate"].radius < STYLES["wrong-estimate"].radius
    assert STYLES["later-estimate"].radius < STYLES["later-wrong-estimate"].radius < STYLES["estimate"].radius


def test_marks_of_wrong_estimates_and_of_the_camera_have_the_colour_of_no_room():
    def far(a, b):
        return np.abs(np.subtract(ImageColor.getrgb(a), ImageColor.getrgb(b))).max() > 60

    estimated = {*label_colours(ROOM_LABELS).values(), *instance_colours(map(str, range(12)), "").values()}
    for colour in (STYLES["camera"].fill, STYLES["wrong-estimate"].stroke):
        assert all(far(colour, other) for other in {*estimated, STYLES["error"].stroke})


def test_the_field_of_view_ends_at_walls_and_stays_in_the_house(session):
    rooms = [Polygon(room.polygon_m) for room in session.house.spec.storeys[0].rooms]
    walls = unary_union([wall.footprint for wall in session.house.walls if wall.bottom_m < 1.0 < wall.top_m])
    inside, areas = unary_union(rooms).buffer(1e-6), []
    for frame in range(len(session)):
        (sight,) = of_style(frame_marks(session, frame)[0], "sight")
        assert all(inside.contains(LineString([sight.points[0], end])) for end in sight.points[1:])
        assert all(walls.intersection(LineString([sight.points[0], end])).length < 1e-6 for end in sight.points[1:])
        areas.append(Polygon(sight.points).area)
    assert min(areas) < 0.5 * max(areas)


def test_the_legend_says_how_many_estimates_it_leaves_out(session, estimates):
    groups = tuple(f"room {k}" for k in range(len(estimates.groups)))
    many = replace(estimates, groups=groups, colours=dict.fromkeys(groups, "#0072b2"))
    shown = [entry.text for entry in frame_marks(session, FRAME, many)[1]]
    assert len(groups) > 12 and f"and {len(groups) - 12} more" in shown and "room 12" not in shown


def test_the_estimated_direction_of_view_is_an_arrow_that_the_legend_explains(session, estimates):
    marks, legend = frame_marks(session, FRAME, replace(estimates, groups=()))
    (view,) = of_style(marks, "view")
    start, tip, left, _, right = view.points
    assert [entry.kind for entry in legend if entry.text == "the estimated direction of view"] == ["arrow"]
    np.testing.assert_allclose(((left + right) / 2 - tip) @ (tip - start), -0.14 * 0.6)
    np.testing.assert_allclose(np.linalg.norm(left - tip), np.linalg.norm(right - tip))
    assert not any(entry.kind == "arrow" for entry in frame_marks(session, FRAME, estimates)[1])


def test_a_turned_estimate_has_another_direction_of_view(session, estimates):
    estimates = replace(estimates, groups=())
    turned = estimates.T_W_B.copy()
    turned[:, :2, :2] = turned[:, :2, :2] @ np.array([[0.0, -1.0], [1.0, 0.0]])
    (ahead,), (left,) = (
        of_style(frame_marks(session, FRAME, each)[0], "view") for each in (estimates, replace(estimates, T_W_B=turned))
    )
    assert np.diff(ahead.points, axis=0)[0] @ np.diff(left.points, axis=0)[0] == pytest.approx(0.0, abs=1e-9)


def test_only_what_is_on_the_storey_of_the_frame_is_drawn():
    session = picture_session(Scenario(house=sample_house("home", 3), seed=5, fidelity="features", frame_rate_hz=2.0))
    storeys = np.array([truth.storey for truth in session.truths])
    assert set(storeys) == {0, 1}
    frames = np.arange(len(session))
    estimates = FrameEstimates(frames, session.tour.T_W_B, ("floor 0",) * len(frames), storeys == 1, {"floor 0": "#0072b2"})
    for level in (0, 1):
        marks, legend = frame_marks(session, int(np.argmax(storeys == level)), estimates)
        assert len([mark for mark in marks if mark.colour == "#0072b2"]) == np.sum(storeys == level)
        assert ("ringed: wrong" in [entry.text for entry in legend]) == (level == 1)


def test_a_picture_is_wide_enough_for_its_legend(session, estimates):
    image = place_image(session, FRAME, estimates)
    assert 480 <= image.shape[1] <= 1000
    assert len(image) > len(place_image(session, FRAME))


@pytest.mark.parametrize("width_m", [4.8, 12.0, 60.0])
def test_the_legend_is_below_the_drawing_and_no_wider(width_m):
    drawing = Drawing([Mark("line", "true", np.array([[0.0, 0.0], [width_m, 1.0]]))], np.zeros(2), np.array([width_m, 1.0]))
    entries = [LegendEntry("dot", "right", f"estimated room {k}", "#0072b2") for k in range(9)]
    entries.append(LegendEntry("line", "error", "from the true to the estimated position"))
    shown = with_legend(drawing, entries, letter_m=width_m * 13 / 480)
    added = shown.marks[1:]
    texts = [mark for mark in added if mark.kind == "text"]
    assert [mark.text for mark in texts] == [entry.text for entry in entries]
    assert max(mark.points[:, 1].max() for mark in added) < 0.0
    for mark in added:
        reach = 0.58 * mark.size * len(mark.text) if mark.kind == "text" else STYLES[mark.style].radius
        assert mark.points[:, 0].min() >= 0.0 and mark.points[:, 0].max() + reach <= width_m
        assert mark.points[:, 1].min() - STYLES[mark.style].radius > shown.low[1]


@pytest.mark.parametrize("letter_m", [0.05, 0.13, 0.4])
def test_a_dot_of_the_legend_lies_in_the_picture_and_left_of_its_text(letter_m):
    drawing = Drawing([Mark("line", "true", np.array([[0.0, 0.0], [8.0, 1.0]]))], np.zeros(2), np.array([8.0, 1.0]))
    entry = LegendEntry("dot", "camera", "the camera at this frame")
    dot, text = with_legend(drawing, [entry], letter_m).marks[1:]
    radius = STYLES["camera"].radius + STYLES["camera"].width / 200
    assert dot.points[0, 0] - radius > 0.0 and dot.points[0, 0] + radius < text.points[0, 0]
