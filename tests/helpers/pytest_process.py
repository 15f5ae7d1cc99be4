"""The environment in which tests start pytest in a process of its own."""

import os

import pytest


def isolate_pytest(monkeypatch: pytest.MonkeyPatch, *paths: os.PathLike[str]) -> None:
    """Set the environment of pytest processes: modules are found in `paths`, and the output is the same on every machine."""
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(map(os.fspath, paths)))
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    for name in ("CI", "BUILD_NUMBER"):  # pytest's summary repeats whole messages if one of them is set
        monkeypatch.delenv(name, raising=False)
