"""Collection of decorated tests: each runs once for every one of its worlds (scenarios in fresh or stored houses)."""

import importlib.util
import re
import types
from collections.abc import Sequence
from pathlib import Path

import pytest
from _pytest.fixtures import getfixturemarker

from sim.harness.world_tests import ATTRIBUTE, SCENARIO, TEST_REPLAY, StoredWorld, World, WorldFamily, stored_failures
from sim.pytest_plugin.options import SEED, out_folder, replayed_file

SHARE_S = pytest.StashKey[float]()
"""Key under which pytest stores each decorated test's share of the time budget [s]; absent without a budget."""

REFERENCE = "reference_slam"
"""Name of a fixture of the user that returns a SLAM with which the test passes; the plugin has none of this name."""
_FIXTURES = "sim.pytest_plugin.fixtures"
"""Module of the plugin's own fixtures."""
_REPLAY = "replay"
"""Name of the world of a decorated test in a replay."""


def pytest_pycollect_makemodule(module_path: Path, parent: pytest.Collector) -> pytest.Module | None:
    """Collect test_replay.py from the folder of a failure under a name of its own.

    pytest would otherwise refuse to collect the files of this name from several folders.
    """
    if module_path.name != TEST_REPLAY or not module_path.with_name(SCENARIO).is_file():
        return None
    module: pytest.Module = _ReplayModule.from_parent(parent, path=module_path)
    return module


