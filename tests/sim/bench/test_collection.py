"""`lexis-sim bench all`: every benchmark of the list exists, and a collection that was interrupted is continued."""

import shutil
import subprocess
from pathlib import Path

import pytest

from sim.bench import collection
from sim.bench.benchmark_list import FULL, QUICK, Benchmark, benchmarks
from sim.bench.collection import collect, source, why_again
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
    return Benchmark("pose-graph", ("pose-graph", str(graph)), 1, is_timing=True, inputs=(graph,))


@pytest.fixture
def program(tmp_path, monkeypatch):
    """In place of Python, a program that writes its last argument as a file, and prints two lines."""
    path = tmp_path / "python"
    path.write_text('#!/bin/sh\nfor last; do :; done\necho 1,2 > "$last"\nprintf "one\\n\\ntwo\\n"\n')
    path.chmod(0o755)
    monkeypatch.setattr("sys.executable", str(path))


KERNELS = Benchmark("kernels", ("kernels", "--csv", "kernels.csv"), 1, files=("kernels.csv",))


def collected(benchmark, out):
    """Collect one benchmark; return why its earlier file was not kept (None: it was kept, "": there was none)."""
    why = why_again(benchmark, out)
    (ended,) = collect([benchmark], out, workers=1)
    assert ended.error == "" and (ended.seconds is None) == (why is None) and why_again(benchmark, out) is None
    return why


@pytest.mark.parametrize("extent", [QUICK, FULL])
def test_the_arguments_of_all_benchmarks_are_valid(extent, tmp_path, graph):
    listed = benchmarks(extent, [graph])
    for each in listed:
        parsed = parser().parse_args(["bench", *each.arguments_in(tmp_path / "a folder")])
        written = [parsed.csv] if getattr(parsed, "csv", None) else getattr(parsed, "out", [])
        written = [*written, *([parsed.plot] if getattr(parsed, "plot", None) else [])]
        assert written == [tmp_path / "a folder" / name for name in each.files]
        assert getattr(parsed, "houses", extent.houses) in (extent.houses, 8)
        assert getattr(parsed, "seed", 0) < 1_000_000
    assert len({each.name for each in listed}) == len(listed)
    groups = bench_runs, bench_peers, bench_graphs, bench_harness
    names = {action.name for group in groups for action in group.BENCHMARKS}
    assert names | {"encoders"} == {each.arguments[0] for each in listed} | {"mutation", "shrinking", "settings"}
    assert [each.is_timing for each in listed] == sorted(each.is_timing for each in listed)


def test_pose_graphs_are_optimised_only_if_there_are_files(graph):
    names = [{each.name for each in benchmarks(QUICK, files)} for files in ([], [graph])]
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


@pytest.mark.parametrize("content", [None, b"1,3\n"])
def test_a_benchmark_whose_files_are_gone_or_changed_is_run_again(content, tmp_path, program):
    assert collected(KERNELS, tmp_path) == "" and collected(KERNELS, tmp_path) is None
    file = tmp_path / "kernels.csv"
    file.unlink() if content is None else file.write_bytes(content)
    assert collected(KERNELS, tmp_path) == "kernels.csv is missing or has changed" and file.read_text() == "1,2\n"


@pytest.mark.parametrize("kept", [0.3, 0.99])
def test_a_benchmark_whose_text_was_cut_is_run_again(kept, tmp_path, program):
    collected(KERNELS, tmp_path)
    file = tmp_path / "kernels.txt"
    whole = file.read_text()
    file.write_text(whole[: int(kept * len(whole))])
    assert collected(KERNELS, tmp_path) and file.read_text().endswith("one\n\ntwo\n")


def test_a_benchmark_is_run_again_if_its_input_has_changed(tmp_path, graph):
    collected(pose_graph(graph), tmp_path)
    graph.write_text(GRAPH.replace("1 1 0 0", "1 2 0 0", 1))
    assert collected(pose_graph(graph), tmp_path) == f"{graph} is missing or has changed"


def test_a_collection_is_continued_whatever_its_folder_is_called(tmp_path, program, monkeypatch):
    (tmp_path / "tables").mkdir()
    collected(KERNELS, tmp_path / "tables")
    monkeypatch.chdir(tmp_path)
    assert why_again(KERNELS, Path("tables")) is None
    shutil.copytree("tables", "a copy")
    assert why_again(KERNELS, Path("a copy")) is None


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("lexis-sim bench", "lexis-sim bench --quick", "is of another command"),
        ("commit ", "commit 0123456789abcdef with changes 42 ", "is of commit 01234567 with changes 42 "),
        ('{"cores": ', '{"cores": 9', "is of another machine, or of other versions"),
    ],
)
def test_before_an_earlier_result_is_replaced_it_is_said_why(old, new, says, tmp_path, program, monkeypatch, capsys):
    monkeypatch.setattr("sim.bench.benchmark_list.benchmarks", lambda *_: (KERNELS,))
    assert main(["bench", "all", "-o", str(tmp_path)]) == 0
    assert "again" not in capsys.readouterr().out
    file = tmp_path / "kernels.txt"
    file.write_text(file.read_text().replace(old, new, 1))
    assert main(["bench", "all", "-o", str(tmp_path)]) == 0
    first, *others = capsys.readouterr().out.splitlines()
    assert first.startswith(f"kernels: run again, because the earlier file {says}") and len(others) == 2
    assert main(["bench", "all", "-o", str(tmp_path)]) == 0
    assert capsys.readouterr().out.startswith("kernels: kept\n")


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


def test_pose_graph_without_files_names_the_option_that_it_needs(tmp_path, capsys):
    assert main(["bench", "all", "-o", str(tmp_path / "tables"), "--only", "pose-graph"]) == 2
    assert "--only pose-graph: pose-graph needs --pose-graphs FILE...; valid: " in capsys.readouterr().err


def test_a_name_that_no_benchmark_has_is_bad_input(tmp_path, capsys):
    assert main(["bench", "all", "-o", str(tmp_path), "--only", "table9"]) == 2
    assert "table9: no benchmark; valid: part of " in capsys.readouterr().err
