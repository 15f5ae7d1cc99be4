"""The console script `lexis-sim`.

Exit status: 0 on success, 1 on a failed check, 2 on bad input, with one line on stderr that says what would be valid.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NoReturn, TypeAlias

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from lexis.errors import LexisError
from lexis.files import replaced_file
from sim.bench.speed import measure_speed
from sim.doctor import examine
from sim.errors import SimError
from sim.harness import RunConfig, evaluate, run, try_plans, write_run
from sim.harness.outputs import check_writable
from sim.odometry import PRESETS as ODOMETRY_PRESETS
from sim.report.house_plan import plan_png
from sim.report.table import result_table
from worlds.errors import HouseError, WorldsError
from worlds.house import House, build_house
from worlds.presets import PRESETS, sample_from_rooms, sample_house
from worlds.spec import HouseSpec
from worlds.truth import floor_area, openness
from worlds.validation import validate

_Commands: TypeAlias = "argparse._SubParsersAction[_Parser]"
DEMO = RunConfig()
_ENCODERS = "mini, MODEL[:PRETRAINED] or MODEL:PATH of open_clip"


class _Parser(argparse.ArgumentParser):
    """Reports bad arguments in one line."""

    def error(self, message: str) -> NoReturn:
        """End with status 2."""
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; return the exit status."""
    arguments = _parser().parse_args(argv)
    command: Callable[[argparse.Namespace, Console], int] = arguments.command
    try:
        return command(arguments, Console())
    except (WorldsError, SimError, LexisError) as error:
        print(f"lexis-sim: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = _Parser("lexis-sim", description="Test indoor semantic SLAM in generated houses, against exact truth.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    demo = _add(commands, "demo", _demo, "a house, a walk, LEXIS, a report", "lexis-sim demo --seed 7 --out lexis-demo")
    _add_seed_and_out(demo, Path("lexis-demo"))
    _add_run(commands)
    _add_house(commands)
    bench = _add(commands, "bench", _bench, "benchmarks", "lexis-sim bench speed --preset home --houses 20")
    bench.add_argument("benchmark", choices=["speed"])
    bench.add_argument("--preset", choices=PRESETS, default="home")
    bench.add_argument("--houses", type=_positive, default=20)
    bench.add_argument("--seed", type=_seed, default=0)
    train = _add(
        commands, "train-encoder", _train, "train the mini encoder", "lexis-sim train-encoder --houses 260 --epochs 12"
    )
    train.add_argument("--houses", type=_positive, default=260, help="training and tuning houses (default: %(default)s)")
    train.add_argument("--epochs", type=_positive, default=12, help="passes over the frames (default: %(default)s)")
    train.add_argument("--seed", type=_seed, default=0)
    train.add_argument(
        "--work", type=Path, default=Path("encoder-training"), help="frames and checkpoint; resumed when it exists"
    )
    train.add_argument("--out", type=Path, help="weights (default: those in the package)")
    _add(commands, "doctor", _doctor, "GL back ends, cores, encoder, versions; what to fix", "lexis-sim doctor")
    return parser


def _add_run(commands: _Commands) -> None:
    run_parser = _add(
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


def _add_house(commands: _Commands) -> None:
    house = commands.add_parser("house", help="generate, check and show houses")
    actions = house.add_subparsers(required=True, metavar="ACTION")
    generate = _add(
        actions,
        "generate",
        _generate,
        "write a house as JSON",
        "lexis-sim house generate --preset home --seed 3 -o home.json",
    )
    source = generate.add_mutually_exclusive_group()
    source.add_argument("--preset", default="home", help=f"family of houses: {', '.join(PRESETS)} (default: %(default)s)")
    source.add_argument("--rooms", metavar="A,B,...", help="one storey with these rooms around a corridor")
    generate.add_argument("--seed", type=_seed, default=0)
    generate.add_argument("-o", "--out", type=Path, required=True, metavar="FILE.json")
    check = _add(actions, "check", _check, "prove that a house can stand and be walked", "lexis-sim house check home.json")
    check.add_argument("file", type=Path)
    show = _add(actions, "show", _show, "draw the plan of every storey", "lexis-sim house show home.json -o home.png")
    show.add_argument("file", type=Path)
    show.add_argument("-o", "--out", type=Path, required=True, metavar="FILE.png")


def _add(
    commands: _Commands, name: str, command: Callable[[argparse.Namespace, Console], int], what: str, example: str
) -> argparse.ArgumentParser:
    parser = commands.add_parser(name, help=what, description=what, epilog=f"example: {example}")
    parser.set_defaults(command=command)
    return parser


def _add_seed_and_out(parser: argparse.ArgumentParser, out: Path) -> None:
    parser.add_argument("--seed", type=_seed, default=DEMO.seed, help="of house, tour and odometry (default: %(default)s)")
    parser.add_argument("--out", type=Path, default=out, metavar="DIR", help="folder for the result (default: %(default)s)")


def _seed(text: str) -> int:
    if not text.isdecimal() or int(text) >= 2**63:
        raise argparse.ArgumentTypeError(f"{text!r}; valid: a whole number from 0 to 2**63 - 1")
    return int(text)


def _positive(text: str) -> int:
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"{text!r}; valid: a whole number from 1")
    return int(text)


def _demo(arguments: argparse.Namespace, console: Console) -> int:
    return _run_and_report(RunConfig(seed=arguments.seed), arguments.out, console)


def _run(arguments: argparse.Namespace, console: Console) -> int:
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
    return _run_and_report(config, arguments.out, console)


def _run_and_report(config: RunConfig, out: Path, console: Console) -> int:
    check_writable(out)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("walking and mapping", total=1.0)
        finished = run(config, progress=lambda share: bar.update(task, completed=share))
    trials = try_plans(finished)
    result = evaluate(finished, trials)
    write_run(finished, result, trials, out)
    console.print(result_table(result))
    console.print(f"report: {out / 'report.html'}", soft_wrap=True)
    return 0


def _generate(arguments: argparse.Namespace, console: Console) -> int:
    if arguments.rooms is None:
        spec = sample_house(arguments.preset, arguments.seed)
    else:
        spec = sample_from_rooms([label.strip() for label in arguments.rooms.split(",")], arguments.seed)
    house = _checked(spec)
    with replaced_file(arguments.out) as file:
        file.write_text(spec.to_json())
    console.print(f"{arguments.out}: {_describe(house)}")
    return 0


def _check(arguments: argparse.Namespace, console: Console) -> int:
    house = build_house(HouseSpec.load(arguments.file))
    try:
        validate(house)
    except HouseError as error:
        console.print(f"{arguments.file}: {error}", style="red", soft_wrap=True)
        return 1
    console.print(f"{arguments.file}: {_describe(house)}; all checks passed")
    return 0


def _show(arguments: argparse.Namespace, console: Console) -> int:
    house = build_house(HouseSpec.load(arguments.file))
    with replaced_file(arguments.out) as file:
        file.write_bytes(plan_png(house))
    console.print(f"{arguments.out}: {_describe(house)}")
    return 0


def _train(arguments: argparse.Namespace, console: Console) -> int:
    from sim.training.command import MINI_WEIGHTS, TrainingRun, train_encoder
    from sim.training.train import TrainingConfig

    training = TrainingConfig(epochs=arguments.epochs, seed=arguments.seed)
    train_encoder(TrainingRun(arguments.houses, training, arguments.work, arguments.out or MINI_WEIGHTS), console)
    return 0


def _bench(arguments: argparse.Namespace, console: Console) -> int:
    table = Table("step", "median [ms]", "worst [ms]", "runs", title=f"{arguments.preset}, seeds from {arguments.seed}")
    for timing in measure_speed(arguments.preset, arguments.houses, arguments.seed):
        table.add_row(timing.name, f"{timing.median_ms:.1f}", f"{timing.worst_ms:.1f}", str(timing.runs))
    console.print(table)
    return 0


def _doctor(arguments: argparse.Namespace, console: Console) -> int:
    findings = examine()
    for finding in findings:
        console.print(f"{'ok ' if finding.fine else 'FIX'} {finding.subject}: {finding.detail}", soft_wrap=True)
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
