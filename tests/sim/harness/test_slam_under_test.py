"""A SLAM that is not LEXIS: what it estimates is judged, all else is null, and mistakes of adapters are named."""

import json
import re
from contextlib import suppress
from functools import partial

import numpy as np
import pytest
from helpers.unchecked import unchecked, untyped

from lexis.errors import EncoderError, ObservationError
from sim.errors import SimError
from sim.faults.delivery import Dropped
from sim.faults.stamps import StampJump
from sim.harness import Estimate, EstimatedLoops, Scenario, check, run, try_plans, write_run
from sim.harness.adapters import Lexis, OdometryOnly
from sim.harness.crash import Crash, attempt
from sim.harness.diagnosis.first_wrong import crash_frame, first_wrong
from sim.harness.estimate import CandidateDecision
from sim.harness.figures import evaluate
from sim.harness.last_run import LastRun, last_run, noted
from sim.harness.report_data import report_data
from sim.harness.results import FloorFigures, LabelFigures, LoopFigures, RoomFigures
from sim.harness.scenario_sessions import picture_session
from sim.harness.slam_under_test import check_slam_factory, title_of
from sim.report.findings import findings
from worlds.presets import sample_from_rooms

SCENARIO = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom"), seed=21), seed=5, length_m=15.0, frame_rate_hz=4.0, fidelity="features"
)


class Recorder:
    """Keeps the odometry of every frame, and estimates what it is told to estimate."""

    def __init__(self, **estimates):
        self.estimates, self.frames, self.poses = estimates, [], []

    def start(self, camera, room_names):
        self.room_names = room_names

    def process(self, observation):
        self.frames.append(observation.index)
        self.poses.append(observation.T_O_B)

    def finish(self):
        estimates = {name: estimate(self) if callable(estimate) else estimate for name, estimate in self.estimates.items()}
        return unchecked(Estimate, **{"frames": np.array(self.frames)} | estimates)


def poses(slam):
    return np.array(slam.poses)


def test_what_is_not_estimated_is_null():
    result = check(SCENARIO, Recorder())
    assert result.slam == "Recorder" and result.encoder is None
    assert (result.labels, result.rooms, result.floors, result.loops) == (
        LabelFigures(), RoomFigures(), FloorFigures(), LoopFigures(),
    )  # fmt: skip
    assert result.trajectory.ate_m is None and result.trajectory.ate_odometry_m > 0.0
    assert result.planning.queries == 0 and result.planning.success is None
    json.dumps(result.data(), allow_nan=False)


def test_poses_alone_are_judged_alone():
    result = check(SCENARIO, Recorder(T_W_B=poses))
    assert result.trajectory.ate_m == result.trajectory.ate_odometry_m > 0.0
    assert result.labels == LabelFigures()


def test_the_truth_is_perfect():
    finished = run(SCENARIO, Recorder())
    labels, rooms, floors = finished.true_labels, finished.true_rooms, finished.true_storeys
    result = check(SCENARIO, Recorder(T_W_B=finished.true_poses, labels=labels, rooms=rooms, floors=floors))
    assert result.labels.accuracy == result.rooms.pq == result.floors.accuracy == 1.0
    assert result.trajectory.ate_m < 1e-9 and result.rooms.splits == result.rooms.merges == 0


def test_a_frame_without_a_label_is_wrong_and_shown_without_one():
    finished = run(SCENARIO, Recorder())
    labels = np.where(finished.true_rooms == finished.true_rooms[0], -1, finished.true_labels)
    finished = run(SCENARIO, Recorder(T_W_B=poses, labels=labels, baseline_labels=labels, rooms=finished.true_rooms))
    result = evaluate(finished)
    assert result.labels.accuracy == result.labels.accuracy_baseline == np.mean(labels >= 0) < 1.0
    assert result.labels.accuracy_graded == result.labels.accuracy
    assert first_wrong(finished).what.startswith("no label, is ")
    assert first_wrong(finished, "labels.accuracy").what == first_wrong(finished).what
    assert -1 not in finished.estimate.named_rooms(finished.room_names)
    told = " ".join(finding.text for finding in findings(report_data(finished, result)))
    assert "have no label" in told and "are labelled" not in told


