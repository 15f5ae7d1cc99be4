"""The report is complete, self-contained, true to its data, and never half-written."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra.numpy import arrays
from hypothesis.strategies import integers

from lexis.errors import LexisError
from lexis.evaluation.rooms import score_rooms
from sim.errors import SimError
from sim.report import ReportData, render_report, write_report
from sim.report.confusion import confusion
from sim.report.data import (
    NO_LABEL,
    UNKNOWN,
    FloorPlan,
    KeyframeTable,
    LoopMark,
    PlannedOpening,
    PlannedRoom,
    PlanPath,
    SampleFrame,
    ShownFailure,
)
from sim.report.findings import Finding, coverage_gap, findings, idle_faults, rooms_without_keyframe
from sim.report.overlay import run_marks
from sim.report.palette import estimated_room_colours, label_colours, true_room_colours
from sim.report.room_errors import RoomErrors, room_errors, surplus

NAMES = ("kitchen", "office", "library")
VOID = {"meta", "link", "img", "input", "br", "hr"}


def square(x: float, y: float, side: float = 4.0) -> np.ndarray:
    return np.array([[x, y], [x + side, y], [x + side, y + side], [x, y + side]])


def example(
    rng: np.random.Generator, n: int = 40, wrong: int = 5, rooms: tuple[str, str] = ("kitchen 1", "office 1")
) -> ReportData:
    """A walk from a kitchen through an office beside it, on each of two storeys."""
    poses = np.tile(np.eye(4), (n, 1, 1))
    storeys = (np.arange(n) * 2) // n
    poses[:, 0, 3] = np.linspace(1, 7, n)
    poses[:, 1, 3] = 2
    poses[:, 2, 3] = 3.0 * storeys + 1.2
    true = (poses[:, 0, 3] > 4).astype(int)
    predicted = true.copy()
    predicted[rng.choice(n, wrong, replace=False)] = 2
    drifted = poses.copy()
    drifted[:, :2, 3] += np.cumsum(rng.normal(0, 0.05, (n, 2)), axis=0)
    drifted[0] = poses[0]
    table = KeyframeTable(
        np.arange(n) * 0.5, poses, drifted, poses, storeys, true, true, predicted,
        tuple(rooms[i] for i in true), tuple(f"room {i} ({NAMES[i]})" for i in predicted),
    )  # fmt: skip
    plans = tuple(
        FloorPlan(
            level,
            3.0 * level,
            (PlannedRoom(rooms[0], "kitchen", square(0, 0)), PlannedRoom(rooms[1], "office", square(4, 0))),
            openings=(PlannedOpening("open", np.array([[4.0, 1.0], [4.0, 3.0]])),),
        )
        for level in (0, 1)
    )
    sample = SampleFrame(3, rng.integers(0, 255, (36, 48, 3), dtype=np.uint8), (("kitchen", 0.3), ("office", 0.2)))
    result = {"seed": 7, "preset": "home", "labels": {"accuracy": 1 - wrong / n}, "loops": {"precision": None}}
    path = PlanPath("kitchen", "office", poses[:, :3, 3], True)
    return ReportData(result, NAMES, plans, table, (LoopMark(30, 2, True, 0.9),), (sample,), (path,))


class Page(HTMLParser):
    """Collects the elements of a page, and checks that they are closed in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self._open: list[str] = []
        self.feed(text)
        assert self._open == []

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self._open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self._open.pop() == tag

    def having(self, name: str, value: str) -> list[dict[str, str | None]]:
        return [attrs for _, attrs in self.elements if attrs.get(name) == value]


def test_needs_no_network(rng):
    page = Page(render_report(example(rng)))
    addresses = [attrs[name] for _, attrs in page.elements for name in ("src", "href", "xlink:href") if name in attrs]
    assert addresses
    assert all(address.startswith("data:") for address in addresses)
    assert not {tag for tag, _ in page.elements} & {"link", "iframe", "object"}


