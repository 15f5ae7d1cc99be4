"""Command-line arguments that several commands of `lexis-sim` share."""

import argparse
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from lexis.command_line import ENCODER_HELP, seed
from sim.errors import SimError
from sim.faults.catalogue import parse_fault, usage
from sim.fidelity import FIDELITIES, ORACLE, Fidelity
from sim.odometry.config import ODOMETRY_PRESETS
from sim.tours.config import FASTEST_HZ, LONGEST_M, TOUR_KINDS
from sim.tours.sway import SWAYS
from worlds.errors import WorldsError, reworded
from worlds.presets import PRESETS
from worlds.spec import HouseSpec
from worlds.validation import built_and_checked

if TYPE_CHECKING:
    from sim.harness import Scenario

PINHOLE_RIGS = ("wide", "stereo", "front-rear", "four")
"""The presets of rigs whose cameras are all pinholes."""
IMAGE_FORMATS = ("png", "jpg", "raw")
"""The formats of images in recordings."""
Argument: TypeAlias = Callable[[argparse.ArgumentParser], object]
"""A function that adds one argument to a parser."""

_FEATURES_HELP = "features: no pixels, but what a model of the encoder makes of the true view"
FIDELITY_HELP = f"{_FEATURES_HELP} (default: %(default)s)"
ORACLE_HELP = "oracle: told the truth, for tests of what comes after the encoder; with --fidelity features"
FEATURE_MODEL_HELP = "model for --fidelity features, as 'lexis-sim fit-features' writes it (default: that of mini)"
TOUR_HELP = "path of the walk; both-ways: through every room and back along the same path (default: %(default)s)"
LENGTH_HELP = (
    "length of the walk in metres (default: 140 for the preset home, otherwise once through every room, and then again "
    "through the lowest storey)"
)
SWAY_HELP = "how the body swings as it walks (default: %(default)s)"
START_HELP = "swing on the spot for five seconds before the walk, which lets visual-inertial systems initialise"
TOURS = {kind.replace(" ", "-"): kind for kind in TOUR_KINDS}
RIG_HELP = (
    "wide, stereo, front-rear, four or fisheye; LEXIS sees all their pinholes; only RigRenderer in Python draws the fisheye "
    "(default: %(default)s)"
)
SCENARIO_HELP = "a run as a file, such as scenario.json in the folder of a run, in place of all options that describe one"
_DESCRIBES_A_RUN = (
    "preset", "house", "seed", "tour", "length", "reverse", "sway", "rate", "start_manoeuvre", "odometry", "overconfidence",
    "fault", "encoder", "fidelity", "feature_model", "rig",
)  # fmt: skip
CONFIG_HELP = "settings of LEXIS as JSON; 'lexis config' prints the defaults"
PRESET_HELP = f"family of houses: {', '.join(PRESETS)} (default: %(default)s)"


def argument(*names: str, **options: Any) -> Argument:
    """Return an `Argument` from the parameters of `ArgumentParser.add_argument`, for tables of commands."""
    return lambda parser: parser.add_argument(*names, **options)


