"""The tested versions: one for every package that the environment needs, for every Python version and any registry."""

import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parent.parent
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
NEEDED = (
    *PYPROJECT["project"]["dependencies"],
    *(package for group in PYPROJECT["dependency-groups"].values() for package in group),
)
PINS = [line for line in (ROOT / "tests/constraints.txt").read_text().splitlines() if not line.startswith("#")]
PYTHONS = ("3.11", "3.12", "3.13", "3.14")


def pinned(python):
    """Versions by package, for Linux."""
    system = {"python_version": python, "python_full_version": f"{python}.1", "sys_platform": "linux"}
    pins = [Requirement(line) for line in PINS]
    chosen = [pin for pin in pins if pin.marker is None or pin.marker.evaluate(system | {"platform_machine": "x86_64"})]
    assert len({pin.name for pin in chosen}) == len(chosen)
    return {canonicalize_name(pin.name): str(pin.specifier).removeprefix("==") for pin in chosen}


def test_a_line_is_a_name_and_a_version():
    """A line has no address, hash or extra: those differ between registries, or pip refuses them in constraints."""
    odd = [line for line in PINS if not re.fullmatch(r"[a-z0-9-]+==[0-9a-z.]+( ; [^@/]+)?", line)]
    assert PINS and odd == []


@pytest.mark.parametrize("python", PYTHONS)
def test_what_is_needed_is_pinned_within_its_range(python):
    versions = pinned(python)
    for needed in map(Requirement, NEEDED):
        assert versions[canonicalize_name(needed.name)] in needed.specifier


@pytest.mark.parametrize("python", PYTHONS[1:])
def test_what_is_needed_is_the_same_on_every_python(python):
    names = {canonicalize_name(Requirement(needed).name) for needed in NEEDED}
    assert {name: pinned(python)[name] for name in names} == {name: pinned(PYTHONS[0])[name] for name in names}
