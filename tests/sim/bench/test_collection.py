"""`lexis-sim bench all`: every benchmark of the list exists, and a collection that was interrupted is continued."""

import subprocess
from pathlib import Path

import pytest

from sim.bench import collection
from sim.bench.benchmark_list import FULL, QUICK, Benchmark, benchmarks
from sim.bench.collection import collect, source
from sim.cli import main, parser
from sim.commands.benchmarks import bench_graphs, bench_harness, bench_peers, bench_runs

GRAPH = """VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1
VERTEX_SE3:QUAT 1 1 0 0 0 0 0 1
EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1
"""


@pytest.fixture
def graph(tmp_path):
    path = tmp_path / "two.g2o"
    path.write_text(GRAPH)
    return path


def pose_graph(graph):
    return Benchmark("pose-graph", ("pose-graph", str(graph)), 1, is_timing=True)


@pytest.mark.parametrize("extent", [QUICK, FULL])
def test_the_arguments_of_all_benchmarks_are_valid(extent, tmp_path, graph):
    listed = benchmarks(extent, tmp_path / "a folder", [graph])
    for each in listed:
        parsed = parser().parse_args(["bench", *each.arguments])
        assert getattr(parsed, "houses", extent.houses) in (extent.houses, 8)
        assert getattr(parsed, "seed", 0) < 1_000_000
    assert len({each.name for each in listed}) == len(listed)
    groups = bench_runs, bench_peers, bench_graphs, bench_harness
    names = {action.name for group in groups for action in group.BENCHMARKS}
    assert names | {"encoders"} == {each.arguments[0] for each in listed} | {"mutation", "shrinking", "settings"}
    assert [each.is_timing for each in listed] == sorted(each.is_timing for each in listed)


def test_pose_graphs_are_optimised_only_if_there_are_files(tmp_path, graph):
    names = [{each.name for each in benchmarks(QUICK, tmp_path, files)} for files in ([], [graph])]
    assert names[1] - names[0] == {"pose-graph"} and names[0] < names[1]


def test_a_finished_benchmark_is_kept_and_one_from_elsewhere_is_run_again(tmp_path, graph):
    (first,) = collect([pose_graph(graph)], tmp_path, workers=2)
    file = tmp_path / "pose-graph.txt"
    text = file.read_text()
    assert first.seconds > 0 and first.processor_s > 0 and first.error == ""
    assert text.startswith(f"lexis-sim bench pose-graph {graph}\n{source()}\ntook ") and "two" in text[text.index("\n\n") :]
    (again,) = collect([pose_graph(graph)], tmp_path, workers=2)
    assert again.seconds is None and again.processor_s == 0 and file.read_text() == text
    file.write_text(text.replace("commit ", "commit of another day "))
    (other,) = collect([pose_graph(graph)], tmp_path, workers=2)
    assert other.seconds is not None and file.read_text().startswith(text[: text.index("took ")])


def test_a_file_of_somebody_else_is_no_finished_benchmark(tmp_path, graph):
    (tmp_path / "pose-graph.txt").write_bytes(b"\xff\xfe")  # not even text
    (first,) = collect([pose_graph(graph)], tmp_path, workers=1)
    assert first.seconds is not None and first.error == ""


def test_changes_of_any_name_and_encoding_are_part_of_the_source(tmp_path, monkeypatch):
    def git(*arguments):
        subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", *arguments], cwd=tmp_path, check=True)

    code = tmp_path / "collection.py"
    code.write_bytes(b"x = 1\n")
    git("init", "-q"), git("add", "."), git("commit", "-q", "-m", "first")
    monkeypatch.setattr(collection, "_HERE", tmp_path)
    monkeypatch.setattr(collection, "__file__", str(code))
    found = [source()]
    for changed, content in ((tmp_path / "möbel.py", b"y"), (tmp_path / "möbel.py", b"z"), (code, b"# caf\xe9\n")):
        changed.write_bytes(content)
        found.append(source())
    assert len(set(found)) == 4 and "changes" not in found[0] and all("with changes" in each for each in found[1:])


def test_a_failed_benchmark_says_why_and_the_others_go_on(tmp_path, graph, capsys, monkeypatch):
    wrong = Benchmark("scale", ("scale", "--rooms", "none"), 1)
    monkeypatch.setattr("sim.bench.benchmark_list.benchmarks", lambda *_: (wrong, pose_graph(graph)))
    assert main(["bench", "all", "-o", str(tmp_path)]) == 1
    said = capsys.readouterr().out
    assert "scale: FAILED" in said and "none" in said and f"1 of 2 benchmarks are in {tmp_path}" in said
    assert not (tmp_path / "scale.txt").exists() and Path(tmp_path, "pose-graph.txt").exists()


def test_a_benchmark_may_print_bytes_that_are_no_text(tmp_path, graph, monkeypatch):
    program = tmp_path / "python"
    program.write_text("#!/bin/sh\nprintf 'caf\\351'\n")
    program.chmod(0o755)
    monkeypatch.setattr("sys.executable", str(program))
    (ended,) = collect([pose_graph(graph)], tmp_path, workers=1)
    assert ended.error == "" and (tmp_path / "pose-graph.txt").read_text().endswith("\n\ncaf\\xe9")


def test_a_name_that_no_benchmark_has_is_bad_input(tmp_path, capsys):
    assert main(["bench", "all", "-o", str(tmp_path), "--only", "table9"]) == 2
    assert "table9: no benchmark; valid: part of " in capsys.readouterr().err
