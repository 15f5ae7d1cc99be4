"""`lexis-sim calibrate-queries`: fit how `lexis query` converts an encoder's similarities to probabilities."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lexis.command_line import ENCODER_HELP, Commands, add_command, positive
from sim.commands.arguments import SEED
from sim.commands.progress import tracked
from sim.errors import SimError
from sim.output_files import check_output_file

if TYPE_CHECKING:
    from lexis.encoder.open_clip_encoder import OpenClipEncoder
    from sim.training.houses import HouseDraw
    from sim.training.question_calibration import CalibrationFigures
    from sim.training.random_questions import QuestionBatch

TEST_PRESETS = ("home", "ori", "uh2-apt", "uh2-office")


def add_to(commands: Commands) -> None:
    """Add the command `calibrate-queries`."""
    calibrate = add_command(
        commands,
        "calibrate-queries",
        _calibrate,
        "fit the probabilities of lexis query to an encoder",
        "lexis-sim calibrate-queries --encoder ViT-B-32 --out vit-b-32.json\n"
        '  lexis query map "a bathtub" --calibration vit-b-32.json',
    )
    calibrate.add_argument("--encoder", default="mini", help=ENCODER_HELP)
    calibrate.add_argument("--houses", type=positive, default=24, help="houses to render and fit to (default: %(default)s)")
    calibrate.add_argument(
        "--test-houses",
        type=positive,
        default=0,
        metavar="N",
        help="measure the calibration on N test houses per preset",
    )
    SEED(calibrate)
    calibrate.add_argument(
        "-o", "--out", type=Path, metavar="FILE.json", help="file to write (default: the calibration of mini in the package)"
    )


def _calibrate(arguments: argparse.Namespace) -> int:
    from lexis.encoder.model_source import MINI
    from lexis.encoder.open_clip_encoder import load_encoder
    from lexis.questions.calibration import MINI_CALIBRATION, save_calibration
    from sim.training.houses import TEST_SEEDS, HouseDraw
    from sim.training.question_calibration import fit_calibration, measure, tuning_houses

    if arguments.out is None and arguments.encoder != MINI:
        raise SimError(f"--out is missing: only the calibration of {MINI!r} has a default file; valid: --out FILE.json")
    out: Path = arguments.out or MINI_CALIBRATION
    check_output_file(out)
    encoder = load_encoder(arguments.encoder)
    calibration = fit_calibration(encoder, _asked(tuning_houses(arguments.houses, arguments.seed), encoder, arguments.seed))
    save_calibration(calibration, out)
    print(f"{out}: threshold {calibration.base:.3f} + {calibration.slope:.3f} familiarity, {calibration.temperature:.4f}")
    if arguments.test_houses:
        houses = {
            preset: [HouseDraw(preset, TEST_SEEDS[i]) for i in range(arguments.test_houses)] for preset in TEST_PRESETS
        }
        asked = {preset: _asked(draws, encoder, arguments.seed) for preset, draws in houses.items()}
        for name, questions in (*asked.items(), ("all", [one for some in asked.values() for one in some])):
            print(f"{name:11s}{_said(measure(calibration, encoder, questions))}")
    return 0


def _said(figures: "CalibrationFigures") -> str:
    return (
        f"{figures.questions} questions: calibration error {figures.calibration_error:.3f}, of best rooms "
        f"{figures.best_calibration_error:.3f}; best room right {figures.right:.2f}; AUC of unknown "
        f"{figures.unknown_auc:.3f}; share answered {figures.found:.2f} of questions with an answer, "
        f"share unknown {figures.unknown:.2f} of questions without one"
    )


def _asked(houses: "Sequence[HouseDraw]", encoder: "OpenClipEncoder", seed: int) -> "list[QuestionBatch]":
    from sim.training.question_calibration import asked_in

    return asked_in(tracked(houses, len(houses), "asking"), encoder, seed)