class EachOnce(argparse.Action):
    """Stores a list of names or numbers, and refuses one that is given twice: it would count twice in every mean."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option_string: str | None = None
    ) -> None:
        """Store the list. Raises `ArgumentError` if a name or number is given twice."""
        if twice := [value for k, value in enumerate(values) if value in values[:k]]:
            shown, noun = (f"{twice[0]:g}", "number") if isinstance(twice[0], float) else (f"{twice[0]!r:.60}", "name")
            raise argparse.ArgumentError(self, f"{shown} is given twice; valid: each {noun} once")
        setattr(namespace, self.dest, values)


def number(low: float, high: float, lowest: str = "") -> Callable[[str], float]:
    """Make a converter for `type=` that accepts numbers from `low` to `high`.

    Error messages show the text `lowest` after the number `low`, to say what `low` means.
    """

    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{text!r}; valid: a number from {low:g}{lowest} to {high:g}")
        return value

    return parse


def whole_number(low: int, high: int) -> Callable[[str], int]:
    """Make a converter for `type=` that accepts whole numbers from `low` to `high`."""

    def parse(text: str) -> int:
        if not (text.isascii() and text.isdecimal()) or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(f"{text!r:.60}; valid: a whole number from {low} to {high}")
        return int(text)

    return parse


def folder(text: str) -> Path:
    """Convert text to the path of an output folder, for `type=`. Files are refused; write permission is not checked."""
    if not text.strip():
        raise argparse.ArgumentTypeError("is blank; valid: the name of a folder")
    try:
        path = Path(text).resolve()
        nearest = next(found for found in (path, *path.parents) if found.exists())
        is_folder = nearest.is_dir()
    except OSError as error:
        raise argparse.ArgumentTypeError(f"{text}: {error.strerror}; valid: the name of a folder") from None
    except RuntimeError as error:  # a loop of symbolic links
        raise argparse.ArgumentTypeError(f"{text}: {error}; valid: the name of a folder") from None
    if not is_folder:
        raise argparse.ArgumentTypeError(f"{nearest}: is a file; valid: the name of a folder")
    return Path(text)


def numbers(names: str, counts: tuple[int, ...]) -> Callable[[str], tuple[float, ...]]:
    """Make a converter for `type=` that reads finite numbers separated by commas.

    `counts` lists how many numbers may be given, and `names` describes them in error messages.
    """

    def parse(text: str) -> tuple[float, ...]:
        try:
            values = tuple(map(float, text.split(",")))
        except ValueError:
            values = ()
        if len(values) not in counts or not all(map(math.isfinite, values)):
            raise argparse.ArgumentTypeError(f"{text!r}; valid: numbers {names}")
        return values

    return parse


def seeing_encoder(text: str) -> str:
    """Accept any name of an encoder except the oracle, which sees no images. This is a converter for `type=`.

    The encoder need not exist.
    """
    if text == ORACLE:
        raise argparse.ArgumentTypeError(f"{text!r} is told the truth, so benchmarks refuse it; valid: mini, or open_clip's")
    return text


def out_file(metavar: str) -> Argument:
    """Return the required argument `--out` of a command that writes one file."""
    return argument(
        "-o", "--out", type=Path, required=True, metavar=metavar, help="file to write; an earlier one is replaced"
    )


SEED = argument("--seed", type=seed, default=0, help="default: %(default)s")

DEMO_SEED = 7


def add_run_seed(parser: argparse.ArgumentParser) -> None:
    """Add the option `--seed` of a run."""
    parser.add_argument(
        "--seed", type=seed, default=DEMO_SEED, help="seed of house, tour and odometry (default: %(default)s)"
    )


def add_walk(parser: argparse.ArgumentParser, scenario: bool = False) -> None:
    """Add options for house, walk, odometry and faults; with `scenario` also `--scenario`, a file that replaces them."""
    house = parser.add_mutually_exclusive_group()
    if scenario:
        parser.register("action", None, _NotedStore)
        house.add_argument("--scenario", type=Path, metavar="FILE", help=SCENARIO_HELP)
    house.add_argument("--preset", default="home", help=PRESET_HELP)
    house.add_argument("--house", type=Path, metavar="FILE.json", help="a house of your own")
    add_run_seed(parser)
    add_tour(parser)
    parser.add_argument("--odometry", default="multicam", help=f"{', '.join(ODOMETRY_PRESETS)} (default: %(default)s)")
    parser.add_argument(
        "--overconfidence",
        type=number(1.0, 1e6, " (honest)"),
        default=1.0,
        metavar="FACTOR",
        help="how much too small the odometry's covariances are (default: 1, honest)",
    )
    parser.add_argument(
        "--fault", action="append", default=[], metavar="NAME[:VALUE,FIELD=VALUE...]", help="what breaks; may be repeated"
    )
    parser.epilog = f"{parser.epilog}\n\nfaults, with their fields and defaults:\n{usage()}"


def add_scenario(parser: argparse.ArgumentParser) -> None:
    """Add all options that describe a run, and `--scenario` for a file that replaces them."""
    add_walk(parser, scenario=True)
    parser.add_argument("--encoder", default="mini", help=f"{ENCODER_HELP}; {ORACLE_HELP}")
    # argparse gets no default, so that "--fidelity render" beside --suite is noticed and refused.
    parser.add_argument("--fidelity", choices=FIDELITIES, help=f"{_FEATURES_HELP} (default: render)")
    parser.add_argument("--feature-model", type=Path, metavar="FILE", help=FEATURE_MODEL_HELP)
    parser.add_argument("--rig", default="wide", metavar="NAME", help=RIG_HELP)
    parser.set_defaults(defaults_of_a_run={name: parser.get_default(name) for name in _DESCRIBES_A_RUN})


class _NotedStore(argparse.Action):
    """Stores the value of an option, and notes that the option was given, even if the value is that of the default."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option_string: str | None = None
    ) -> None:
        setattr(namespace, self.dest, values)
        namespace.noted = {*getattr(namespace, "noted", ()), self.dest}


