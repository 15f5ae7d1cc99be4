"""Faces of packages: every package says what lives in it, and its public names are there without loading what is heavy."""

import importlib
import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest

TOPS = ("lexis", "sim", "worlds")
HEAVY = {"cv2", "gtsam", "hypothesis", "jaxtyping", "mujoco", "numpy", "open_clip", "scipy", "shapely", "torch"}


def packages():
    """Names of all packages, the three at the top included."""
    for top in TOPS:
        yield top
        yield from (m.name for m in pkgutil.walk_packages(importlib.import_module(top).__path__, f"{top}.") if m.ispkg)


PACKAGES = tuple(packages())


@pytest.mark.parametrize("name", PACKAGES)
def test_every_package_says_what_lives_in_it(name):
    package = importlib.import_module(name)
    first, *rest = (package.__doc__ or "").strip().splitlines()
    assert first.endswith((".", ":")) and rest


@pytest.mark.parametrize("name", PACKAGES)
def test_every_module_of_a_package_with_many_is_named_in_its_docstring(name):
    package = importlib.import_module(name)
    modules = {module.name for module in pkgutil.iter_modules(package.__path__) if not module.ispkg}
    assert len(modules) <= 25
    if name.count(".") and name not in ("sim.commands", "worlds.furniture"):
        assert {module for module in modules if f"`{module}`" not in package.__doc__} == set()


@pytest.mark.parametrize("name", PACKAGES)
def test_every_public_name_is_there_and_is_no_module(name):
    package = importlib.import_module(name)
    public = getattr(package, "__all__", [])
    modules = {module.name for module in pkgutil.iter_modules(package.__path__)}
    assert modules.isdisjoint(public)
    assert all(hasattr(package, each) for each in public)


def test_no_two_public_names_mean_different_things():
    meaning = {}
    for name in PACKAGES:
        package = importlib.import_module(name)
        for public in getattr(package, "__all__", []):
            assert meaning.setdefault(public, getattr(package, public)) is getattr(package, public), f"{name}.{public}"


def test_no_two_classes_have_the_same_name():
    owner = {}
    for top in TOPS:
        for module in pkgutil.walk_packages(importlib.import_module(top).__path__, f"{top}."):
            for name, thing in vars(importlib.import_module(module.name)).items():
                if isinstance(thing, type) and thing.__module__ == module.name and not name.startswith("_"):
                    assert owner.setdefault(name, module.name) == module.name


@pytest.mark.parametrize("top", TOPS)
def test_a_face_loads_nothing_heavy(top):
    code = f"import sys, {top}; dir({top}); print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert HEAVY.isdisjoint(loaded)


def test_types_are_shipped():
    assert all(Path(importlib.import_module(top).__file__).with_name("py.typed").exists() for top in TOPS)
