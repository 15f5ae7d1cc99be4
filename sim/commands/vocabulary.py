"""`lexis-sim orb-vocabulary`: learn visual words for ORB-SLAM from training houses."""

import argparse
from pathlib import Path

from lexis.command_line import Commands, add_command
from sim.commands.arguments import whole_number
from sim.errors import SimError

_MOST_WORDS = 1_000_000


def add_to(commands: Commands) -> None:
    """Add the command `orb-vocabulary`."""
    learn = add_command(
        commands,
        "orb-vocabulary",
        _learn,
        "learn visual words for ORB-SLAM2 and ORB-SLAM3 from training houses, in a file like their ORBvoc.txt",
        "lexis-sim orb-vocabulary -o ORBvoc.txt",
    )
    learn.add_argument(
        "--branching", type=whole_number(2, 20), default=10, help="children of each node (default: %(default)s)"
    )
    learn.add_argument("--depth", type=whole_number(1, 6), default=5, help="levels of the tree (default: %(default)s)")
    learn.add_argument("-o", "--out", type=Path, required=True, metavar="FILE", help="file for the words")


def _learn(arguments: argparse.Namespace) -> int:
    import numpy as np

    from sim.baselines.places.dbow2_file import write_dbow2
    from sim.baselines.places.descriptors import training_descriptors
    from sim.baselines.places.word_tree import WordTree
    from sim.output_files import check_output_file

    check_output_file(arguments.out)
    if arguments.branching**arguments.depth > _MOST_WORDS:
        raise SimError(f"{arguments.branching} to the power of {arguments.depth} words; valid: up to {_MOST_WORDS}")
    images = training_descriptors().orb
    write_dbow2(WordTree.learned(images, np.random.default_rng(0), arguments.branching, arguments.depth), arguments.out)
    print(f"up to {arguments.branching**arguments.depth} words of {len(images)} images are in {arguments.out}")
    return 0