def test_the_report_finds_no_fault_in_what_is_not_estimated():
    finished = run(SCENARIO, Recorder(T_W_B=poses))
    told = " ".join(finding.text for finding in findings(report_data(finished, evaluate(finished))))
    assert "label" not in told and "merge" not in told and "Refinement" not in told
    rooms = run(SCENARIO, Recorder(rooms=finished.true_rooms))
    assert "merge" not in " ".join(finding.text for finding in findings(report_data(rooms, evaluate(rooms))))
    labels = run(SCENARIO, Recorder(labels=finished.true_labels))
    assert "Refinement" not in " ".join(finding.text for finding in findings(report_data(labels, evaluate(labels))))


def test_a_folder_is_written_for_any_estimates(tmp_path):
    for name, estimates in {
        "nothing": {},
        "poses": {"T_W_B": poses},
        "no label": {"labels": every(-1), "rooms": every(-1)},
    }.items():
        finished = run(SCENARIO, Recorder(**estimates))
        write_run(finished, evaluate(finished), try_plans(finished), tmp_path / name)
        assert (tmp_path / name / "report.html").exists() and not (tmp_path / name / "map").exists()
        assert (tmp_path / name / "trajectory.tum").exists() == ("T_W_B" in estimates)


def test_refused_observations_are_counted_under_faults_and_fatal_without():
    class Picky(Recorder):
        def process(self, observation):
            if observation.index % 3 == 1:
                raise ObservationError("not this one")
            super().process(observation)

    with pytest.raises(ObservationError, match="not this one"):
        check(SCENARIO, Picky())
    faulty = Scenario(**{**vars(SCENARIO), "faults": (Dropped(0.1),)})
    assert check(faulty, Picky()).faults.refused > 5


def test_estimates_of_another_size_are_named():
    with pytest.raises(SimError, match="labels has 3 rows; valid: 5, one for each of the frames"):
        unchecked(Estimate, frames=np.arange(5), labels=np.zeros(3, int))


@pytest.mark.parametrize(
    ("estimates", "message"),
    [
        ({"frames": [0, 1]}, "frames is a list; valid: an array of whole numbers, one for each frame"),
        ({"labels": [0] * 5}, "labels is a list; valid: an array of whole numbers of shape (n)"),
        (
            {"labels": np.array(["kitchen"] * 5)},
            "labels is <U7 (5,); valid: an array of whole numbers of shape (n), indices into room_names or -1",
        ),
        ({"floors": ["ground"] * 5}, "floors is a list; valid: an array of whole numbers of shape (n), with -1 on stairs"),
        ({"rooms": np.zeros(5)}, "rooms is float64 (5,); valid: an array of whole numbers of shape (n)"),
        ({"T_W_B": np.zeros((5, 3, 4))}, "T_W_B has shape (5, 3, 4); valid: (5, 4, 4)"),
        ({"T_W_B": np.zeros((5, 4, 4))}, "T_W_B is no rigid motion in row 0; valid: rotation and translation"),
        ({"similarities": np.zeros(5)}, "similarities is float64 (5,); valid: an array of numbers of shape (n, any)"),
        ({"candidates": np.zeros((2, 2))}, "candidates is array([[0., 0.],"),
        ({"candidates": ((k, (0,)) for k in (1, 2))}, "candidates is <generator"),
        ({"candidates": ((2, (k for k in (0, 1))),)}, "candidates is ((2, <generator"),
        (
            {"stage_seconds": {"loops": None}},
            "stage_seconds is {'loops': None}; valid: a mapping of the stage's name to seconds",
        ),
        ({"stage_seconds": {"loops": np.nan}}, "stage_seconds['loops'] is nan; valid: 0 to 1e+09 s"),
        ({"stage_seconds": {"loops": 10**400}}, "stage_seconds['loops'] is 1"),
        ({"stage_seconds": {3: 1.0}}, "name in stage_seconds is 3; valid: a text"),
        ({"encoder": 5}, "encoder is 5; valid: a text"),
        ({"encoder": "\ud800"}, r"encoder is '\ud800'; valid: a text"),
        ({"T_W_B": np.ma.masked_array(np.tile(np.eye(4), (5, 1, 1)), mask=True)}, "T_W_B is a MaskedArray; valid: an array"),
        (
            {"T_W_B": np.tile(np.eye(4), (5, 1, 1)) + np.eye(4, k=3) * 1e160},
            "T_W_B is beyond 1e+08 m in row 0; valid: places",
        ),
        (
            {"decisions": (unchecked(CandidateDecision, None, 0, True, "", {}),)},
            "query or match of a decision is no whole number",
        ),
        (
            {"decisions": (unchecked(CandidateDecision, 1, 0, True, ["far"], {}),)},
            "reason of a decision is ['far']; valid: a text",
        ),
        (
            {"decisions": (unchecked(CandidateDecision, 1, 0, True, "", None),)},
            "figures of a decision are None; valid: a mapping",
        ),
        (
            {"decisions": (unchecked(CandidateDecision, 1, 0, True, "", {"inliers": None}),)},
            "figures['inliers'] of a decision is None; valid: a number",
        ),
    ],
)
def test_estimates_of_another_form_are_named(estimates, message):
    with pytest.raises(SimError, match=re.escape(message)):
        unchecked(Estimate, **{"frames": np.arange(5)} | estimates)