def test_every_keyframe_is_one_dot_and_every_wrong_one_is_ringed(rng):
    data = example(rng, n=60, wrong=7)
    page = Page(render_report(data))
    dots = page.having("class", "right") + page.having("class", "wrong")
    assert sorted(int(dot["data-k"]) for dot in dots) == list(range(60))
    assert {int(dot["data-k"]) for dot in page.having("class", "wrong")} == set(np.flatnonzero(data.keyframes.wrong))


def test_names_cannot_break_the_page(rng):
    text = render_report(example(rng, rooms=("</script><script>alert(1)</script>", 'a"b&c')))
    assert "<script>alert" not in text
    Page(text)


def test_long_runs_stay_under_five_megabytes(rng):
    data = example(rng, n=3000, wrong=1000)
    frame = rng.integers(0, 255, (480, 640, 3), dtype=np.uint8)
    samples = tuple(SampleFrame(k, frame, (("kitchen", 0.3),)) for k in range(16))
    loops = tuple(LoopMark(k, k - 50, k % 9 != 0, 1.0) for k in range(50, 3000, 3))
    assert len(render_report(replace(data, samples=samples, loops=loops)).encode()) < 5_000_000


def test_a_single_keyframe_makes_a_report(rng):
    table = example(rng).keyframes
    one = KeyframeTable(*(getattr(table, name)[:1] for name in table.__dataclass_fields__))
    Page(render_report(ReportData({}, NAMES, example(rng).plans, one)))


def test_written_whole_or_not_at_all(rng, tmp_path):
    write_report(tmp_path / "report.html", example(rng))
    assert (tmp_path / "report.html").read_text() == render_report(example(np.random.default_rng(20_240_731)))
    (tmp_path / "taken").mkdir()
    with pytest.raises(LexisError, match="is a folder"):
        write_report(tmp_path / "taken", example(rng))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["report.html", "taken"]


def test_confusion_counts_every_keyframe_once(rng):
    data = example(rng, n=200, wrong=60)
    matrix = confusion(data.keyframes, NAMES)
    assert matrix.counts.sum() == 200
    assert np.trace(matrix.counts) == 140
    assert matrix.rows == ("kitchen", "office")
    assert matrix.columns == NAMES
    hits = np.array(matrix.recalls) * matrix.counts.sum(axis=1)
    assert hits.sum() == pytest.approx(140)


def test_a_better_trajectory_is_owed_to_loops_and_not_to_the_alignment(rng):
    data = example(rng, wrong=0)
    table = data.keyframes
    turned = table.true_poses.copy()
    turned[:, 1, 3] += 0.05 * (turned[:, 0, 3] - turned[0, 0, 3])  # an error that alignment removes almost completely
    worse = table.true_poses.copy()
    worse[:, 1, 3] += rng.normal(0, 0.1, len(worse))
    data = replace(data, keyframes=replace(table, odometry_poses=turned, estimated_poses=worse))
    assert any("Loop closing" in finding.text and not finding.good for finding in findings(data))
    assert not any("Loop closing" in finding.text for finding in findings(replace(data, loops=())))


def test_every_plan_is_drawn_and_those_that_failed_stand_out_and_are_listed(rng):
    data = example(rng)
    short = PlanPath("library", "office", data.paths[0].points[:15], False, "ran into wall#3", "kitchen 1", 4.0)
    unplanned = PlanPath("office", "library", np.zeros((0, 3)), False, "no plan was found")
    crowded = replace(data, paths=(*data.paths * 40, short, unplanned))
    marks = [run_marks(crowded, level, dict.fromkeys(NAMES, "#000000")) for level in (0, 1)]
    assert [sum(mark.style == "plan" for mark in storey) for storey in marks] == [40, 40]
    assert [sum(mark.style == "plan-failed" for mark in storey) for storey in marks] == [1, 0]
    crosses = [mark for mark in marks[0] if mark.style == "plan-end"]
    assert len(crosses) == 2 and not any(mark.style == "plan-end" for mark in marks[1])
    np.testing.assert_allclose(np.mean([mark.points for mark in crosses], axis=(0, 1)), short.points[-1, :2])
    assert {mark.text for mark in marks[0] if mark.style == "plan-number"} == {"1"}
    page = render_report(crowded)
    for cell in ("library", "ran into wall#3", "kitchen 1", "no plan was found", f"{short.driven_m:.1f} m", "4.0 m"):
        assert f">{cell}</td>" in page
    told = "2 of 42 plans did not reach their room: from library to office (ran into wall#3); from office to library ("
    assert any(told in finding.text and not finding.good for finding in findings(crowded))


