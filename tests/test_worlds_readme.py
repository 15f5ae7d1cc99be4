"""worlds/README.md, executed word by word: its files are saved, and its commands and programs run."""

import subprocess
import sys
from pathlib import Path

from helpers.documentation import blocks

from sim.cli import main
from worlds.labels import ROOM_LABELS


def test_everything_in_the_documentation_works(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    programs = []
    for block in blocks("worlds/README.md"):
        if block.language == "python":
            programs.append(block.content)
        elif block.language == "sh":
            for program, *arguments in block.commands:
                assert program == "lexis-sim" and main(arguments) == 0, (arguments, capsys.readouterr())
        else:
            (tmp_path / block.file_name).write_text(block.content)
    # They share one separate process, because they add furniture to the catalogue.
    done = subprocess.run([sys.executable, "-c", "\n".join(programs)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert len(programs) == 3 and all(path.stat().st_size for path in tmp_path.iterdir())


def test_the_documentation_lists_all_labels():
    text = " ".join(Path("worlds/README.md").read_text(encoding="utf-8").split())
    assert f"Labels: {', '.join(ROOM_LABELS[:-1])}" in text and ROOM_LABELS[-1] in text