def test_times_of_any_number_type_can_be_stored():
    estimate = unchecked(Estimate, np.arange(5), stage_seconds={"loops": np.float32(0.5)})
    assert json.loads(json.dumps(dict(estimate.stage_seconds))) == {"loops": 0.5}


def test_transposed_poses_are_recognised():
    pose = np.eye(4)
    pose[:3] = [[0.0, -1.0, 0.0, 2.0], [1.0, 0.0, 0.0, 3.0], [0.0, 0.0, 1.0, 4.0]]
    poses = np.array([np.eye(4), pose.T])
    message = "T_W_B is no rigid motion in row 1: the last row is not 0 0 0 1; is the pose transposed?"
    with pytest.raises(SimError, match=re.escape(message)):
        Estimate(frames=np.arange(2), T_W_B=poses)
    loops = EstimatedLoops(query=np.array([1]), match=np.array([0]), T_match_query=poses[1:])
    with pytest.raises(SimError, match=re.escape(message.replace("T_W_B", "loops.T_match_query").replace("row 1", "row 0"))):
        Estimate(frames=np.arange(2), loops=loops)


def test_frames_that_were_dropped_are_no_valid_frames():
    faulty = Scenario(**{**vars(SCENARIO), "faults": (Dropped(0.5),)})
    with pytest.raises(SimError, match=r"in row \d+; valid: \d+ to \d+, without observations that were dropped"):
        check(faulty, Recorder(frames=np.arange(40)))


def test_a_crash_is_placed_at_the_frame_that_the_slam_was_given_even_if_frames_were_dropped():
    class Lost(Recorder):
        def process(self, observation):
            super().process(observation)
            if len(self.frames) == 10:
                raise RuntimeError("lost")

    slam = Lost()
    faulty = Scenario(**{**vars(SCENARIO), "faults": (Dropped(0.5),)})
    crash = attempt(lambda scenario, progress: run(scenario, slam, progress), faulty)
    assert crash_frame(picture_session(faulty), crash.done).frame == slam.frames[-1] > 10


def test_lists_in_an_estimate_are_copied():
    candidates = [(5, [0])]
    kept = unchecked(Estimate, np.arange(9), candidates=candidates)
    candidates[0][1][:] = [99]
    assert kept.candidates == ((5, (0,)),)


def test_settings_that_cannot_be_stated_are_a_crash_before_the_walk():
    class Unsettled(Recorder):
        @property
        def settings(self):
            raise RuntimeError("no settings")

    slam = Unsettled()
    crash = attempt(lambda scenario, progress: run(scenario, slam, progress), SCENARIO)
    assert isinstance(crash, Crash) and crash.message == "RuntimeError: no settings" and not slam.frames


def test_an_exception_before_a_run_is_no_crash_of_the_run_before():
    def fails(scenario, progress):
        with last_run().calling_slam():
            raise RuntimeError("no second SLAM")

    with noted():
        assert not isinstance(attempt(lambda scenario, progress: run(scenario, Recorder(), progress), SCENARIO), Crash)
        crash = attempt(fails, SCENARIO)
    assert (crash.done, crash.slam) == (None, "")


