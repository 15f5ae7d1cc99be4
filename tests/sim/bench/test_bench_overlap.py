"""The report of `bench speed` on rendering and LEXIS running at the same time."""

import pytest
from helpers.blind_encoder import BlindEncoder

from sim.bench.overlap import Overlap, Seconds, measure_overlap
from sim.harness import Scenario
from sim.render.rig import RigConfig
from worlds.presets import sample_from_rooms


def test_shares_are_of_the_slower_task_and_of_the_sum():
    overlap = Overlap(Seconds(2.0, 3.0), Seconds(4.0, 5.0), Seconds(4.4, 8.8), slower_s=4.0)
    assert overlap.wall_over_slower_alone == overlap.wall_over_slower_within == pytest.approx(1.1)
    assert overlap.extra_work == pytest.approx(1.1)


def test_each_alone_and_both_at_once_are_measured(monkeypatch):
    monkeypatch.setattr("sim.bench.overlap.load_encoder", lambda name: BlindEncoder())
    config = Scenario(house=sample_from_rooms(("kitchen", "bedroom"), seed=21), rig=RigConfig("wide", 96, 72))
    (overlap,) = measure_overlap(config, frames=12, repetitions=1)
    assert min(overlap.rendering.processor, overlap.lexis.processor) > 0.0
    assert overlap.both.wall >= overlap.slower_s > 0.0
