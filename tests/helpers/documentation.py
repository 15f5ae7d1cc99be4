"""The code blocks of a README, in the order in which a reader meets them.

Blocks of `sh` contain commands of this project and its set-up. Blocks of `bash` are for other systems and are not run.
"""

import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
SET_UP = ("python3", "source", ".nox/env/bin/pytest", "nox", "pip")
"""Commands that install the project or run all tests. Continuous integration runs them; a test cannot."""
CONSOLE_SCRIPTS = {"lexis": "lexis.cli", "lexis-sim": "sim.cli"}
_FENCED = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_FILE_NAME = re.compile(r"`([\w-]+\.(?:json|svg|geojson))`")


class Block(NamedTuple):
    """A fenced code block."""

    language: str
    content: str
    before: str
    """The text of the README before the block."""

    @property
    def file_name(self):
        """The file name under which the text before the block asks the reader to save it."""
        return _FILE_NAME.findall(self.before)[-1]

    @property
    def commands(self):
        """The console commands of a shell block, each as a list of words, without the set-up commands."""
        lines = self.content.replace("\\\n", " ").splitlines()
        found = [shlex.split(line, comments=True) for line in lines]
        return [words for words in found if words and words[0] not in SET_UP]


def blocks(readme):
    """All fenced code blocks of a README; `readme` is its path from the root of the repository."""
    text = (ROOT / readme).read_text()
    return [Block(*match.groups(), text[: match.start()]) for match in _FENCED.finditer(text)]


def run_command(words, folder):
    """Run a console command in a separate process and assert that it succeeds."""
    program, *arguments = words
    command = [sys.executable, "-m", CONSOLE_SCRIPTS[program], *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, f"{shlex.join(words)}\n{done.stdout}{done.stderr}"


def run_python(path, folder):
    """Run a snippet as a reader would (a test with pytest, anything else as a program) and assert that it succeeds."""
    is_test = path.name.startswith("test_")
    command = ["-m", "pytest", "-q", "-p", "no:cacheprovider", str(path)] if is_test else [str(path)]
    done = subprocess.run([sys.executable, *command], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, f"{path.read_text()}\n{done.stdout}{done.stderr}"
