"""`lexis-sim train-encoder`: train the weights of the encoder `mini` again."""

import argparse
from pathlib import Path

from lexis.command_line import Commands, add_command, positive
from sim.commands.arguments import SEED, folder
from sim.commands.console import standard_output
from sim.output_files import check_output_file, make_output_folder


def add_to(commands: Commands) -> None:
    """Add the command `train-encoder`."""
    train = add_command(
        commands, "train-encoder", _train, "train the mini encoder", "lexis-sim train-encoder --work encoder-training"
    )
    train.add_argument("--houses", type=positive, default=520, help="houses to train on (default: %(default)s)")
    train.add_argument(
        "--settling-houses", type=positive, help="houses for the last step, at least --houses (default: twice as many)"
    )
    train.add_argument("--epochs", type=positive, default=10, help="epochs of dense supervision (default: %(default)s)")
    train.add_argument(
        "--align-epochs", type=positive, default=4, help="epochs of alignment with text (default: %(default)s)"
    )
    train.add_argument("--batch", type=positive, default=128, help="images in a batch (default: %(default)s)")
    SEED(train)
    train.add_argument(
        "--work",
        type=folder,
        default=Path("encoder-training"),
        help="folder for frames and checkpoints; training resumes from it",
    )
    train.add_argument(
        "--workers",
        type=positive,
        default=2,
        help="number of rendering processes and of training threads (default: %(default)s)",
    )
    train.add_argument("--start", type=Path, metavar="FILE", help="weights of lexis-mini whose image tower to start from")
    train.add_argument(
        "--teacher", type=folder, help="folder with MiniLM's weights (default: those of the extra 'training')"
    )
    train.add_argument("--out", type=Path, help="file for the weights, .safetensors (default: those in the package)")


def _train(arguments: argparse.Namespace) -> int:
    from sim.training.command import MINI_WEIGHTS, TrainingRun, train_encoder

    out: Path = arguments.out or MINI_WEIGHTS
    make_output_folder(arguments.work)
    make_output_folder(out.parent)
    check_output_file(out)
    run = TrainingRun(
        houses=arguments.houses,
        settling_houses=arguments.settling_houses,
        epochs=(arguments.epochs, arguments.align_epochs),
        batch=arguments.batch,
        seed=arguments.seed,
        work=arguments.work,
        out=out,
        workers=arguments.workers,
        start=arguments.start,
        teacher=arguments.teacher,
    )
    train_encoder(run, standard_output())
    return 0