def given_options_of_a_run(arguments: argparse.Namespace) -> list[str]:
    """Return the names of the options of `add_scenario` that the user gave, except `--scenario`."""
    noted, defaults = getattr(arguments, "noted", ()), arguments.defaults_of_a_run
    return [name for name, value in defaults.items() if name in noted or getattr(arguments, name) != value]


def scenario_of_arguments(arguments: argparse.Namespace) -> "Scenario":
    """Build the scenario from the options of `add_scenario`. Raises `WorldsError`, `SimError` or `LexisError` if invalid."""
    from sim.harness import Scenario
    from sim.render.rig import RigConfig

    if arguments.scenario is not None:
        if given := given_options_of_a_run(arguments):
            option = f"--{given[0].replace('_', '-')}"
            raise SimError(f"{option} is given beside --scenario; valid: one of the two, since the file says all of a run")
        scenario = Scenario.load(arguments.scenario)
        if scenario.house is not None:
            with naming(arguments.scenario):
                built_and_checked(scenario.house)
        return scenario
    fidelity: Fidelity = arguments.fidelity or "render"
    if arguments.feature_model is not None and fidelity != "features":
        raise SimError(f"--feature-model {arguments.feature_model} has no effect on images; valid: with --fidelity features")
    return Scenario(
        encoder=arguments.encoder,
        fidelity=fidelity,
        feature_model=arguments.feature_model,
        rig=RigConfig(arguments.rig),
        **walk_options(arguments),
    )


def add_tour(parser: argparse.ArgumentParser) -> None:
    """Add options for the path of the walk, the motion of the body and the frame rate."""
    parser.add_argument("--tour", choices=TOURS, default="rooms", help=TOUR_HELP)
    parser.add_argument("--length", type=number(1.0, LONGEST_M), metavar="M", help=LENGTH_HELP)
    parser.add_argument("--reverse", action="store_true", help="walk the tour in the opposite direction")
    parser.add_argument("--sway", choices=SWAYS, default="none", help=SWAY_HELP)
    parser.add_argument(
        "--rate", type=number(2.0, FASTEST_HZ), default=10.0, metavar="HZ", help="frames per second (default: %(default)g)"
    )
    parser.add_argument("--start-manoeuvre", action="store_true", help=START_HELP)


def checked_house(file: Path) -> HouseSpec:
    """Read a house. Raises `WorldsError`, which names the file, if it cannot be built, or if it breaks a rule of houses."""
    spec = HouseSpec.load(file)
    with naming(file):
        built_and_checked(spec)
    return spec


@contextmanager
def naming(file: Path) -> Iterator[None]:
    """Let the message of a `WorldsError` in the block begin with the name of the file that holds the house."""
    try:
        yield
    except WorldsError as error:
        raise reworded(error, f"{file}: {error}") from None


def walk_options(arguments: argparse.Namespace) -> dict[str, Any]:
    """Convert the options of `add_walk` to fields of `Scenario`. Raises `WorldsError` or `SimError` if they are invalid."""
    return {
        "preset": arguments.preset,
        "seed": arguments.seed,
        "house": checked_house(arguments.house) if arguments.house else None,
        "tour_kind": TOURS[arguments.tour],
        "length_m": arguments.length,
        "reverse": arguments.reverse,
        "sway": arguments.sway,
        "frame_rate_hz": arguments.rate,
        "start_manoeuvre": arguments.start_manoeuvre,
        "odometry": arguments.odometry,
        "overconfidence": arguments.overconfidence,
        "faults": tuple(map(parse_fault, arguments.fault)),
    }
