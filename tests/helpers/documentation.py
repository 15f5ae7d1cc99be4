"""The code blocks, links and tables of the documentation, which consists of all Markdown files of this project.

The tag of a code block says what tests do with it. `sh` holds commands of this project and its set-up, which tests run in
the order of the page. `console` holds commands that take hours: tests check their arguments only. `bash` holds commands of
other systems, which no test runs.
"""

import re
import shlex
import subprocess
import sys
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    str(path.relative_to(ROOT))
    for pattern in ("*.md", "lexis/**/*.md", "sim/**/*.md", "worlds/**/*.md")
    for path in ROOT.glob(pattern)
)
"""All Markdown files, named from the top of the repository."""
SET_UP = {"python3", "source", "pytest", "nox", "pip"}
"""Programs that install the project or run all tests: continuous integration runs them, a test cannot."""
CONSOLE_SCRIPTS = {"lexis": "lexis.cli", "lexis-sim": "sim.cli"}
NEEDS_WEIGHTS = ("ViT-", "hf-hub:", "local-dir:")
"""Beginnings of words in commands that need downloaded weights; tests check only the arguments of these commands."""
_FENCED = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_FILE_NAME = re.compile(r"`([\w-]+\.(?:json|svg|geojson))`")
_LINK = re.compile(r"\]\(([^()\s]+)\)")
_HEADING = re.compile(r"^#+ +(.+)$", re.MULTILINE)


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
    def is_test(self):
        """Whether a block of Python is a test for pytest."""
        return "def test_" in self.content

    @property
    def commands(self):
        """The console commands of a shell block, each as a list of words, without the set-up commands."""
        lines = self.content.replace("\\\n", " ").splitlines()
        found = [shlex.split(line, comments=True) for line in lines]
        return [words for words in found if words and Path(words[0]).name not in SET_UP]


def blocks(page):
    """All fenced code blocks of a page."""
    text = (ROOT / page).read_text()
    return [Block(*match.groups(), text[: match.start()]) for match in _FENCED.finditer(text)]


def links(page):
    """The targets of all relative links and pictures of a page: pairs of a path from the page's folder and an anchor."""
    found = _LINK.findall(_FENCED.sub("", (ROOT / page).read_text()))
    return [tuple(target.partition("#")[::2]) for target in found if "://" not in target]


def tables(text):
    """The tables of a Markdown text: for each, its rows, the heading included, each as a list of cells.

    A vertical bar in a code span or after a backslash does not divide cells.
    """
    rows = re.sub(r"`[^`\n]*`", "code", _FENCED.sub("", text)).splitlines()
    return [
        [re.split(r"(?<!\\)\|", row.strip())[1:-1] for row in table]
        for is_table, table in groupby(rows, key=lambda row: row.startswith("|"))
        if is_table
    ]


def anchors(path):
    """The anchors of a Markdown file's headings, by the rule of GitHub."""
    headings = _HEADING.findall(_FENCED.sub("", path.read_text()))
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def run_command(words, folder):
    """Run a console command in a separate process and assert that it succeeds."""
    program, *arguments = words
    command = [sys.executable, "-m", CONSOLE_SCRIPTS[program], *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, f"{shlex.join(words)}\n{done.stdout}{done.stderr}"


def run_python(path, folder):
    """Run a snippet as a reader would (a test with pytest, anything else as a program) and assert that it succeeds."""
    is_test = path.name.startswith("test_")
    # The plugin is loaded by its module, since the installed metadata may be older than its entry point.
    plugin = ["-p", "no:lexis", "-p", "sim.pytest_plugin"]
    command = ["-m", "pytest", "-q", *plugin, "-p", "no:cacheprovider", str(path)] if is_test else [str(path)]
    done = subprocess.run([sys.executable, *command], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, f"{path.read_text()}\n{done.stdout}{done.stderr}"
