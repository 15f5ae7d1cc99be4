"""`lexis-sim house check|prove`: check that one house is valid and walkable, or check thousands of sampled houses."""

import argparse
from dataclasses import astuple

from rich.table import Table

from lexis.command_line import positive
from sim.commands.action import Action
from sim.commands.arguments import SEED, argument
from sim.commands.console import standard_output
from sim.commands.house_action import FILE, describe
from sim.commands.progress import tracked
from sim.processes import usable_cores
from worlds.checks.essentials import missing_essentials
from worlds.house import build_house
from worlds.presets import PRESETS
from worlds.spec import HouseSpec
from worlds.valid_names import did_you_mean
from worlds.validation import spec_problems


def _check(arguments: argparse.Namespace) -> int:
    spec = HouseSpec.load(arguments.file)
    found = 0
    for found, problem in enumerate(spec_problems(spec), 1):  # noqa: B007
        print(f"{arguments.file}: {problem}")
    if not found:
        house = build_house(spec)
        print(f"{arguments.file}: {describe(house)}; all checks passed")
        for room, kind in missing_essentials(house) if house.furniture else ():
            print(f"{arguments.file}: note: {room} has no {kind}, although every {house.room_by_id[room].label} should")
    return int(found > 0)


def _prove(arguments: argparse.Namespace) -> int:
    from sim.house_proof import cases, prove, summaries

    wanted = cases(arguments.preset, arguments.seed, arguments.houses)
    proofs = []
    for proof in tracked(prove(wanted, arguments.processes), len(wanted), "houses"):
        proofs.append(proof)
        if proof.failure is not None:
            print(f"{proof.case}: {proof.failure}")
    table = Table(
        *("family", "houses", "failed", "rooms", "lacking", "median, ms", "worst, ms"),
        title="processor time for a complete house, on one core",
        caption="lacking: rooms of usually furnished houses without an essential piece, such as a kitchen's sink",
    )
    for row in summaries(proofs):
        table.add_row(*(f"{value:.0f}" if isinstance(value, float) else str(value) for value in astuple(row)))
    standard_output().print(table)
    return int(any(proof.failure is not None for proof in proofs))


def _presets(text: str) -> list[str]:
    presets = [name.strip() for name in text.split(",")]
    if unknown := [name for name in presets if name not in PRESETS]:
        guess = did_you_mean(unknown[0], PRESETS)
        raise argparse.ArgumentTypeError(f"unknown preset {unknown[0]!r}{guess}; valid: {', '.join(PRESETS)}")
    return presets


CHECK = Action(
    "check",
    _check,
    "check that a house is valid and walkable, or list everything that is wrong",
    "lexis-sim house check home.json",
    (FILE,),
)
PROVE = Action(
    "prove",
    _prove,
    "sample and check many houses, each in two processes whose results must be equal bit by bit",
    "lexis-sim house prove --houses 1000",
    (
        argument(
            "--preset",
            type=_presets,
            default=PRESETS,
            metavar="A,B,...",
            help="families of houses, used in turn (default: all)",
        ),
        argument(
            "--houses", type=positive, default=1000, help="number of houses, from --seed upwards (default: %(default)s)"
        ),
        argument(
            "--processes",
            type=positive,
            default=usable_cores(),
            help="number of processes; at least 2 are used (default: one for each core that this process may use)",
        ),
        SEED,
    ),
)
