"""The console scripts: Ctrl-C ends them with one line and status 130 at any time, also while their modules load."""

import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

SCRIPTS = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]["scripts"]
INTERRUPTED_AT = """
import sys

interrupted_at = sys.argv.pop(1)

class Interrupted:
    def find_spec(name, path=None, target=None):
        if name == interrupted_at:
            raise KeyboardInterrupt

sys.meta_path.insert(0, Interrupted)
from {module} import {function}
sys.exit({function}())
"""
"""A console script, as pip writes it, in which Ctrl-C is pressed when the import of one module begins."""


@pytest.mark.parametrize("script", SCRIPTS)
@pytest.mark.parametrize("module", ["{package}.cli", "lexis.command_line", "lexis.files", "shtab"])
def test_ctrl_c_while_the_modules_load_is_one_line(script, module):
    entry, function = SCRIPTS[script].split(":")
    code = INTERRUPTED_AT.format(module=entry, function=function)
    words = [sys.executable, "-c", code, module.format(package=entry.partition(".")[0]), "--help"]
    done = subprocess.run(words, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "interrupted\n")


@pytest.mark.parametrize("script", SCRIPTS)
def test_a_console_script_runs_its_commands(script, monkeypatch, capsys):
    entry, function = SCRIPTS[script].split(":")
    monkeypatch.setattr(sys, "argv", [script, "completion", "bash"])
    assert getattr(import_module(entry), function)() == 0
    assert f"-F _shtab_{script.replace('-', '_')} {script}\n" in capsys.readouterr().out


@pytest.mark.parametrize("package", ["lexis", "sim"])
def test_a_package_is_a_program(package):
    done = subprocess.run([sys.executable, "-m", package, "--help"], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.startswith("usage: lexis")
