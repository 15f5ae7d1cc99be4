"""A program in any language under test: it is judged like a class, it is told no truth, and errors are named."""

import json
import math
import sys
from dataclasses import replace

import numpy as np
import pytest
from helpers.documentation import blocks
from helpers.unchecked import unchecked

from lexis.datasets.dataset import open_dataset
from lexis.errors import LexisError
from lexis.files.tum_trajectory import write_tum
from sim.errors import SimError
from sim.faults.delivery import Dropped
from sim.harness import Scenario, check, evaluate, write_run
from sim.harness.adapters import GeometricRooms
from sim.programs import Program
from sim.programs.loop_file import read_loops
from sim.programs.program_files import AT_REST, RecordedTimes, read_estimate
from sim.record.recording import write_take
from sim.record.take import prepare
from sim.render.rig import RigConfig, build_rig
from sim.world_states import FrameRenderer
from worlds.presets import sample_from_rooms

SCENARIO = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom"), seed=21),
    seed=5,
    length_m=10.0,
    frame_rate_hz=4.0,
    rig=RigConfig("wide", 160, 120),
)
GEOMETRIC = """
import json, sys
from pathlib import Path
from lexis.datasets.dataset import open_dataset
from lexis.files.tum_trajectory import write_tum
from sim.harness.adapters import GeometricRooms

slam, seen = GeometricRooms(), {}
recording = open_dataset(Path(sys.argv[1]))
slam.start(recording.camera, ())
for observation in recording:
    if observation.stamp >= 1e9 + 12.0:  # before, the body rests
        slam.process(observation)
        seen[observation.index] = observation
estimates, out = slam.finish(), Path(sys.argv[2])
stamps = [seen[frame].stamp for frame in estimates.frames.tolist()]
write_tum(out / "trajectory.tum", stamps, estimates.T_W_B)
frames = zip(stamps, estimates.rooms.tolist(), estimates.floors.tolist())
frames = [{"stamp": stamp, "room": room, "floor": floor} for stamp, room, floor in frames]
(out / "rooms.json").write_text(json.dumps({"version": 1, "frames": frames}))
"""


@pytest.fixture
def unlit(monkeypatch):
    """Replaces rendering: frames are black and cost nothing."""
    size = build_rig(SCENARIO.rig).size_px[::-1]
    monkeypatch.setattr(FrameRenderer, "rgb", lambda *_: np.zeros((*size, 3), np.uint8))
    monkeypatch.setattr(FrameRenderer, "depth", lambda *_: np.zeros(size, np.float32))


@pytest.fixture
def unrecorded(monkeypatch):
    """Leaves the folder of the recording empty, for programs that do not look at it."""
    monkeypatch.setattr("sim.programs.program.write_take", lambda *_, **__: None)


def program(folder, content):
    """The command of a Python program."""
    path = folder / "program.py"
    path.write_text(content)
    return f"'{sys.executable}' '{path}' {{dataset}} {{out}}"


@pytest.mark.parametrize(("images", "topic"), [("png", b"CompressedImage"), ("raw", b"sensor_msgs/msg/Image")])
def test_the_recording_holds_the_kind_of_images_that_was_asked_for(tmp_path, unlit, images, topic):
    content = f"""
import sys
from pathlib import Path
bag = b"".join(path.read_bytes() for path in (Path(sys.argv[1]) / "bag").iterdir())
assert {topic!r} in bag, "no such topic"
(Path(sys.argv[2]) / "trajectory.tum").write_text("1003.0 0 0 0 0 0 0 1")
"""
    with pytest.raises(SimError, match="stamp"):  # the program found the topic, and estimated a pose at no frame
        Program(program(tmp_path, content), "ros2", images=images)(SCENARIO)


def test_a_program_is_judged_as_the_class_that_it_wraps(tmp_path, unlit):
    inside = check(SCENARIO, GeometricRooms())
    command = program(tmp_path, GEOMETRIC)
    outside = evaluate(Program(command, "tum")(SCENARIO))
    assert outside.slam == command
    for figures in ("house", "run", "labels", "rooms", "floors", "loops", "coverage"):
        assert getattr(outside, figures) == getattr(inside, figures), figures
    assert outside.trajectory.ate_m == pytest.approx(inside.trajectory.ate_m, abs=1e-6)
    assert outside.trajectory.ate_odometry_m == pytest.approx(inside.trajectory.ate_odometry_m, abs=1e-12)


