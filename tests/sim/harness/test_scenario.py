"""A scenario is the same after a trip through JSON, and says clearly what is wrong with a damaged one."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
from helpers.unchecked import unchecked, untyped
from hypothesis import given
from hypothesis import strategies as st

from sim.errors import SimError
from sim.faults import FAULTS
from sim.faults.delivery import Dropped
from sim.faults.poses import Kidnap
from sim.harness.scenario import NEEDS_PIXELS, Scenario, scenario_from_data
from sim.odometry.config import ODOMETRY_PRESETS
from sim.render.rig import RIGS, RigConfig
from sim.tours.config import TOUR_KINDS
from sim.tours.sway import SWAYS
from worlds.errors import WorldsError
from worlds.furniture import registry
from worlds.presets import PRESETS, sample_from_rooms

HOUSE = sample_from_rooms(("kitchen", "bedroom"), seed=21)
FULL = Scenario(
    seed=2**62, house=HOUSE, length_m=31.7, tour_kind="loop", reverse=True, frame_rate_hz=7.0, sway="quadruped",
    odometry="mono", overconfidence=20.0, fidelity="features", encoder="oracle", feature_model=Path("some/model.npz"),
    faults=(Dropped(1 / 3, burst=2), Kidnap(at_s=10.0)), rig=RigConfig("stereo", 160, 120, 90.0, (0.1, 0.0, -0.05)),
)  # fmt: skip


@st.composite
def scenarios(draw):
    fidelity = draw(st.sampled_from(("render", "features")))
    kinds = [kind for kind in FAULTS.values() if fidelity == "render" or not issubclass(kind, NEEDS_PIXELS)]
    return Scenario(
        preset=draw(st.sampled_from(PRESETS)),
        seed=draw(st.integers(0, 999_999)),
        house=draw(st.sampled_from((None, HOUSE))),
        length_m=draw(st.none() | st.floats(1.0, 500.0)),
        tour_kind=draw(st.sampled_from(TOUR_KINDS)),
        reverse=draw(st.booleans()),
        frame_rate_hz=draw(st.floats(0.1, 60.0)),
        sway=draw(st.sampled_from(SWAYS)),
        odometry=draw(st.sampled_from(sorted(ODOMETRY_PRESETS))),
        overconfidence=draw(st.floats(1.0, 300.0)),
        fidelity=fidelity,
        faults=tuple(kind() for kind in draw(st.lists(st.sampled_from(kinds), max_size=3))),
        rig=RigConfig(draw(st.sampled_from(sorted(RIGS))), draw(st.integers(16, 900))),
    )


@given(scenarios())
def test_json_and_back(scenario):
    again = scenario_from_data(json.loads(json.dumps(scenario.data(), allow_nan=False)))
    assert again == scenario and again.content_hash == scenario.content_hash


def test_every_field_survives_a_file(tmp_path):
    FULL.save(tmp_path / "scenario.json")
    assert Scenario.load(tmp_path / "scenario.json") == Scenario.load(str(tmp_path / "scenario.json")) == FULL


def test_what_is_left_out_keeps_its_default():
    assert scenario_from_data({"format": "lexis-scenario", "version": 1, "seed": 3}) == Scenario(seed=3)


def test_different_scenarios_have_different_hashes():
    others = [replace(FULL, **{name: value}) for name, value in (
        ("seed", 1), ("house", None), ("length_m", 31.8), ("odometry", "perfect"), ("faults", ()),
        ("rig", RigConfig("stereo")),
    )]  # fmt: skip
    assert len({scenario.content_hash for scenario in (FULL, *others)}) == len(others) + 1


GOOD = {"format": "lexis-scenario", "version": 1}


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ([], "is no scenario; valid: a JSON object with format 'lexis-scenario'"),
        ({"format": "lexis-house"}, "is no scenario; valid"),
        (GOOD | {"version": 2}, "scenario has version 2; valid: 1"),
        (GOOD | {"sede": 3}, "scenario has no setting 'sede'; valid: preset, seed"),
        (GOOD | {"seed": -1}, "scenario.seed is -1; valid: >= 0"),
        (GOOD | {"faults": "fog"}, "scenario.faults is no list of objects; valid"),
        (GOOD | {"faults": [{"name": "fog"}]}, "scenario.faults: unknown fault 'fog'; valid: dropped"),
        (GOOD | {"faults": [{"name": "dropped", "sahre": 1}]}, "scenario.faults: dropped has no field 'sahre'; valid: "),
        (GOOD | {"faults": [{"name": "dropped", "share": "x"}]}, "scenario.faults: dropped.share is 'x'; valid: a number"),
        (GOOD | {"faults": [{"name": "dropped", "burst": 2.5}]}, "scenario.faults: dropped.burst is 2.5; valid: a whole"),
        (GOOD | {"faults": [{"name": "kidnap", "at_s": 10**400}]}, "scenario.faults: fault kidnap: at_s is 1"),
        (GOOD | {"version": True}, "scenario has version True; valid: 1"),
        (GOOD | {"frame_rate_hz": 1e308}, "scenario.frame_rate_hz is 1e+308; valid: >= 0.1 and <= 120 Hz"),
        (GOOD | {"length_m": 2**70}, "scenario.length_m is 1.18"),
        (GOOD | {"rig": {"name": "wide", "width": 3}}, "rig.width is 3; valid: >= 16"),
        (GOOD | {"rig": {"lever_arm_m": None}}, "rig.lever_arm_m is None; valid: three numbers up to 1e+06"),
        (GOOD | {"rig": {"lever_arm_rpy_deg": [0, 0, 10**400]}}, "rig.lever_arm_rpy_deg is (0.0, 0.0, 1"),
    ],
)
def test_bad_data_names_the_field_and_what_is_valid(data, message, monkeypatch):
    monkeypatch.setattr(RigConfig, "__init__", untyped(RigConfig.__init__))
    with pytest.raises(SimError) as caught:
        scenario_from_data(data)
    assert str(caught.value).startswith(message)


def test_furniture_of_ones_own_belongs_to_a_scenario(tmp_path, monkeypatch):
    monkeypatch.setattr(registry, "KINDS", dict(registry.KINDS))
    plain = Scenario().content_hash
    sizes = dict.fromkeys(("width", "depth", "height"), (1.0, 1.2))
    registry.furniture("grand piano", **sizes, rooms={"kitchen": (1, 1)})(lambda s, rng: ())
    Scenario().save(tmp_path / "scenario.json")
    assert Scenario.load(tmp_path / "scenario.json") == Scenario() and Scenario().content_hash != plain
    del registry.KINDS["grand piano"]
    with pytest.raises(SimError, match=r"scenario\.json: .* furniture that is not declared here, 'grand piano'.*@furniture"):
        Scenario.load(tmp_path / "scenario.json")


def test_a_bad_file_is_named(tmp_path):
    file = tmp_path / "scenario.json"
    file.write_text(json.dumps(GOOD | {"sede": 3}))
    with pytest.raises(SimError, match=r"scenario\.json: scenario has no setting 'sede'"):
        Scenario.load(file)
    file.write_text(json.dumps(GOOD | {"house": {"storeys": []}}))
    with pytest.raises(WorldsError, match=r"^.*scenario\.json: "):
        Scenario.load(file)
    file.write_text("{")
    with pytest.raises(SimError, match=r"scenario\.json: cannot be used: is not JSON"):
        Scenario.load(file)


def test_the_hash_stays_the_same_in_a_file(tmp_path):
    storey = HOUSE.storeys[0]
    house = HOUSE.model_copy(update={"storeys": (storey.model_copy(update={"height_m": 3}),)})
    scenario = unchecked(Scenario, house=house, length_m=15, frame_rate_hz=4)
    scenario.save(tmp_path / "scenario.json")
    again = Scenario.load(tmp_path / "scenario.json")
    assert again == scenario and again.content_hash == scenario.content_hash


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"house": "home.json"}, r"^scenario\.house is 'home\.json'; valid: a HouseSpec, such as HouseSpec\.load\(path\)"),
        ({"rig": "wide"}, r"^scenario\.rig is 'wide'; valid: a RigConfig, such as RigConfig\('stereo'\)"),
        ({"encoder": "oracl", "fidelity": "features"}, r"^encoder 'oracl' \(did you mean 'oracle'\?\) is not the one that"),
    ],
)
def test_values_that_would_fail_in_the_run_are_refused(settings, message):
    with pytest.raises(SimError, match=message):
        unchecked(Scenario, **settings)


def test_features_of_another_encoder_have_a_model_of_their_own(tmp_path):
    assert Scenario(encoder="ViT-B-32", fidelity="features", feature_model=tmp_path / "model.npz").encoder == "ViT-B-32"
    assert Scenario(encoder="ViT-B-32").encoder == "ViT-B-32"


@pytest.mark.parametrize("faults", ["kidnap", ("kidnap:at_s=3",), [Kidnap()], (Kidnap,)])
def test_faults_that_are_no_tuple_of_faults_are_refused(faults):
    with pytest.raises(SimError, match=r"^scenario\.faults is .*; valid: a tuple of faults, such as \(parse_fault\("):
        unchecked(Scenario, faults=faults)