@pytest.mark.parametrize("error", [ValueError, EncoderError, SimError])
def test_an_exception_of_any_kind_in_the_middle_of_a_run_is_a_crash(error):
    class Failing(Recorder):
        def process(self, observation):
            raise error("unusable image")

    crash = attempt(lambda scenario, progress: run(scenario, Failing(), progress), SCENARIO)
    assert isinstance(crash, Crash) and crash.sentence == f"the SLAM raises {error.__name__}: unusable image"


@pytest.mark.parametrize("error", [EncoderError, SimError])
def test_a_model_or_setting_that_cannot_be_used_is_no_crash(error):
    class Unloadable(Recorder):
        def start(self, camera, room_names):
            raise error("no checkpoint")

    with pytest.raises(error, match="no checkpoint"):
        attempt(lambda scenario, progress: run(scenario, Unloadable(), progress), SCENARIO)


def test_an_exception_that_a_method_may_raise_is_not_the_fault_of_the_slam():
    last = LastRun()
    for allowed, blamed in ((KeyError,), False), ((), True):
        with suppress(KeyError), last.calling_slam(*allowed):
            raise KeyError
        assert last.in_slam is blamed


def test_a_clock_that_jumps_far_back_is_reported_on_the_clock_of_the_tour(tmp_path):
    jumping = Scenario(**{**vars(SCENARIO), "faults": (StampJump(1e9, at_s=2.0),)})
    finished = run(jumping, Recorder(T_W_B=poses))
    assert finished.stamps[-1] < 0.0
    write_run(finished, evaluate(finished), (), tmp_path / "out")
    assert Scenario.load(tmp_path / "out" / "scenario.json") == jumping
    drawn = report_data(finished, evaluate(finished)).keyframes.stamps
    np.testing.assert_array_equal(drawn, finished.session.tour.stamps[finished.estimate.frames])


def test_figures_do_not_depend_on_the_number_types_of_the_estimates():
    def typed(whole, real):
        loops = one_loop(query=np.array([9], whole), match=np.array([0], whole), weights=np.ones(1, real))
        frames, poses = np.arange(10).astype(whole), np.tile(np.eye(4), (10, 1, 1))
        return unchecked(Estimate, frames, poses, rooms=np.zeros(10, whole), loops=loops)

    kinds = {each.dtype for each in (*vars(typed(np.uint64, np.float32).loops).values(), typed(np.int32, float).rooms)}
    assert kinds == {np.dtype(np.int64), np.dtype(np.float64)}


def test_estimates_are_checked_as_they_are_returned():
    class Spoiling(Recorder):
        def finish(self):
            estimate = super().finish()
            estimate.T_W_B[5, 0, 3] = np.nan
            return estimate

    with pytest.raises(SimError, match="T_W_B is not finite in row 5"):
        check(SCENARIO, Spoiling(T_W_B=poses))


class Saving(Recorder):
    """Saves a file in its own folder and one beside it."""

    def save(self, folder):
        assert not list(folder.iterdir())
        (folder / "map").mkdir()
        for name in ("map/weights.bin", self.estimates.get("name", "notes.txt")):
            (folder / name).write_text("own")

    def finish(self):
        return Estimate(np.array(self.frames))


def test_files_of_a_slam_are_in_the_folder_of_the_run(tmp_path):
    finished = run(SCENARIO, Saving())
    write_run(finished, evaluate(finished), (), tmp_path / "out")
    assert (tmp_path / "out" / "map" / "weights.bin").read_text() == (tmp_path / "out" / "notes.txt").read_text() == "own"
    write_run(finished, evaluate(finished), (), tmp_path / "out")


@pytest.mark.parametrize("name", ["result.json", "scenario.json", "report.html", "why.md"])
def test_files_of_a_slam_never_replace_those_of_the_harness(tmp_path, name):
    finished = run(SCENARIO, Saving(name=name))
    with pytest.raises(SimError, match=re.escape(f"save() wrote {name!r}, a name of the harness")):
        write_run(finished, evaluate(finished), (), tmp_path / "out", {"why.md": b"because"})
    assert not list(tmp_path.iterdir())


