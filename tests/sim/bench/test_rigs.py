"""The benchmark of rigs counts what LEXIS finds on the way back."""

from dataclasses import replace

import pytest

from sim.bench.rigs import RigRow, measure_rigs, summary


def test_a_rear_camera_finds_the_way_back_and_a_front_camera_alone_does_not():
    wide, both = measure_rigs(("wide", "front-rear"), "uh2-apt", [5], "features")
    assert (wide.rig, both.rig) == ("wide", "front-rear") and wide.revisits == both.revisits > 30
    assert wide.recall < 0.2 < 0.8 < both.recall
    assert wide.false == both.false == 0 and both.trusted > wide.trusted


def test_the_summary_adds_counts_and_averages_shares():
    row = RigRow("four", 1, 10, 8, 20, 1, 0.9, 0.8, 0.1, 5.0)
    other = replace(row, seed=2, revisits=30, found=12, labels=0.7, keyframe_ms=7.0)
    (found,) = summary([row, other])
    assert (found.revisits, found.found, found.trusted, found.false) == (40, 20, 40, 2)
    assert found.recall == 0.5 and found.labels == pytest.approx(0.8) and found.keyframe_ms == pytest.approx(6.0)


def test_a_figure_that_a_house_does_not_have_is_left_out():
    row = RigRow("four", 1, 10, 8, 20, 1, 0.9, 0.8, 0.1, 5.0)
    (found,) = summary([row, replace(row, seed=2, labels=0.7, rooms=None)])
    assert found.labels == pytest.approx(0.8) and found.rooms == 0.8
    (found,) = summary([replace(row, rooms=None)])
    assert found.rooms is None
