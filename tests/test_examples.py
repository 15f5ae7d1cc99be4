"""The programs in tests/examples do what they show, and stay short enough to copy."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from examples import drawn_house, folder_of_images
from helpers.blind_encoder import BlindEncoder
from helpers.small_inputs import FRAMES, write_tum_run

from lexis import load_map

FOLDER = Path(__file__).parent / "examples"
EXAMPLES = sorted(FOLDER.glob("*.py"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_is_short_and_linked_from_the_readme(path):
    assert len(path.read_text().splitlines()) < 40
    assert f"(tests/examples/{path.name})" in (FOLDER.parents[1] / "README.md").read_text()


def test_own_furniture_stands_in_the_living_room_alone():
    """In a process of its own, because the example adds a kind to the catalogue."""
    done = subprocess.run([sys.executable, FOLDER / "own_furniture.py"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert [line.partition(" at ")[0] for line in done.stdout.splitlines()] == ["grand piano in living room 0.1"]


def test_the_drawn_house_is_walked_from_the_study_to_the_kitchen(capsys):
    path = drawn_house.main()
    (study, kitchen), last = path[[0, -1], :2], capsys.readouterr().out
    assert (study > [0, 3]).all() and (study < [4, 5]).all()
    assert (kitchen > 0).all() and (kitchen < [4, 3]).all()
    assert last.startswith(f"{np.linalg.norm(np.diff(path, axis=0), axis=1).sum():.1f} m")


def test_a_folder_of_images_becomes_a_map(tmp_path, monkeypatch, capsys):
    write_tum_run(tmp_path / "run")
    monkeypatch.setattr(folder_of_images, "load_encoder", lambda name: BlindEncoder())
    built = folder_of_images.main(tmp_path / "run")
    saved = load_map(tmp_path / "run-map")
    assert 1 <= len(saved.keyframes) <= FRAMES and len(saved.keyframes) == len(built.keyframes)
    assert len(capsys.readouterr().out.splitlines()) == len(built.rooms) >= 1
