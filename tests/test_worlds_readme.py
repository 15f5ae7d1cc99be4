"""worlds/README.md, done word by word: its files are saved, its commands run, its programs executed."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

from sim.cli import main

README = Path(__file__).parents[1] / "worlds" / "README.md"
FENCED = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
FILE_NAME = re.compile(r"`([\w-]+\.(?:json|svg|geojson))`")


def test_everything_in_the_documentation_works(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text, programs = README.read_text(), []
    for block in FENCED.finditer(text):
        language, content = block.groups()
        if language == "python":
            programs.append(content)
        elif language == "sh":
            for line in content.splitlines():
                program, *arguments = shlex.split(line)
                assert program == "lexis-sim" and main(arguments) == 0, (line, capsys.readouterr())
        else:
            Path(FILE_NAME.findall(text[: block.start()])[-1]).write_text(content)
    # One process of their own, because they add furniture to the catalogue.
    done = subprocess.run([sys.executable, "-c", "\n".join(programs)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert len(programs) == 3 and all(path.stat().st_size for path in tmp_path.iterdir())
