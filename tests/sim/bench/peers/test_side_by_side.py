"""Several systems on one walk claim what each of them claims alone."""

from dataclasses import replace

import numpy as np
from helpers.open_flat import OPEN_FLAT

from lexis.config import PAPER
from sim.bench.peers.side_by_side import run_side_by_side
from sim.harness import run
from sim.harness.adapters import GeometricRooms, Lexis, OdometryOnly

FAR_APART = replace(PAPER, keyframes=replace(PAPER.keyframes, spacing_m=1.0))
SLAMS = {
    "odometry": OdometryOnly,
    "rooms": GeometricRooms,
    "LEXIS": lambda: Lexis("oracle", PAPER),
    "LEXIS, other rooms and loops": lambda: Lexis("oracle"),
    "LEXIS, other keyframes": lambda: Lexis("oracle", FAR_APART),
}


def test_systems_side_by_side_claim_what_they_claim_alone():
    together = run_side_by_side(OPEN_FLAT, {name: make() for name, make in SLAMS.items()})
    assert list(together) == list(SLAMS)
    for name, make in SLAMS.items():
        alone = run(OPEN_FLAT, make()).estimate
        assert (together[name].estimate.frames == alone.frames).all()
        for claim in ("T_W_B", "labels", "rooms", "floors"):
            mine, other = getattr(together[name].estimate, claim), getattr(alone, claim)
            assert (mine is None and other is None) or np.array_equal(mine, other)


def test_each_run_has_its_own_system():
    slams = {name: make() for name, make in SLAMS.items()}
    assert all(found.slam is slams[name] for name, found in run_side_by_side(OPEN_FLAT, slams).items())
