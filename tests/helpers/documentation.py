"""The code blocks of a README, to be done in the order in which a reader meets them.

Blocks of `sh` hold commands of this project and its set-up; blocks of `bash` hold those of other systems, which are not run.
"""

import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
SET_UP = ("python3", "source", ".nox/env/bin/pytest", "nox", "pip")
"""Commands that install the project or run all tests: continuous integration runs them, a test cannot."""
CONSOLE_SCRIPTS = {"lexis": "lexis.cli", "lexis-sim": "sim.cli"}
_FENCED = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_FILE_NAME = re.compile(r"`([\w-]+\.(?:json|svg|geojson))`")


class Block(NamedTuple):
    """A fenced code block."""

    language: str
    content: str
    before: str
    """The text above it."""

    @property
    def file_name(self):
        """The name that the text above asks the reader to save the block under."""
        return _FILE_NAME.findall(self.before)[-1]

    @property
    def commands(self):
        """The console commands of a shell block, as lists of words, with set-up left out."""
        lines = self.content.replace("\\\n", " ").splitlines()
        found = [shlex.split(line, comments=True) for line in lines]
        return [words for words in found if words and words[0] not in SET_UP]


def blocks(readme):
    """All fenced code blocks of a README, named from the top of the repository."""
    text = (ROOT / readme).read_text()
    return [Block(*match.groups(), text[: match.start()]) for match in _FENCED.finditer(text)]


def run_command(words, folder):
    """Run a console command in a process of its own and assert that it succeeds."""
    program, *arguments = words
    command = [sys.executable, "-m", CONSOLE_SCRIPTS[program], *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, f"{shlex.join(words)}\n{done.stdout}{done.stderr}"


def run_python(path, folder):
    """Run a snippet as its reader would, a test with pytest and all else as a program, and assert that it succeeds."""
    is_test = path.name.startswith("test_")
    command = ["-m", "pytest", "-q", "-p", "no:cacheprovider", str(path)] if is_test else [str(path)]
    done = subprocess.run([sys.executable, *command], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, f"{path.read_text()}\n{done.stdout}{done.stderr}"