def test_the_program_of_the_documentation_runs_on_images(tmp_path):
    (block,) = (block for block in blocks("sim/pages/your-slam.md") if block.language == "py")
    finished = Program(program(tmp_path, block.content + "print('done')\n"))(SCENARIO)
    result = evaluate(finished)
    assert result.trajectory.ate_m == pytest.approx(result.trajectory.ate_odometry_m, abs=1e-6)
    assert 0.0 < result.labels.accuracy < 1.0 and result.floors.accuracy == 1.0 and result.rooms.count_error < 0
    assert result.coverage.path_covered > 0.9
    write_run(finished, result, (), tmp_path / "out")
    assert (tmp_path / "out" / "program.out").read_text() == "done\n"
    assert (tmp_path / "out" / "report.html").exists()


def test_a_program_is_judged_under_faults(tmp_path, unlit):
    (block,) = (block for block in blocks("sim/pages/your-slam.md") if block.language == "py")
    result = evaluate(Program(program(tmp_path, block.content))(replace(SCENARIO, faults=(Dropped(0.3),))))
    assert result.faults.delivered < 0.85 * result.run.frames
    assert result.trajectory.ate_m == pytest.approx(result.trajectory.ate_odometry_m, abs=1e-6)


@pytest.mark.parametrize("form", ["euroc", "tum", "mcap"])
def test_a_recording_without_truth_differs_in_the_truth_alone(form, tmp_path, unlit):
    files = {}
    for told in (True, False):
        folder = tmp_path / str(told)
        folder.mkdir()
        write_take(folder, prepare(SCENARIO, with_truth=told), form)
        files[told] = {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    known = files[False]
    hidden = files[True].keys() - known.keys()
    assert hidden == {"house.json"} | {
        "euroc": {f"mav0/state_groundtruth_estimate0/{name}" for name in ("data.csv", "sensor.yaml")},
        "tum": {"groundtruth.txt"},
    }.get(form, set())
    changed = {name for name in known if known[name] != files[True][name]}
    assert {name for name in changed if not name.startswith("bag/")} == {"rooms.json"}
    assert json.loads(known["rooms.json"]).keys() == {"schema", "labels"}
    assert not any(b"ground_truth" in content for content in known.values())
    assert any(b"ground_truth" in content for content in files[True].values()) == (form == "mcap")
    assert len(open_dataset(tmp_path / "False")) == len(open_dataset(tmp_path / "True"))


LOOPS = """
from scipy.spatial.transform import Rotation

loops = []
for k, error in ((20, 0.0), (21, 0.6)):
    (q, *query), (m, *match) = ([float(word) for word in poses[row].split()] for row in (k, 10))
    turn = Rotation.from_quat(match[3:]).inv()
    x, *rest = *turn.apply([a - b for a, b in zip(query, match)][:3]), *(turn * Rotation.from_quat(query[3:])).as_quat()
    loops.append({"query": q, "match": m, "T_match_query": [x + error, *rest]})
(out / "loops.json").write_text(json.dumps({"version": 1, "loops": loops}))
"""


QUIET = "import sys; sys.exit(0)"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (QUIET, "the program wrote no {out}/trajectory.tum"),
        ("import sys\nprint('no', 'vocabulary', file=sys.stderr)\nsys.exit(3)", "ended with exit status 3: no vocabulary"),
        ("import sys; sys.exit(4)", "exit status 4: nothing on stderr"),
        ("import os; os.kill(os.getpid(), 11)", "ended with signal 11"),
        ("import time; time.sleep(600)", "took longer than 0.5 s"),
        ("kept = bytearray(10**9)", "exit status 1: MemoryError"),
        ("import sys\nopen(sys.argv[2] + '/trajectory.tum', 'w').write('1 2 3')", "trajectory.tum:1: '1 2 3'"),
    ],
)
def test_what_a_program_does_wrong_is_named_in_one_line(content, message, tmp_path, unrecorded):
    timeout_s = 0.5 if "sleep" in content else 30.0
    with pytest.raises((SimError, LexisError)) as caught:
        Program(program(tmp_path, content), timeout_s=timeout_s, memory_mb=500.0)(SCENARIO)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_a_program_that_prints_without_end_does_not_fill_the_disk(tmp_path, unrecorded, monkeypatch):
    monkeypatch.setattr("sim.programs.limited_process.LARGEST_FILE_BYTES", 10**7)
    endless = program(
        tmp_path, "import signal\nsignal.signal(signal.SIGXFSZ, signal.SIG_DFL)\nwhile True: print('x' * 10**5)"
    )
    with pytest.raises(SimError, match=r"ended with signal 25 \(File size limit exceeded\)"):
        Program(endless, timeout_s=30.0)(SCENARIO)


