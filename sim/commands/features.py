"""`lexis-sim fit-features`: fit the model from which runs with `--fidelity features` draw an encoder's embeddings."""

import argparse
from pathlib import Path

from lexis.command_line import ENCODER_HELP, Commands, add_command, positive
from sim.commands.progress import progress_bar
from sim.errors import SimError
from sim.output_files import check_output_file


def add_to(commands: Commands) -> None:
    """Add the command `fit-features`."""
    fit = add_command(
        commands,
        "fit-features",
        _fit,
        "fit the feature sensor to an encoder",
        "lexis-sim fit-features --encoder mini --out mini.npz\n  lexis-sim run --fidelity features --feature-model mini.npz",
    )
    fit.add_argument("--encoder", default="mini", help=ENCODER_HELP)
    fit.add_argument("--houses", type=positive, default=72, help="houses to render and fit to (default: %(default)s)")
    fit.add_argument(
        "-o", "--out", type=Path, metavar="FILE.npz", help="file to write (default: the model of mini in the package)"
    )


def _fit(arguments: argparse.Namespace) -> int:
    from lexis.encoder.model_source import MINI
    from lexis.encoder.open_clip_encoder import load_encoder
    from sim.feature_fitting.fit import fit_features
    from sim.feature_sensor.model import MINI_FEATURES, save_features

    if arguments.out is None and arguments.encoder != MINI:
        raise SimError(f"--out is missing: only the model of {MINI!r} has a default file; valid: --out FILE.npz")
    out: Path = arguments.out or MINI_FEATURES
    check_output_file(out)  # before an hour of rendering
    with progress_bar("rendering and fitting") as progress:
        model = fit_features(load_encoder(arguments.encoder), arguments.houses, progress=progress)
    save_features(model, out)
    loops = model.loops
    print(f"{out}: {out.stat().st_size / 1e3:.0f} kB")
    print(f"error of embeddings: {(model.embedding.errors**2).sum() ** 0.5:.2f}, where embeddings have unit norm")
    print(f"loops: {len(loops.true_edges.inliers)} true and {len(loops.false_edges.inliers)} false edges stored")
    return 0