def test_stretches_that_loop_closing_bent_are_told_of_though_the_whole_is_better(rng):
    data = example(rng, n=200, wrong=0)
    table = data.keyframes
    truth = np.tile(np.eye(4), (200, 1, 1))
    truth[:, 0, 3] = np.arange(200) * 0.5
    drifted, optimised = truth.copy(), truth.copy()
    drifted[:, 1, 3] = 0.4 * np.sin(truth[:, 0, 3] * 2 * np.pi / 100)
    optimised[:, 1, 3] = 0.2 * (np.arange(200) // 16 % 2)  # steps of 8 m
    bent = replace(data, keyframes=replace(table, true_poses=truth, odometry_poses=drifted, estimated_poses=optimised))
    texts = {finding.good: finding.text for finding in findings(bent) if "8 m (RPE)" in finding.text}
    assert list(texts) == [False] and texts[False].endswith("which is worse.")
    assert any(finding.good and "changed the ATE" in finding.text for finding in findings(bent))
    kept = replace(bent, keyframes=replace(bent.keyframes, estimated_poses=drifted))
    assert any(finding.good and finding.text.startswith("Loop closing left the ATE at 0.") for finding in findings(kept))


def test_a_map_of_next_to_nothing_says_so_first(rng):
    data = example(rng, wrong=0)
    lost = {**data.result, "coverage": {"rooms_visited": 1, "rooms": 9, "path_covered": 0.0}}
    first = findings(replace(data, result=lost))[0]
    assert not first.good and first.text.startswith("The map covers 1 of 9 rooms and 0% of the walk.")
    whole = {**data.result, "coverage": {"rooms_visited": 9, "rooms": 9, "path_covered": 0.99}}
    assert coverage_gap(whole, ()) is None
    assert all(finding.good for finding in findings(replace(data, result=whole)))


def test_a_fault_that_removes_frames_has_an_effect_even_if_no_frame_that_is_left_is_changed():
    lost = {"run": {"frames": 148}, "faults": {"frames": {"kidnap": 0, "late": 0}, "delivered": 80}}
    assert idle_faults(lost).startswith("The fault late changed no frame")
    whole = {**lost, "faults": {"frames": {"kidnap": 0}, "delivered": 148}}
    assert idle_faults(whole).startswith("The fault kidnap changed no frame")


def test_faults_that_changed_no_frame_are_told(rng):
    data = example(rng, wrong=0)
    for frames, told in (({"kidnap": 0, "late": 9}, "The fault kidnap changed no frame"), ({"kidnap": 3, "late": 9}, None)):
        faulty = replace(data, result={**data.result, "faults": {"frames": frames}})
        texts = [finding.text for finding in findings(faulty) if not finding.good]
        assert [text.partition(";")[0] for text in texts] == ([told] if told else [])


def test_a_mistaken_convention_is_told_first(rng):
    told = findings(replace(example(rng, wrong=8), mistakes=("Every floor is 1 too high.",)))[0]
    assert (told.good, told.text) == (False, "Every floor is 1 too high.")


def test_a_position_error_is_no_good_news_above_that_of_the_odometry_and_no_news_below_5_mm(rng):
    data = example(rng, wrong=0)
    table = data.keyframes
    far = table.odometry_poses.copy()
    far[5, 0, 3] += 30.0
    near, exact = table.true_poses.copy(), table.true_poses.copy()
    near[-1, 0, 3] += 0.006
    exact[-1, 0, 3] += 0.004
    for estimated, good in ((far, [False]), (near, [True]), (exact, [])):
        seen = replace(data, keyframes=replace(table, estimated_poses=estimated))
        assert [f.good for f in findings(seen) if "largest position error" in f.text] == good


def test_findings_name_the_planted_faults_and_nothing_on_a_perfect_run(rng):
    data = example(rng, wrong=0)
    assert all(finding.good for finding in findings(data))
    faulty = replace(
        example(rng, wrong=8),
        loops=(LoopMark(30, 2, True, 0.9), LoopMark(35, 1, False, 0.8, 1.2, 1.0), LoopMark(20, 3, False, 0.1)),
        paths=(PlanPath("kitchen", "library", np.zeros((2, 3)), False),),
    )
    bad = " ".join(finding.text for finding in findings(faulty) if not finding.good)
    for fault in (
        "labelled library",
        "2 of 3 loop edges are false",
        "weight 0.80",
        "keyframe 35 to keyframe 1",
        "wrong by 1.2 m and 57°",
        "from kitchen to library",
    ):
        assert fault in bad


@pytest.mark.parametrize("said", [2, UNKNOWN])
@pytest.mark.parametrize("false_loops", [0, 1])
def test_findings_about_one_thing_have_its_verb_and_noun(rng, said, false_loops):
    data = example(rng, wrong=0)
    table = data.keyframes
    after, before = (table.true_labels.copy() for _ in range(2))
    after[3] = said
    before[5] = 2
    loops = (LoopMark(30, 2, not false_loops, 0.9),)
    spoiled = replace(data, keyframes=replace(table, predicted_labels=after, baseline_labels=before), loops=loops)
    failed = replace(spoiled, paths=(replace(data.paths[0], success=False),))
    text = " ".join(finding.text for each in (spoiled, failed) for finding in findings(each))
    assert ("1 of 20 keyframes in the kitchen has no label." if said == UNKNOWN else "is labelled library.") in text
    assert "Refinement corrected 1 wrong label and made 1 correct label wrong." in text
    assert ("1 of 1 loop edge is false" if false_loops else "The only loop edge is true.") in text
    assert "The only plan reached its room." in text and "1 of 1 plan did not reach its room: " in text


def silent(data: ReportData) -> ReportData:
    """The same walk with a SLAM that estimates nothing but a trajectory."""
    nothing = np.full(len(data.keyframes.stamps), UNKNOWN)
    table = replace(data.keyframes, baseline_labels=nothing, predicted_labels=nothing, predicted_rooms=("",) * len(nothing))
    figures = {"labels": {"accuracy": None}, "loops": {"verified": None}, "trajectory": {"ate_m": 0.1}}
    return replace(data, result={"seed": 7, **figures}, keyframes=table, loops=(), samples=(), paths=())


def test_what_the_slam_does_not_estimate_is_left_out(rng):
    data = silent(example(rng))
    page = render_report(data)
    absent = (
        "LEXIS's",
        "of LEXIS",
        "encoder",
        NO_LABEL,
        "says",
        "estimated room",
        "wrong</text>",
        "loops</text>",
        "recall</",
    )
    assert [text for text in absent if text in page] == []
    assert 'class="wrong' not in page and not any("loop" in finding.text for finding in findings(data))
    assert "0.100 m" in page and page.count("<dt>") == 1


def rooms_only(data: ReportData) -> ReportData:
    """The same walk with a SLAM that estimates rooms without labels, and no loops; the last keyframe is in no room."""
    table = data.keyframes
    rooms = (*(f"room {k // 10}" for k in range(len(table.stamps) - 1)), "")
    return replace(silent(data), keyframes=replace(silent(data).keyframes, predicted_rooms=rooms))


def test_without_labels_the_dots_have_the_colours_of_the_estimated_rooms(rng):
    data = rooms_only(example(rng))
    dots = [mark for level in (0, 1) for mark in run_marks(data, level, {NO_LABEL: "#000000"}) if mark.kind == "dot"]
    colours = dict(zip(data.keyframes.predicted_rooms, [mark.colour for mark in dots], strict=True))
    assert len(set(colours.values())) == len(colours) == 5
    for mark, room in zip(dots, data.keyframes.predicted_rooms, strict=True):
        assert mark.colour == colours[room] and mark.style == "right"
    page = render_report(data)
    assert all(f'"background:{colour}"' in page for colour in colours.values())
    for text in (
        "that of its estimated room",
        ">true room</text>",
        ">estimated room</text>",
        ">no room</li>",
        "estimated room 0 ·",
        "in no estimated room ·",
    ):
        assert text in page
    assert "room room" not in page and "label of the true room" in page
    assert 'type="radio"' not in page


def in_rooms(rng: np.random.Generator, true: str, predicted: str, each: int = 8) -> ReportData:
    """A walk with `each` keyframes in the true and the estimated room of every letter in turn; "-" is no room."""
    data = example(rng, n=each * len(true))
    rooms = tuple("" if room == "-" else f"room {room}" for room in predicted for _ in range(each))
    table = replace(data.keyframes, true_rooms=tuple(room for room in true for _ in range(each)), predicted_rooms=rooms)
    return replace(data, keyframes=table)


def test_with_labels_the_plan_can_also_be_coloured_by_estimated_room_in_the_colours_of_the_timeline(rng):
    data = example(rng)
    table, colours = data.keyframes, estimated_room_colours(data.keyframes)
    dots = [
        mark for level in (0, 1) for mark in run_marks(data, level, label_colours((*NAMES, NO_LABEL))) if mark.kind == "dot"
    ]
    assert [mark.room_colour for mark in dots] == [colours[room] for room in table.predicted_rooms]
    assert [mark.colour for mark in dots] == [label_colours(NAMES)[NAMES[i]] for i in table.predicted_labels]
    text = render_report(data)
    page = Page(text)
    switches = page.having("name", "colour")
    assert [(switch["id"], "checked" in switch) for switch in switches] == [("by-label", True), ("by-room", False)]
    for room, colour in colours.items():
        assert f'fill="{colour}"><title>estimated room: {room}</title>' in text
        assert f'<i style="background:{colour}"></i>{room}</li>' in text
    for room, colour in true_room_colours(table).items():
        assert f'fill="{colour}"><title>true room: {room}</title>' in text
        assert sum(floor["style"].endswith(f";--room:{colour}") for floor in page.having("class", "room")) == 2


def test_without_estimated_rooms_the_page_offers_no_colours_of_rooms(rng):
    data = example(rng)
    page = render_report(replace(data, keyframes=replace(data.keyframes, predicted_rooms=("",) * 40)))
    assert 'type="radio"' not in page and "--room:" not in page and " room</text>" not in page


@pytest.mark.parametrize(
    ("true", "predicted", "matches"),
    [
        ("aaabb", "11122", {"a": "1", "b": "2"}),
        ("aaabb", "11111", {"a": "1", "b": None}),  # a merge
        ("aaabb", "11233", {"a": "1", "b": "3"}),  # a split
        ("aaabb", "111--", {"a": "1", "b": None}),
        ("aaabbb", "112223", {"a": "1", "b": "2"}),
    ],
)
def test_a_true_room_has_the_colour_of_the_estimated_room_that_matches_it(rng, true, predicted, matches):
    table = in_rooms(rng, true, predicted).keyframes
    estimated, found = estimated_room_colours(table), true_room_colours(table)
    names = {colour: room.removeprefix("room ") for room, colour in estimated.items()}
    assert {room: names.get(colour) for room, colour in found.items()} == matches


def test_estimated_rooms_have_colours_in_the_order_of_their_numbers(rng):
    data = example(rng)
    rooms = ("room 10", "room 9 (office)", "", "room 2 (open-plan office)")
    table = replace(data.keyframes, predicted_rooms=rooms * 10)
    assert list(estimated_room_colours(table)) == ["room 2 (open-plan office)", "room 9 (office)", "room 10", ""]


def test_estimated_rooms_add_little_to_the_page(rng):
    data = in_rooms(rng, "abcdefg", "1234567", each=100)
    without = replace(data, keyframes=replace(data.keyframes, predicted_rooms=("",) * 700))
    assert len(render_report(data)) < 1.2 * len(render_report(without))


def test_layers_and_tables_of_what_is_not_estimated_are_hidden(rng):
    nulls = {"tp": None, "fp": None, "possible": None, "precision": None}
    data = rooms_only(example(rng))
    data = replace(data, result={**data.result, "place_recognition": {"1": nulls, "3": nulls}, "planning": {"queries": 0}})
    page = render_report(data)
    for text in ("only those with a wrong label", "loop edges", "plans that", "Place recognition", "found, N", "queries"):
        assert text not in page
    counts = {"place_recognition": {"1": {"tp": 3, "fp": 1, "possible": 5, "precision": 0.75}}, "planning": {"queries": 2}}
    shown = render_report(replace(example(rng), result={**data.result, **counts}))
    for text in (
        "only those with a wrong label",
        "true loop edges",
        "plans that failed",
        "Place recognition",
        "found, N = 1",
    ):
        assert text in shown


def test_without_poses_the_dots_are_at_the_positions_of_the_odometry_and_no_position_is_said_to_be_estimated(rng):
    data = rooms_only(example(rng))
    data = replace(
        data, estimates_poses=False, keyframes=replace(data.keyframes, estimated_poses=data.keyframes.odometry_poses)
    )
    assert not any(mark.style == "estimated" for mark in run_marks(data, 0, {NO_LABEL: "#000000"}))
    page = render_report(data)
    body = " ".join(page[page.index("<body>") : page.index("<script")].split())
    rooms = {
        "estimated room",
        "estimated rooms",
    }
    assert set(re.findall(r"estimated\W*\w*", body)) == rooms
    assert "at the positions of the odometry" in body and "odometry off by " in body
    assert not any("position error" in finding.text for finding in findings(data))


def test_a_slam_that_estimates_to_close_no_loop_is_told_of_it(rng):
    data = silent(example(rng))
    none = replace(data, result={**data.result, "loops": {"verified": 0}})
    assert [finding.text for finding in findings(none) if "loop" in finding.text] == ["No loop was closed."]


def test_a_failed_run_says_first_what_failed_and_where(rng):
    failure = ShownFailure("test_floors fails\nassert 0.6 > 0.8 & <b>", "in office 1 at 3.5 s: floor 1 estimated", 7)
    page = render_report(replace(example(rng), failure=failure))
    assert "assert 0.6 &gt; 0.8 &amp; &lt;b&gt;" in page and "First wrong: in office 1 at 3.5 s: floor 1 estimated." in page
    assert 0 < page.index('id="failure"') < page.index('id="findings"')
    assert {"data-go": "7", "type": "button"} in [attrs for tag, attrs in Page(page).elements if tag == "button"]
    assert 'id="failure"' not in render_report(example(rng))


def test_labels_that_are_estimated_before_refinement_only_are_not_called_refined(rng):
    data = example(rng)
    nothing = np.full(len(data.keyframes.stamps), UNKNOWN)
    raw = replace(data, keyframes=replace(data.keyframes, predicted_labels=nothing, baseline_labels=nothing + 1))
    assert not any("Refinement" in finding.text for finding in findings(raw))


def test_the_legend_lists_no_label_only_if_some_keyframe_has_none(rng):
    data = example(rng)
    unknown = np.full(len(data.keyframes.stamps), UNKNOWN)
    entry = f"</i>{NO_LABEL}</li>"
    never_before = replace(data, keyframes=replace(data.keyframes, baseline_labels=unknown))
    once = data.keyframes.predicted_labels.copy()
    once[7] = UNKNOWN
    sometimes = replace(data, keyframes=replace(data.keyframes, predicted_labels=once))
    assert [entry in render_report(each) for each in (data, never_before, sometimes)] == [False, False, True]


def test_wrong_floors_are_told(rng):
    data = example(rng)
    floors = [replace(data, result={**data.result, "floors": {"accuracy": share}}) for share in (0.64, 0.9996, 1.0)]
    told = [[finding.text for finding in findings(each) if "floor" in finding.text] for each in floors]
    wrong = "of the keyframes off the stairs are assigned to a wrong floor."
    assert told == [[f"36.0% {wrong}"], [f"Less than 0.1% {wrong}"], []]


def test_a_house_of_no_preset_goes_by_its_name(rng):
    data = example(rng)
    named = replace(data, plans=tuple(replace(plan, house="my <old> house") for plan in data.plans))
    assert "<h1>home " in render_report(named)
    assert "<h1>my &lt;old&gt; house " in render_report(replace(named, result={**data.result, "preset": None}))


def test_the_page_names_the_slam_and_the_faults(rng):
    about = {"slam": "MySlam", "encoder": None, "odometry": "mono", "faults": {"given": ["blur:9", "dropped:0.1"]}}
    data = example(rng)
    page = render_report(replace(data, result={**data.result, **about}))
    assert "compared with the truth · SLAM MySlam · odometry mono · faults blur:9, dropped:0.1" in page
    assert "faults" not in render_report(data).partition("</header>")[0]


def test_findings_name_rooms_in_the_form_of_tooltips(rng):
    data = example(rng, wrong=0)
    table = data.keyframes
    split = [f"room {3 + k % 2} (kitchen)" if true == "kitchen 1" else "" for k, true in enumerate(table.true_rooms)]
    splits = "1 split (several estimated rooms lie mostly in one true room): kitchen 1 = "
    merges = "1 merge (several true rooms lie mostly in one estimated room): estimated room 7 = "
    for rooms, said in (
        (split, f"{splits}estimated rooms 3 (kitchen) and 4 (kitchen)."),
        (["room 7"] * len(split), f"{merges}kitchen 1 and office 1."),
    ):
        told = replace(data, keyframes=replace(table, predicted_rooms=tuple(rooms)))
        assert said in [finding.text for finding in findings(told)]
        assert f" · estimated {rooms[0]} · " in render_report(told)


def test_a_headline_has_no_note_of_figures_that_the_run_does_not_have(rng):
    data = example(rng)
    for baseline in (0.5, None):
        labels = {"accuracy": 0.9, "accuracy_baseline": baseline}
        header = render_report(replace(data, result={**data.result, "labels": labels})).partition("</header>")[0]
        assert ("before refinement" in header) == (baseline is not None)


def test_rooms_that_no_figure_is_about_come_first(rng):
    data = example(rng, wrong=0)
    data = replace(data, unseen_rooms=("gym",))
    assert findings(data)[0] == Finding(False, rooms_without_keyframe(["gym"])) and "do not cover gym." in render_report(
        data
    )


@given(arrays(int, (2, 30), elements=integers(0, 5)))
def test_splits_and_merges_are_those_of_the_result(rooms):
    true, predicted = rooms
    errors = room_errors([str(room) for room in true], [str(room) if room else "" for room in predicted])
    scores = score_rooms(predicted - 1, true)
    assert (surplus(errors.splits), surplus(errors.merges)) == (scores.splits, scores.merges)


@pytest.mark.parametrize(
    ("true", "predicted", "kind", "group"),
    [
        ("aaaabbbb", "xxyybbbb", "splits", {"a": ("x", "y")}),
        ("aaaabbbb", "xxxxxxxx", "merges", {"x": ("a", "b")}),
        ("aaaabbbb", "xxxyyyyy", "partial_losses", {"a": ("y",)}),
        ("aaaaaabbbbbb", "xxxxxyyyyyyy", "partial_losses", {}),
    ],
)
def test_every_kind_of_room_error_is_named_once(true, predicted, kind, group):
    errors = room_errors(list(true), list(predicted))
    assert errors == replace(RoomErrors({}, {}, {}), **{kind: group})


@pytest.mark.parametrize(
    ("change", "problem"),
    [({"loops": (LoopMark(40, 0, True, 1.0),)}, "keyframes in"), ({"label_names": ("kitchen",)}, "true_labels must lie in")],
)
def test_data_that_does_not_fit_is_refused(rng, change, problem):
    with pytest.raises(SimError, match=problem):
        replace(example(rng), **change)