@pytest.mark.parametrize(
    ("command", "scenario", "message"),
    [
        ("./my_slam {dataset}", SCENARIO, "has no {out}; valid: such as './my_slam {dataset} {out}'"),
        ("", SCENARIO, "has no {dataset}"),
        ("{dataset} {out}", SCENARIO, "names no program; valid: such as './my_slam {dataset} {out}'"),
        ("'./my_slam {dataset} {out}", SCENARIO, "No closing quotation"),
        ("./my_slam {dataset} {out} > log.txt", SCENARIO, "has '>', but it is started without a shell; valid: a script"),
        ("x {dataset} {out}", replace(SCENARIO, fidelity="features"), "needs images, but the fidelity is 'features'"),
    ],
)
def test_commands_that_cannot_be_run_are_named_before_the_walk(command, scenario, message):
    with pytest.raises(SimError) as caught:
        Program(command)(scenario)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    "limit",
    [{"timeout_s": -1.0}, {"timeout_s": math.nan}, {"memory_mb": math.inf}, {"memory_mb": 0.0}, {"timeout_s": "600"}],
)
def test_limits_that_are_not_valid_are_named_before_the_walk(limit):
    with pytest.raises(SimError, match=f"program: {next(iter(limit))} is .*; valid: a number of (s|MB) above 0"):
        unchecked(Program, "true {dataset} {out}", **limit)


def test_a_command_that_is_no_text_is_named():
    with pytest.raises(SimError, match=r"command is an instance of list; valid: text, such as '\./my_slam"):
        unchecked(Program, ["true", "{dataset}", "{out}"])


def test_programs_that_are_not_there_or_not_executable_are_named(tmp_path, unrecorded):
    (tmp_path / "text").write_text("no program")
    (tmp_path / "script").write_text("#!/no/such/interpreter\n")
    (tmp_path / "script").chmod(0o755)
    (tmp_path / "loop").symlink_to("loop")
    for name, message in (
        ("missing", "was not found"),
        ("text", "cannot be run: "),
        ("script", "script' cannot be run: the interpreter in its first line was not found; valid: "),
        ("loop", "cannot be run: "),
    ):
        with pytest.raises(SimError, match=message):
            Program(f"'{tmp_path / name}' {{dataset}} {{out}}")(SCENARIO)


@pytest.mark.parametrize(("name", "message"), [("missing", "was not found"), ("text", "it is not executable; valid: chmod")])
def test_a_program_that_cannot_be_run_is_named_before_the_walk_is_recorded(name, message, tmp_path, monkeypatch):
    monkeypatch.setattr("sim.programs.program.prepare", lambda *_, **__: pytest.fail("the walk is recorded"))
    (tmp_path / "text").write_text("no program")
    with pytest.raises(SimError, match=message):
        Program(f"'{tmp_path / name}' {{dataset}} {{out}}")(SCENARIO)


TIMES = RecordedTimes(1e9 + 0.25 * np.arange(10), np.array([AT_REST, AT_REST, *range(8)]), 0.25)
NAMES = ("kitchen", "bedroom")


def estimated(folder, stamps, frames=None, loops=None):
    """The estimate of a program that writes a pose for each of these stamps, in frame periods after the first."""
    poses = np.tile(np.eye(4), (len(stamps), 1, 1))
    poses[:, 0, 3] = stamps
    write_tum(folder / "trajectory.tum", 1e9 + 0.25 * np.array(stamps, float), poses)
    if frames is not None:
        entries = [{**entry, "stamp": 1e9 + 0.25 * entry["stamp"]} for entry in frames]
        (folder / "rooms.json").write_text(json.dumps({"version": 1, "frames": entries}))
    if loops is not None:
        (folder / "loops.json").write_text(json.dumps({"version": 1, **loops}))
    return read_estimate(folder, TIMES, NAMES)


