"""A scenario in two rooms with an open boundary, in which planted bugs of open plans show."""

from sim.harness import Scenario
from worlds.presets import sample_from_rooms

OPEN_FLAT = Scenario(
    house=sample_from_rooms(("kitchen", "living room"), seed=4, openness=0.6),
    seed=5,
    length_m=20.0,
    frame_rate_hz=2.0,
    fidelity="features",
    encoder="oracle",
)
