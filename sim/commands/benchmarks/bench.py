"""`lexis-sim bench`: the list of benchmarks. To add one, write a function and an entry in a module beside this one."""

from lexis.command_line import Commands
from sim.commands.action import Action, add_actions
from sim.commands.benchmarks import bench_all, bench_encoders, bench_graphs, bench_harness, bench_peers, bench_runs
from sim.commands.benchmarks.bench_options import printing

_ALL = Action(
    "all",
    bench_all.run_all,
    "all benchmarks but settings, mutation and shrinking; a collection that was interrupted is continued",
    "lexis-sim bench all --quick -o tables",
    bench_all.ARGUMENTS,
)
_ENCODERS = Action(
    "encoders",
    printing(bench_encoders.tables),
    "accuracy, questions, retrieval and times of encoders, as in the paper's Table I",
    "lexis-sim bench encoders --presets home ori --encoders mini --houses 5",
    bench_encoders.ARGUMENTS,
)


def add_to(commands: Commands) -> None:
    """Add the command `bench` with its benchmarks."""
    groups = bench_runs.BENCHMARKS, bench_peers.BENCHMARKS, bench_graphs.BENCHMARKS, bench_harness.BENCHMARKS
    listed = (_ALL, _ENCODERS, *(action for group in groups for action in group))
    add_actions(commands, "bench", "benchmarks", listed, metavar="BENCHMARK")
