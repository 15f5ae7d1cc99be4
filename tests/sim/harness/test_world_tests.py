"""The decorator `worlds`: its draws and its checks."""

from dataclasses import replace

import pytest

from sim.errors import SimError
from sim.faults.delivery import Dropped
from sim.faults.poses import Kidnap
from sim.harness.failures.failed_test import folder_of
from sim.harness.scenario import Scenario
from sim.harness.walk import walk
from sim.harness.world_tests import ATTRIBUTE, HOUSE_SEEDS, SCENARIO, slug_of, stored_failures, worlds
from worlds.house import build_house
from worlds.labels import STAIRS
from worlds.truth import openness


def family(**arguments):
    def test(run):
        pass

    return getattr(worlds(**arguments)(test), ATTRIBUTE)


def test_draws_are_fixed_by_seed_and_index_and_stay_in_their_ranges():
    asked = family(presets=("home", "office"), openness=(0.6, 1.0), max_rooms=6, storeys=2)
    drawn = [asked.draw(7, index) for index in range(300)]
    assert drawn == [asked.draw(7, index) for index in range(300)]
    assert all(0 <= world.seed < HOUSE_SEEDS and 0.6 <= world.openness <= 1.0 for world in drawn)
    assert {world.rooms for world in drawn} == {4, 5, 6}
    assert [world.preset for world in drawn[:3]] == ["home", "office", "home"]
    assert len({world.seed for world in drawn} | {asked.draw(8, index).seed for index in range(300)}) == 600


@pytest.mark.parametrize("asked", [0.1234, (0.0001, 0.0004), (0.0006, 0.0009), 1])
def test_an_openness_of_many_digits_stays_in_its_range(asked):
    low, high = (asked, asked) if isinstance(asked, int | float) else asked
    drawn = [family(openness=asked).draw(7, index).openness for index in range(20)]
    assert all(low <= openness <= high for openness in drawn)


def test_the_seeds_of_houses_do_not_depend_on_what_else_is_asked_for():
    assert family().draw(7, 3).seed == family(openness=0.5, max_rooms=3, n=2).draw(7, 3).seed


@pytest.mark.parametrize("index", range(3))
def test_a_house_is_what_was_asked_for(index):
    world = family(openness=(0.3, 0.5), max_rooms=5, storeys=2, fidelity="layout").draw(1, index)
    scenario = world.scenario()
    house = build_house(scenario.house)
    added = {STAIRS, "corridor", "entrance hall", "lobby"}
    assert len(house.storeys) == 2
    assert sum(room.label not in added for room in house.rooms) <= 5
    assert openness(house) == pytest.approx(world.openness, abs=0.05)
    assert scenario.seed == world.seed and world.name == f"home-{world.seed}"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"presets": "home"}, "worlds: presets is 'home'; valid: a tuple with some of home, ori"),
        ({"presets": ("hme",)}, r"worlds: unknown presets 'hme' \(did you mean 'home'\?\); valid: home, ori"),
        ({"presets": ()}, r"worlds: presets is \(\); valid: a tuple"),
        ({"openness": (0.9, 0.1)}, r"worlds: openness is \(0.9, 0.1\); valid: a number in \[0, 1\], or two"),
        ({"openness": 1.5}, "worlds: openness is 1.5; valid"),
        ({"openness": True}, "worlds: openness is True; valid"),
        ({"openness": (False, 1.0)}, r"worlds: openness is \(False, 1.0\); valid"),
        ({"plans": 1.0}, "worlds: plans is 1.0; valid: True or False"),
        ({"storeys": 5}, "worlds: storeys is 5; valid: a whole number from 1 to 4"),
        ({"storeys": 3, "max_rooms": 2}, "worlds: max_rooms is 2; valid: a whole number from 3 to 40"),
        ({"n": 0}, "worlds: n is 0; valid: a whole number from 1 to 10000"),
        ({"presets": ("ori", "cabin")}, "worlds: unknown presets .cabin.; valid: home, ori"),
        ({"preset": "home"}, r"worlds: no argument 'preset' \(did you mean 'presets'\?\); valid: presets, openness"),
        ({"max_storeys": 2}, r"worlds: no argument 'max_storeys' \(did you mean 'storeys'\?\); valid: presets"),
        ({"length_m": -3}, "worlds: length_m is -3; valid: a number of metres greater than 0"),
        ({"length_m": "long"}, "worlds: length_m is 'long'; valid: a number of metres"),
        ({"frame_rate_hz": 0}, "worlds: frame_rate_hz is 0; valid: a number of hertz greater than 0"),
        ({"plans": "yes"}, "worlds: plans is 'yes'; valid: True or False"),
        ({"odometry": "wheel"}, "worlds: unknown odometry 'wheel'; valid: perfect, multicam"),
        ({"odometry": "mono_"}, r"worlds: unknown odometry 'mono_' \(did you mean 'mono'\?\); valid"),
        (
            {"encoder": "minni"},
            r"worlds: encoder is 'minni' \(did you mean 'mini'\?\); valid with fidelity 'features': mini, o",
        ),
        (
            {"encoder": "oracle", "fidelity": "render"},
            "encoder 'oracle' is told the truth and sees no images; valid: with fid",
        ),
        ({"encoder": None}, "worlds: encoder is None; valid: a name, such as 'mini'"),
        ({"faults": "kidnapp"}, r"worlds: unknown fault 'kidnapp' \(did you mean 'kidnap'\?\); valid: dropped"),
        (
            {"faults": ("kidnap:at=3",)},
            r"worlds: fault 'kidnap:at=3': 'at' is no field of kidnap \(did you mean 'at_s'\?\); valid",
        ),
        ({"faults": (3,)}, "worlds: faults has 3; valid: faults, or texts such as 'kidnap:20,skip_s=5'"),
        ({"faults": Kidnap}, "worlds: faults has <class .*; valid: faults, or texts such as"),
        ({"faults": ""}, "worlds: unknown fault ''; valid: dropped"),
        ({"faults": "blur"}, "worlds: fault 'blur' is seen in images only; valid: with fidelity 'render'"),
    ],
)
def test_wrong_arguments_are_refused_when_the_test_is_decorated(arguments, message):
    with pytest.raises(SimError, match=message):
        worlds(**arguments)