def at(period):
    """The stamp that is this many frame periods after the first [s]."""
    return 1e9 + 0.25 * period


def loop(query, match, quaternion=(0.0, 0.0, 0.0, 1.0), **more):
    """A loop closure in which the later body is 1 m, 2 m and 3 m from the earlier one; times in frame periods."""
    return {"query": at(query), "match": at(match), "T_match_query": [1.0, 2.0, 3.0, *quaternion], **more}


def test_poses_belong_to_the_frames_that_are_nearest_in_time(tmp_path):
    estimate = estimated(tmp_path, [0.0, 2.4, 3.9, 4.2, 4.6, 9.4])
    assert estimate.frames.tolist() == [0, 2, 3, 7]
    np.testing.assert_allclose(estimate.T_W_B[:, 0, 3], [2.4, 3.9, 4.6, 9.4])
    assert estimate.labels is None and estimate.rooms is None and estimate.floors is None


def test_the_frames_of_rooms_json_are_the_keyframes(tmp_path):
    frames = [{"stamp": 5.1, "label": "bedroom", "room": 4}, {"stamp": 3.0, "label": "kitchen", "room": -1}]
    estimate = estimated(tmp_path, range(10), frames)
    assert estimate.frames.tolist() == [1, 3]
    assert estimate.labels.tolist() == [0, 1] and estimate.rooms.tolist() == [-1, 4] and estimate.floors is None
    np.testing.assert_allclose(estimate.T_W_B[:, 0, 3], [3.0, 5.0])


@pytest.mark.parametrize(
    ("stamps", "frames", "message"),
    [
        ([-0.6], None, "matches no frame; valid: 1000000000.000000 to 1000000002.250000 s"),
        ([2.0, 9.6], None, "stamp 1000000002.400000 matches no frame; valid"),
        ([-4e9 + 2.0, -4e9 + 3.0], None, "stamp 0.500000 matches no frame (counted from the first frame?); valid"),
        ([4e18 - 4e9 + 2e9], None, "matches no frame (in nanoseconds?); valid"),
        ([0.0, 1.0], None, "no stamp is within 0.125 s of a frame of the walk"),
        ([2.0], [{"stamp": 12.0}], "rooms.json: stamp 1000000003.000000 matches no frame"),
        ([2.0], [{"stamp": 5.0}], "has no pose; valid: frames that trajectory.tum holds"),
        ([2.0], [{"stamp": 2.0}, {"stamp": 2.1}], "belongs to a frame with another entry"),
        ([0.0, 2.0], [{"stamp": 0.0}], "every stamp is before the walk"),
        ([2.0], [{"stamp": 2.0, "label": "ktchen"}], "unknown label 'ktchen' (did you mean 'kitchen'?); valid: kitchen"),
        ([2.0, 3.0], [{"stamp": 2.0, "room": 1}, {"stamp": 3.0}], "has no room, others have; valid: all frames or none"),
        ([2.0], [{"stamp": 2.0, "room": -2}], "frames.0.room: "),
        ([2.0], [{"stamp": 2.0, "lable": "kitchen"}], "frames.0.lable: Extra inputs are not permitted"),
        ([2.0], [], "frames: "),
    ],
)
def test_wrong_estimates_are_named(stamps, frames, message, tmp_path):
    with pytest.raises(SimError) as caught:
        estimated(tmp_path, stamps, frames)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_loops_and_candidates_refer_to_the_keyframes(tmp_path):
    keyframes = [{"stamp": 3.0, "room": 0}, {"stamp": 5.1, "room": 0}, {"stamp": 7.0, "room": 0}]
    candidates = [{"query": at(7.1), "matches": [at(5), at(3)]}]
    estimates = {"loops": [loop(7, 3, weight=0.5), loop(5, 3.1)], "candidates": candidates}
    estimate = estimated(tmp_path, range(10), keyframes, estimates)
    assert estimate.loops.query.tolist() == [2, 1] and estimate.loops.match.tolist() == [0, 0]
    assert estimate.loops.weights.tolist() == [0.5, 1.0] and estimate.candidates == ((2, (1, 0)),)
    np.testing.assert_array_equal(estimate.loops.T_match_query[0, :3], np.c_[np.eye(3), [1.0, 2.0, 3.0]])
    assert estimated(tmp_path, range(10), keyframes, {"loops": [loop(7, 3), loop(5, 3.1)]}).loops.weights is None


