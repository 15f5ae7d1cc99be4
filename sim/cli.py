"""The console script `lexis-sim`.

Exit status: 0 on success, 1 on a failed check, 2 on bad input, with one line on stderr that says what would be valid.
"""

import argparse
from collections.abc import Sequence
from dataclasses import astuple, fields
from pathlib import Path

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from lexis.command_line import Commands, Parser, add_command, positive, run_command, seed
from lexis.errors import LexisError
from lexis.files import replaced_file
from sim.bench.segmentation import Row, mean_and_spread, run_houses
from sim.bench.speed import measure_speed
from sim.doctor import examine
from sim.errors import SimError
from sim.harness import RunConfig, evaluate, run, try_plans, write_run
from sim.harness.outputs import check_writable
from sim.odometry import PRESETS as ODOMETRY_PRESETS
from sim.report.figures import shown
from sim.report.house_plan import plan_png
from sim.report.table import result_table
from worlds.errors import HouseError, WorldsError
from worlds.export import to_glb
from worlds.house import House, build_house
from worlds.presets import PRESETS, sample_from_rooms, sample_house
from worlds.spec import HouseSpec
from worlds.truth import floor_area, openness
from worlds.validation import validate

DEMO = RunConfig()
_WIDE = 110
"""Columns from which there is room for the meaning of every figure."""
_ENCODERS = "mini, MODEL[:PRETRAINED] or MODEL:PATH of open_clip"


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; return the exit status."""
    return run_command(_parser(), argv, (WorldsError, SimError, LexisError))


def _parser() -> Parser:
    parser = Parser("lexis-sim", description="Test indoor semantic SLAM in generated houses, against exact truth.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    demo = add_command(
        commands, "demo", _demo, "a house, a walk, LEXIS, a report", "lexis-sim demo --seed 7 --out lexis-demo"
    )
    _add_seed_and_out(demo, Path("lexis-demo"))
    _add_run(commands)
    _add_house(commands)
    bench = add_command(commands, "bench", _bench, "benchmarks", "lexis-sim bench segmentation --preset home --houses 5")
    bench.add_argument("benchmark", choices=_BENCHMARKS)
    bench.add_argument("--preset", choices=PRESETS, default="home")
    bench.add_argument("--houses", type=positive, default=5, help="how many, from --seed upwards (default: %(default)s)")
    bench.add_argument("--encoder", default="mini", help=f"{_ENCODERS} (default: %(default)s)")
    bench.add_argument("--seed", type=seed, default=0)
    train = add_command(
        commands, "train-encoder", _train, "train the mini encoder", "lexis-sim train-encoder --houses 300 --epochs 9"
    )
    train.add_argument("--houses", type=positive, default=300, help="training and tuning houses (default: %(default)s)")
    train.add_argument("--epochs", type=positive, default=9, help="passes over the frames (default: %(default)s)")
    train.add_argument("--seed", type=seed, default=0)
    train.add_argument(
        "--work", type=Path, default=Path("encoder-training"), help="frames and checkpoint; resumed when it exists"
    )
    train.add_argument("--out", type=Path, help="weights (default: those in the package)")
    add_command(commands, "doctor", _doctor, "GL back ends, cores, encoder, versions; what to fix", "lexis-sim doctor")
    return parser


def _add_run(commands: Commands) -> None:
    run_parser = add_command(
        commands, "run", _run, "one run with a choice of everything", "lexis-sim run --preset ori --seed 3 --no-loops"
    )
    house = run_parser.add_mutually_exclusive_group()
    house.add_argument("--preset", default="home", help=f"family of houses: {', '.join(PRESETS)} (default: %(default)s)")
    house.add_argument("--house", type=Path, metavar="FILE.json", help="a house of your own")
    _add_seed_and_out(run_parser, Path("lexis-run"))
    run_parser.add_argument("--odometry", default="multicam", help=f"{', '.join(ODOMETRY_PRESETS)} (default: %(default)s)")
    run_parser.add_argument("--encoder", default="mini", help=f"{_ENCODERS} (default: %(default)s)")
    run_parser.add_argument("--fidelity", choices=["render"], default="render")
    run_parser.add_argument("--no-loops", action="store_true", help="close no loops")
    run_parser.add_argument("--no-refine", action="store_true", help="keep the labels that single images give")


def _add_house(commands: Commands) -> None:
    house = commands.add_parser("house", help="generate, check and show houses")
    actions = house.add_subparsers(required=True, metavar="ACTION")
    generate = add_command(
        actions,
        "generate",
        _generate,
        "write a house as JSON",
        "lexis-sim house generate --preset home --seed 3 -o home.json",
    )
    source = generate.add_mutually_exclusive_group()
    source.add_argument("--preset", default="home", help=f"family of houses: {', '.join(PRESETS)} (default: %(default)s)")
    source.add_argument("--rooms", metavar="A,B,...", help="one storey with these rooms around a corridor")
    generate.add_argument("--seed", type=seed, default=0)
    generate.add_argument("-o", "--out", type=Path, required=True, metavar="FILE.json")
    check = add_command(
        actions, "check", _check, "prove that a house can stand and be walked", "lexis-sim house check home.json"
    )
    check.add_argument("file", type=Path)
    show = add_command(actions, "show", _show, "draw the plan of every storey", "lexis-sim house show home.json -o home.png")
    show.add_argument("file", type=Path)
    show.add_argument("-o", "--out", type=Path, required=True, metavar="FILE.png")
    export = add_command(
        actions, "export", _export, "a 3-D model for other tools", "lexis-sim house export home.json -o home.glb"
    )
    export.add_argument("file", type=Path)
    export.add_argument("-o", "--out", type=Path, required=True, metavar="FILE.glb")


def _add_seed_and_out(parser: argparse.ArgumentParser, out: Path) -> None:
    parser.add_argument("--seed", type=seed, default=DEMO.seed, help="of house, tour and odometry (default: %(default)s)")
    parser.add_argument("--out", type=Path, default=out, metavar="DIR", help="folder for the result (default: %(default)s)")


def _demo(arguments: argparse.Namespace) -> int:
    return _run_and_report(RunConfig(seed=arguments.seed), arguments.out)


def _run(arguments: argparse.Namespace) -> int:
    house = HouseSpec.load(arguments.house) if arguments.house else None
    config = RunConfig(
        preset=arguments.preset,
        seed=arguments.seed,
        house=house,
        odometry=arguments.odometry,
        encoder=arguments.encoder,
        loops=not arguments.no_loops,
        refine=not arguments.no_refine,
    )
    return _run_and_report(config, arguments.out)


def _run_and_report(config: RunConfig, out: Path) -> int:
    check_writable(out)
    console = Console()
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("walking and mapping", total=1.0)
        finished = run(config, progress=lambda share: bar.update(task, completed=share))
    trials = try_plans(finished)
    result = evaluate(finished, trials)
    write_run(finished, result, trials, out)
    console.print(result_table(result, meanings=console.width >= _WIDE))
    print(f"report: {out / 'report.html'}")
    return 0


def _generate(arguments: argparse.Namespace) -> int:
    if arguments.rooms is None:
        spec = sample_house(arguments.preset, arguments.seed)
    else:
        spec = sample_from_rooms([label.strip() for label in arguments.rooms.split(",")], arguments.seed)
    house = _checked(spec)
    with replaced_file(arguments.out) as file:
        file.write_text(spec.to_json())
    print(f"{arguments.out}: {_describe(house)}")
    return 0


def _check(arguments: argparse.Namespace) -> int:
    spec = HouseSpec.load(arguments.file)
    try:
        house = _checked(spec)
    except HouseError as error:
        print(f"{arguments.file}: {error}")
        return 1
    print(f"{arguments.file}: {_describe(house)}; all checks passed")
    return 0


def _show(arguments: argparse.Namespace) -> int:
    house = build_house(HouseSpec.load(arguments.file))
    with replaced_file(arguments.out) as file:
        file.write_bytes(plan_png(house))
    print(f"{arguments.out}: {_describe(house)}")
    return 0


def _export(arguments: argparse.Namespace) -> int:
    house = build_house(HouseSpec.load(arguments.file))
    with replaced_file(arguments.out) as file:
        file.write_bytes(to_glb(house))
    print(f"{arguments.out}: {_describe(house)}")
    return 0


def _train(arguments: argparse.Namespace) -> int:
    from sim.training.command import MINI_WEIGHTS, TrainingRun, train_encoder
    from sim.training.train import TrainingConfig

    training = TrainingConfig(epochs=arguments.epochs, seed=arguments.seed)
    train_encoder(TrainingRun(arguments.houses, training, arguments.work, arguments.out or MINI_WEIGHTS), Console())
    return 0


def _bench(arguments: argparse.Namespace) -> int:
    Console().print(_BENCHMARKS[arguments.benchmark](arguments))
    return 0


def _bench_segmentation(arguments: argparse.Namespace) -> Table:
    table = Table("seed", *(field.name for field in fields(Row)), title=f"{arguments.preset}, encoder {arguments.encoder}")
    last = arguments.seed + arguments.houses - 1
    rows = []
    for house, row in run_houses(
        RunConfig(preset=arguments.preset, encoder=arguments.encoder), range(arguments.seed, last + 1)
    ):
        rows.append(row)
        table.add_row(str(house), *(shown(value, "{:.3g}") for value in astuple(row)), end_section=house == last)
    for name, values in zip(("mean", "std"), mean_and_spread(rows), strict=True):
        table.add_row(name, *(shown(value, "{:.3g}") for value in values))
    return table


def _bench_speed(arguments: argparse.Namespace) -> Table:
    table = Table("step", "median [ms]", "worst [ms]", "runs", title=f"{arguments.preset}, seeds from {arguments.seed}")
    for timing in measure_speed(arguments.preset, arguments.houses, arguments.seed):
        table.add_row(timing.name, f"{timing.median_ms:.1f}", f"{timing.worst_ms:.1f}", str(timing.runs))
    return table


_BENCHMARKS = {"speed": _bench_speed, "segmentation": _bench_segmentation}


def _doctor(arguments: argparse.Namespace) -> int:
    findings = examine()
    for finding in findings:
        print(f"{'ok ' if finding.fine else 'FIX'} {finding.subject}: {finding.detail}")
    return 0 if all(finding.fine for finding in findings) else 1


def _checked(spec: HouseSpec) -> House:
    house = build_house(spec)
    validate(house)
    return house


def _describe(house: House) -> str:
    floors = len(house.storeys)
    return (
        f"{len(house.rooms)} rooms on {floors} floor{'s' * (floors > 1)}, {floor_area(house):.0f} m², "
        f"openness {openness(house):.2f}, {len(house.furniture)} pieces of furniture"
    )