def test_loops_of_another_form_are_named():
    listed = unchecked(EstimatedLoops, query=[1], match=[0], T_match_query=[np.eye(4)])
    with pytest.raises(SimError, match=re.escape("loops.query is a list; valid: an array of whole numbers of shape (n)")):
        unchecked(Estimate, frames=np.arange(5), loops=listed)


def every(value):
    return lambda slam: np.full(len(slam.frames), value)


def one_loop(**changes):
    values = {"query": np.array([5]), "match": np.array([0]), "T_match_query": np.eye(4)[None], "weights": np.ones(1)}
    return unchecked(EstimatedLoops, **values | changes)


@pytest.mark.parametrize(
    ("estimates", "message"),
    [
        ({"frames": np.array([0, 10**6])}, r"frames has 1000000 in row 1; valid: 0 to \d+$"),
        (
            {"frames": np.array([3, 166, 165])},
            "frames has 165 after 166 in row 2; valid: one or more indices of observations",
        ),
        ({"frames": np.array([7, 7])}, "frames has 7 after 7 in row 1; valid: .* from 0 and ascending"),
        ({"frames": np.array([-1, 7])}, "frames has -1 in row 0; valid: one or more indices of observations, from 0"),
        ({"frames": np.array([7, 3], np.uint8)}, "frames has 3 after 7 in row 1"),
        ({"frames": np.array([7, 2**63 + 5], np.uint64)}, "frames has 9223372036854775813 in row 1; valid: numbers up to"),
        ({"rooms": lambda slam: every(-1)(slam).astype(np.uint64)}, "rooms has 18446744073709551615 in row 0; valid"),
        ({"frames": np.zeros(0, int)}, "frames is empty; valid: one or more indices of observations"),
        ({"T_W_B": lambda slam: np.full((len(slam.frames), 4, 4), np.nan)}, "T_W_B is not finite in row 0"),
        (
            {"loops": one_loop(query=np.array([10**6]))},
            "decisions refer to rows 0 to 1000000; valid: 0 to",
        ),
        ({"loops": one_loop(match=np.array([0, 1]))}, "loops.match has 2 rows; valid: 1, one for each loop closure"),
        ({"frames": np.ma.array([3, 1, 7], mask=[0, 1, 0])}, "frames is a MaskedArray"),
        ({"loops": one_loop(weights=np.array([7.0]))}, "loops.weights are 7 to 7; valid: numbers in"),
        ({"loops": one_loop(weights=np.array([np.nan]))}, "loops.weights is not finite in row 0"),
        ({"loops": one_loop(T_match_query=np.zeros((1, 4, 4)))}, "loops.T_match_query is no rigid motion in row 0"),
        ({"loops": one_loop(query=np.array([0]), match=np.array([2]))}, "query 0 and match 2 in row 0; valid: a query that"),
        (
            {"loops": EstimatedLoops(np.array([5, 4, 5]), np.array([1, 1, 1]), np.tile(np.eye(4), (3, 1, 1)))},
            "loops has the pair of query 5 and match 1 in rows 0 and 2; valid: each pair once",
        ),
        ({"loops": []}, "loops is a list; valid: EstimatedLoops"),
        (
            {"loops": unchecked(EstimatedLoops, query=np.array(5), match=np.zeros(1, int), T_match_query=np.eye(4)[None])},
            r"loops.query is int64 \(\); valid: an array of whole numbers",
        ),
        ({"candidates": ((2, 0),)}, r"candidates is \(\(2, 0\),\); valid: a tuple of pairs"),
        ({"candidates": ((4, (0,)), (4, (1,)))}, "candidates has two entries for row 4; valid: one for each query"),
        ({"candidates": {2: (0,)}}, "candidates is {2: .*; valid: a tuple of pairs of a row and other rows"),
        ({"candidates": ((2, (0.5,)),)}, "candidates is .*; valid: a tuple of pairs of a row and other rows"),
        ({"decisions": (True,)}, r"decisions is \(True,\); valid: a tuple of CandidateDecision"),
        ({"stage_seconds": None}, "stage_seconds is None; valid: a mapping"),
        ({"candidates": ((0, (-1,)),)}, "loops, candidates and decisions refer to rows -1 to 0; valid"),
        ({"labels": every(-2)}, "labels has -2 in row 0; valid: numbers from 0, or -1 for none"),
        ({"baseline_labels": every(3)}, "baseline_labels has 3 in row 0; valid: -1 to 2, since there are 3 room names"),
        ({"rooms": every(-2)}, "rooms has -2 in row 0; valid: numbers from 0, or -1 for none"),
        ({"floors": every(-2)}, "floors has -2 in row 0; valid: numbers from 0, or -1 for none"),
        (
            {"similarities": lambda slam: np.zeros((len(slam.frames), 2))},
            "similarities has 2 columns; valid: 3, one for each",
        ),
    ],
)
def test_estimates_that_cannot_be_are_named(estimates, message):
    with pytest.raises(SimError, match=message):
        check(SCENARIO, Recorder(**estimates))