@pytest.mark.parametrize(
    ("faults", "meant"),
    [
        ("kidnap:20,skip_s=5", (Kidnap(20.0, 5.0),)),
        (("dropped", "kidnap:20"), (Dropped(), Kidnap(20.0))),
        (Kidnap(20.0), (Kidnap(20.0),)),
        ([Kidnap(20.0), "dropped:0.5"], (Kidnap(20.0), Dropped(0.5))),
        ([], ()),
    ],
)
def test_faults_are_objects_or_text_in_the_notation_of_the_command_line(faults, meant):
    assert family(faults=faults).faults == meant


def test_the_decorator_needs_its_parentheses_and_names_of_arguments():
    with pytest.raises(SimError, match=r"^worlds takes keyword arguments; write @worlds\(\)$"):
        worlds(lambda run: None)
    with pytest.raises(SimError, match=r"^worlds takes keyword arguments; write such as @worlds\(presets='home'\)$"):
        worlds("home")


def test_only_functions_are_decorated_and_once():
    class TestNothing:
        pass

    def test(run):
        pass

    with pytest.raises(SimError, match="valid: a test function"):
        worlds()(TestNothing)
    with pytest.raises(SimError, match="test is decorated twice; valid: one @worlds"):
        worlds()(worlds()(test))


def test_names_of_folders_tell_tests_apart():
    names = ("tests/test_a.py::test_x", "tests/test_b.py::test_x", "tests/test_a.py::TestA::test_x", "test_a.py::test_x")
    assert len({slug_of(name) for name in names}) == 4
    assert slug_of(names[2]) == "tests-test_a-TestA-test_x"


def test_the_name_of_a_failure_folder_is_never_too_long_for_a_file_system(tmp_path):
    folder = folder_of(tmp_path, "test_a.py::" + "t" * 300, Scenario(), "p" * 300)
    folder.mkdir()
    assert folder != folder_of(tmp_path, "test_a.py::" + "t" * 300, Scenario(), "q" * 300)


def test_stored_failures_are_those_of_the_test_with_any_parameters(tmp_path):
    test, below = "test_a.py::test_b", "test_a/test_b.py::test_c"
    scenario = Scenario(preset="office")
    expected = set()
    for name, parameters in ((test, ""), (test, "clinic-1"), (f"{test}_c", ""), (below, ""), (below, "x")):
        folder = folder_of(tmp_path, name, replace(scenario, seed=len(expected)), parameters)
        folder.mkdir(exist_ok=True)
        replace(scenario, seed=len(expected)).save(folder / SCENARIO)
        if name == test:
            expected.add(folder / SCENARIO)
    assert {stored.file for stored in stored_failures(tmp_path, test)} == expected


def test_a_tour_too_short_for_a_house_is_the_shortest_one_there():
    def length_m(asked):
        return walk(family(max_rooms=3, n=1, length_m=asked).draw(0, 0).scenario()).tour.length_m

    assert length_m(60.0) == pytest.approx(60.0, abs=3.0)
    assert length_m(1.0) == pytest.approx(length_m(5.0)) and 5.0 < length_m(1.0) < 50.0
