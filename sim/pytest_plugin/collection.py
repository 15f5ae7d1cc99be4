"""Collection of decorated tests: each runs once for every one of its worlds (scenarios in fresh or stored houses)."""

from collections.abc import Sequence

import pytest

from sim.harness.world_tests import ATTRIBUTE, StoredWorld, World, WorldFamily, stored_failures
from sim.pytest_plugin.options import SEED, out_folder, replayed_file

SHARE_S = pytest.StashKey[float]()
"""Key under which pytest stores each decorated test's share of the time budget [s]; absent without a budget."""


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Turn a test that is decorated with `worlds` into one test for each of its worlds."""
    family, name = _family(metafunc.function), metafunc.definition.nodeid
    if family is None:
        return
    if "scenario" not in metafunc.fixturenames:
        raise pytest.UsageError(
            f"{name} is decorated with @worlds and takes no house; valid: the argument run, house or scenario"
        )
    if family.fidelity == "layout" and "run" in metafunc.fixturenames:
        raise pytest.UsageError(f"{name}: no SLAM runs with fidelity 'layout'; valid: the argument house instead of run")
    mark = getattr(pytest.mark, family.fidelity)
    worlds = [pytest.param(world, marks=mark, id=world.name) for world in _worlds_of(family, metafunc.config, name)]
    metafunc.parametrize("scenario", worlds, indirect=True)


def _worlds_of(family: WorldFamily, config: pytest.Config, name: str) -> Sequence[World]:
    if (replayed := replayed_file(config)) is not None:
        return [StoredWorld(replayed, "replay")]
    stored = stored_failures(out_folder(config), name) if config.option.lexis_profile == "lexis-nightly" else []
    return [*stored, *(family.draw(config.stash[SEED], index) for index in range(family.n))]


def pytest_collection_finish(session: pytest.Session) -> None:
    """Divide the time budget `--lexis-budget` equally among the decorated tests.

    The workers of xdist run in parallel, so each test's share is multiplied by their number.
    """
    budget_s = session.config.option.lexis_budget
    items = sum(family_of(item) is not None for item in session.items)
    if budget_s is not None and items:
        workers = getattr(session.config, "workerinput", {}).get("workercount", 1)
        session.config.stash[SHARE_S] = budget_s * workers / items


def family_of(item: pytest.Item) -> WorldFamily | None:
    """Return what a test decorated with `worlds` requires of its houses and runs; None for any other test."""
    return _family(getattr(item, "function", None))


def world_of(item: pytest.Item) -> World:
    """Return the world for which `pytest_generate_tests` has made a decorated test."""
    world: World = item.callspec.params["scenario"]  # type: ignore[attr-defined]
    return world


def name_of(item: pytest.Item) -> str:
    """Return file and function of a test. If the test is not decorated, the id of its parameters follows."""
    return item.nodeid if family_of(item) is None else item.nodeid.removesuffix(f"[{item.callspec.id}]")  # type: ignore[attr-defined]


def parameters_of(item: pytest.Item) -> str:
    """Return the pytest id of the parameters that a decorated test has besides its world; empty if there are none."""
    if family_of(item) is None:
        return ""
    ids: str = item.callspec.id  # type: ignore[attr-defined]
    return ids.replace(world_of(item).name, "", 1).strip("-")


def _family(function: object) -> WorldFamily | None:
    family = getattr(function, ATTRIBUTE, None)
    return family if isinstance(family, WorldFamily) else None