def test_loops_and_candidates_before_the_walk_are_left_out(tmp_path):
    candidates = [{"query": at(7), "matches": [at(0), at(3)]}, {"query": at(1), "matches": [at(0)]}]
    estimates = {"loops": [loop(7, 0, weight=0.5), loop(7, 3, weight=0.8), loop(1, 0)], "candidates": candidates}
    estimate = estimated(tmp_path, range(10), loops=estimates)
    assert estimate.loops.query.tolist() == [5] and estimate.loops.match.tolist() == [1]
    assert estimate.loops.weights.tolist() == [0.8] and estimate.candidates == ((5, (1,)),)


def test_the_frames_are_searched_once_for_all_candidates(tmp_path):
    candidates = [{"query": float(k), "matches": [float(m) for m in range(k % 4)]} for k in range(4, 40)]
    (tmp_path / "loops.json").write_text(json.dumps({"version": 1, "loops": [], "candidates": candidates}))
    calls = []

    def rows_of(stamps):
        calls.append(stamps)
        return np.array(stamps, int).reshape(-1)

    assert read_loops(tmp_path / "loops.json", rows_of)["candidates"] == tuple(
        (k, tuple(range(k % 4))) for k in range(4, 40)
    )
    assert len(calls) == 4  # queries and matches, of loops and of candidates


def test_an_empty_list_of_loops_is_an_estimate_and_candidates_are_optional(tmp_path):
    estimate = estimated(tmp_path, range(10), loops={"loops": []})
    assert len(estimate.loops.query) == 0 and estimate.candidates is None
    assert estimated(tmp_path, range(10)).loops is not None  # the file is still there
    (tmp_path / "loops.json").unlink()
    assert estimated(tmp_path, range(10)).loops is None


@pytest.mark.parametrize(
    ("loops", "message"),
    [
        ([loop(4, 4.6)], "stamp 1000000001.150000 is none of the estimated frames; valid: frames of rooms.json, or"),
        ([loop(3, 40)], "stamp 1000000010.000000 is none of the estimated frames"),
        ([loop(3, 4)], "to 1000000001.000000 s does not lead to an earlier frame; valid: match before query"),
        ([loop(4, 3, (0.0, 0.0, 0.0, 2.0))], "qx qy qz qw is no unit quaternion; valid: norm 1"),
        (
            [loop(4, 3), loop(4, 2), loop(4, 3)],
            "loop from 1000000001.000000 to 1000000000.750000 s is a second entry for one",
        ),
        ([loop(4, 3, (1.0,))], "loops.0.T_match_query: "),
        ([loop(4, 3, weight=1.5)], "loops.0.weight: "),
    ],
)
def test_wrong_loops_are_named(loops, message, tmp_path):
    with pytest.raises(SimError) as caught:
        estimated(tmp_path, [2, 3, 4], loops={"loops": loops})
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_a_candidate_that_is_not_earlier_is_named(tmp_path):
    with pytest.raises(
        SimError, match=r"the candidates of \d+\.\d+ s are not all earlier; valid: matches before their query"
    ):
        estimated(tmp_path, [2, 3, 4], loops={"loops": [], "candidates": [{"query": at(3), "matches": [at(2), at(3)]}]})


def test_two_entries_of_candidates_for_one_frame_are_refused(tmp_path):
    candidates = [{"query": at(4), "matches": [at(2)]}, {"query": at(4.1), "matches": [at(3)]}]
    with pytest.raises(SimError, match=r"the candidates of \d+\.\d+ s are a second entry for one frame; valid: one entry"):
        estimated(tmp_path, [2, 3, 4], loops={"loops": [], "candidates": candidates})


def test_the_loops_of_a_program_are_compared_with_the_truth(tmp_path, unlit):
    (block,) = (block for block in blocks("sim/pages/your-slam.md") if block.language == "py")
    content = block.content + LOOPS
    result = evaluate(Program(program(tmp_path, content))(replace(SCENARIO, odometry="perfect")))
    assert (result.loops.verified, result.loops.true, result.loops.false) == (2, 1, 1)
    assert result.loops.proposed is None