class Untouched(Recorder):
    def start(self, *arguments):
        raise AssertionError("the methods are checked before the house is built")


@pytest.mark.parametrize(
    ("method", "message"),
    [
        (None, "SLAM under test: Slam has no method finish(); valid: start(), process() and finish()"),
        (
            lambda self, wait: None,
            "SLAM under test: Slam has def finish(self, wait): missing a required argument: 'wait'; valid: def finish(self)",
        ),
        (
            lambda: None,
            "SLAM under test: Slam has def finish(): too many positional arguments; valid: def finish(self)",
        ),
    ],
)
def test_a_method_that_the_harness_cannot_call_is_named_before_the_run(method, message):
    slam = type("Slam", (Untouched,), {"finish": method})()
    with pytest.raises(SimError, match=f"^{re.escape(message)}$"):
        untyped(run)(SCENARIO, slam)


@pytest.mark.parametrize("scenario", [None, {}, SCENARIO.house, "scenario.json"])
def test_what_is_no_scenario_is_refused(scenario):
    with pytest.raises(SimError, match=r"^scenario is an instance of \w+; valid: a Scenario, such as Scenario\("):
        untyped(run)(scenario, OdometryOnly())


def test_the_arguments_of_start_are_named():
    class Slam(Recorder):
        def start(self, camera: str) -> None:
            pass

    message = "Slam has def start(self, camera): too many positional arguments; valid: def start(self, camera, room_names)"
    with pytest.raises(SimError, match=re.escape(message)):
        run(SCENARIO, Slam())


@pytest.mark.parametrize(
    ("new_slam", "what"),
    [
        (Recorder(), "an instance of Recorder; valid: the class of a SLAM, or a function that makes a SLAM"),
        (
            lambda name: Recorder(),
            "an instance of function, which cannot be called without arguments: missing a required argument: 'name'; "
            "valid: a class or function without arguments, such as functools.partial(MySlam, argument)",
        ),
    ],
)
def test_what_makes_no_slam_without_arguments_is_refused(new_slam, what):
    with pytest.raises(SimError, match=f"^test: slam is {re.escape(what)}$"):
        check_slam_factory("test: slam", new_slam)


@pytest.mark.parametrize("new_slam", [Recorder, lambda *names: Recorder(), partial(Recorder, labels=None), type])
def test_what_can_be_called_without_arguments_may_make_a_slam(new_slam):
    check_slam_factory("test: slam", new_slam)


def test_methods_may_name_their_arguments_otherwise_and_have_more_with_defaults():
    class Slam(Recorder):
        def start(self, *arguments, **more):
            super().start(*arguments)

        def process(self, seen, /, verbose=False):
            super().process(seen)

    assert check(SCENARIO, Slam()).slam == "Slam"


@pytest.mark.parametrize(
    ("settings", "title"),
    [("no loops", "Tuned (no loops)"), ("", "Tuned"), ({"loops": 0}, "Tuned"), ("x" * 90, f"Tuned ({'x' * 79}…)")],
)
def test_stated_settings_stand_beside_the_name(settings, title):
    class Tuned(OdometryOnly):
        pass

    Tuned.settings = settings
    assert title_of(Tuned()) == title


def test_a_result_says_with_which_settings_lexis_ran():
    assert title_of(Lexis()) == "Lexis"
    assert title_of(Lexis(loops=False)) == "Lexis (place_recognition.candidates=0)"
