"""Response curves: every variant changes one setting, and an equal setting leaves every figure as it is."""

from dataclasses import asdict

import pytest

from lexis.config import Config
from sim.bench.peers.responses import SECTIONS, SettingVariant, measure_house_responses, variants, write_responses
from sim.bench.stage_costs import UNCHANGED


def flat(config):
    return {f"{section}.{name}": value for section, own in asdict(config).items() for name, value in own.items()}


def test_every_variant_changes_one_setting_and_no_two_are_equal():
    found, default = variants(), flat(Config())
    for each in found:
        assert {name for name, value in flat(each.config).items() if value != default[name]} == {each.setting}
        assert flat(each.config)[each.setting] == each.value
    assert len({each.name for each in found}) == len(found) > 100
    assert {each.setting.partition(".")[0] for each in found} == set(SECTIONS)


def test_values_that_are_not_valid_are_left_out():
    growth = [each.value for each in variants(("pose_graph",)) if each.setting == "pose_graph.growth"]
    assert growth and max(growth) < 1
    ratios = [each.value for each in variants(("verification",)) if each.setting == "verification.ratio"]
    assert ratios and max(ratios) <= 1


@pytest.fixture(scope="module")
def rows():
    same = SettingVariant("sight.range_m", 1.0, 6.0, Config())
    return measure_house_responses("home", 101, (same, *variants(("sight",))[:8]))


def test_the_same_setting_gives_the_same_figures(rows):
    assert rows[0].replaced == UNCHANGED
    assert asdict(rows[1]) == asdict(rows[0]) | {"replaced": "sight.range_m = 6"}
    assert any((row.labels, row.rooms) != (rows[0].labels, rows[0].rooms) for row in rows)
    assert all(row.ate_m == rows[0].ate_m for row in rows)  # sight moves no keyframe


def test_curves_are_drawn_through_the_default(rows, tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr("sim.bench.peers.responses.draw_panels", lambda panels, *_: drawn.extend(panels))
    monkeypatch.setattr("sim.bench.peers.responses.variants", lambda sections: variants(("sight",))[:8])
    write_responses(rows, ("sight",), tmp_path / "curves.png")
    ((_, labels),), ((_, rooms),), ((_, ate),) = drawn
    assert list(labels) == ["range_m", "reach_m"]
    assert [x for x, *_ in labels["reach_m"]] == pytest.approx([0.5, 0.7, 1.0, 1.4, 2.0])
    assert all(point[:2] == (1.0, 0.0) for curves in (labels, rooms, ate) for point in [curves["reach_m"][2]])