class _ReplayModule(pytest.Module):
    """A Python file that is loaded under the name of its folder, and stays out of `sys.modules`."""

    def _getobj(self) -> types.ModuleType:
        spec = importlib.util.spec_from_file_location(self.path.parent.name, self.path)
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Turn a test that is decorated with `worlds` into one test for each of its worlds."""
    family, name = _family(metafunc.function), metafunc.definition.nodeid
    if family is None:
        return
    if problem := _problem(metafunc, family):
        raise pytest.Collector.CollectError(f"{name} {problem}")
    mark = getattr(pytest.mark, family.fidelity)
    worlds = [pytest.param(world, marks=mark, id=world.name) for world in _worlds_of(family, metafunc.config, name)]
    metafunc.parametrize("scenario", worlds, indirect=True)


def _problem(metafunc: pytest.Metafunc, family: WorldFamily) -> str:
    """Say why a decorated test cannot run in houses, as the end of a sentence about the test; "" if it can."""
    if "scenario" not in metafunc.fixturenames:
        return "is decorated with @worlds and takes no house; valid: the argument run, house or scenario"
    if family.fidelity == "layout" and "run" in metafunc.fixturenames:
        return "takes run, but no SLAM runs with fidelity 'layout'; valid: the argument house instead of run"
    for name, effect in (("slam", "would test LEXIS"), (REFERENCE, "would be shrunk without a reference")):
        if "slam" in metafunc.fixturenames and (place := _not_a_fixture(metafunc, name)) is not None:
            return (
                f"{effect}: the name {name} in {place} is no fixture; "
                f"valid: @pytest.fixture above a function {name}() that returns a SLAM, or another name"
            )
    return ""


def has_own_fixture(item: pytest.Item, name: str) -> bool:
    """Return whether the user has defined a fixture of this name for a test, be it in place of one of the plugin or new."""
    found = item.session._fixturemanager.getfixturedefs(name, item) or ()
    return bool(found) and found[-1].func.__module__ != _FIXTURES


def _not_a_fixture(metafunc: pytest.Metafunc, fixture: str) -> str | None:
    """Return the place of a name that looks like a SLAM of the user, although the user has no fixture of this name.

    None if there is none. Modules of this name, as in `from lexis import slam`, do not look like a SLAM.
    """
    if has_own_fixture(metafunc.definition, fixture):
        return None
    folder = metafunc.definition.path.parent
    plugins = [plugin for plugin in metafunc.config.pluginmanager.get_plugins() if isinstance(plugin, types.ModuleType)]
    files = [(module, Path(module.__file__ or "")) for module in plugins]
    conftests = [(module, file) for module, file in files if file.name == "conftest.py"]
    places: dict[str, object] = {} if metafunc.cls is None else {f"class {metafunc.cls.__name__}": metafunc.cls}
    places[metafunc.definition.path.name] = metafunc.module
    places |= {str(file): module for module, file in conftests if folder.is_relative_to(file.parent)}
    return next((name for name, place in places.items() if _has_other(place, fixture)), None)


def _has_other(place: object, fixture: str) -> bool:
    """Return whether a module or class has an attribute of this name that is neither a fixture nor a module."""
    slam = getattr(place, fixture, None)
    return slam is not None and not isinstance(slam, types.ModuleType) and getfixturemarker(slam) is None


def _worlds_of(family: WorldFamily, config: pytest.Config, name: str) -> Sequence[World]:
    if (replayed := replayed_file(config)) is not None:
        return [StoredWorld(replayed, _REPLAY)]
    stored = stored_failures(out_folder(config), name) if config.option.lexis_profile == "lexis-nightly" else []
    drawn = (family.draw(config.stash[SEED], index) for index in range(family.n))
    return [*stored, *{world.name: world for world in drawn}.values()]  # a house that is drawn twice is tested once


def pytest_collection_finish(session: pytest.Session) -> None:
    """Divide the time budget `--lexis-budget` equally among the decorated tests.

    If the workers of xdist share the tests, each test's share is multiplied by their number.
    """
    budget_s = session.config.option.lexis_budget
    items = sum(family_of(item) is not None for item in session.items)
    if budget_s is not None and items:
        workers = getattr(session.config, "workerinput", {}).get("lexis_workers", 1)
        session.config.stash[SHARE_S] = budget_s * workers / items


def family_of(item: pytest.Item) -> WorldFamily | None:
    """Return what a test decorated with `worlds` requires of its houses and runs; None for any other test."""
    return _family(getattr(item, "function", None))


def is_without_worlds(item: pytest.Item) -> bool:
    """Return whether a test is decorated with `worlds` in vain: pytest makes no parameters for methods of a TestCase."""
    return family_of(item) is not None and not hasattr(item, "callspec")


def world_of(item: pytest.Item) -> World:
    """Return the world for which `pytest_generate_tests` has made a decorated test."""
    world: World = item.callspec.params["scenario"]  # type: ignore[attr-defined]
    return world


def name_of(item: pytest.Item) -> str:
    """Return file and function of a test. If the test is not decorated, the id of its parameters follows."""
    return item.nodeid if family_of(item) is None else item.nodeid.removesuffix(f"[{_ids(item)}]")


def parameters_of(item: pytest.Item) -> str:
    """Return the pytest id of the parameters that a decorated test has besides its world; empty if there are none."""
    return "" if family_of(item) is None else _with_world(item, "").strip("-")


def replayed_name(item: pytest.Item) -> str:
    """Return the name by which pytest finds a test in a replay: with the id of its parameters other than the world."""
    if not parameters_of(item):
        return name_of(item)
    return f"{name_of(item)}[{_with_world(item, _REPLAY)}]"


def _with_world(item: pytest.Item, name: str) -> str:
    """Return the id of all parameters of a decorated test, with another name in place of its world's."""
    return with_world(_ids(item), world_of(item).name, name)


def with_world(ids: str, world: str, name: str) -> str:
    """Return the ids of parameters, joined by hyphens, with `name` in place of the id `world`."""
    return re.sub(rf"(?:^|(?<=-)){re.escape(world)}(?=-|$)", lambda _: name, ids, count=1)


def _ids(item: pytest.Item) -> str:
    """Return the id of all parameters of a test, its world included."""
    ids: str = item.callspec.id  # type: ignore[attr-defined]
    return ids


def _family(function: object) -> WorldFamily | None:
    family = getattr(function, ATTRIBUTE, None)
    return family if isinstance(family, WorldFamily) else None
