"""All pages of the documentation: their commands parse, their programs run, their links lead somewhere.

worlds/README.md has a test of its own, test_worlds_readme.py, which runs every time.
"""

import ast
import re
from typing import get_args, get_type_hints

import pytest
from helpers.documentation import (
    CONSOLE_SCRIPTS,
    NEEDS_WEIGHTS,
    PAGES,
    ROOT,
    anchors,
    blocks,
    links,
    run_command,
    run_python,
    tables,
)

from lexis.cli import parser as lexis_parser
from lexis.config import PlaceRecognitionConfig, SegmentationConfig
from sim.cli import parser as sim_parser
from sim.faults import FAULTS
from sim.odometry.config import ODOMETRY_PRESETS
from sim.suites.catalogue import SUITES
from sim.tours.config import TOUR_KINDS
from worlds.presets import PRESETS

PARSERS = {"lexis": lexis_parser, "lexis-sim": sim_parser}
SHELL = [
    (page, words)
    for page in PAGES
    for block in blocks(page)
    if block.language in ("sh", "console")
    for words in block.commands
]
PYTHON = [(page, block.content) for page in PAGES for block in blocks(page) if block.language == "python"]
LINKS = [(page, *target) for page in PAGES for target in links(page)]
FOLLOWED = [
    page
    for page in PAGES
    if page != "worlds/README.md"
    and any(b.language == "python" or (b.language == "sh" and b.commands) for b in blocks(page))
]
"""Pages with something to run."""


def test_the_pages_have_commands_programs_and_links():
    assert {words[0] for _, words in SHELL} == set(CONSOLE_SCRIPTS)
    assert len(PYTHON) >= 7
    assert {"README.md", "sim/README.md", "sim/pages/runs.md", "lexis/pages/maps.md"} <= set(FOLLOWED)
    assert {page for page, *_ in LINKS} >= {"README.md", "sim/pages/results.md"}


@pytest.mark.parametrize(
    ("page", "names"),
    [
        ("sim/pages/runs.md", (*FAULTS, *ODOMETRY_PRESETS, *TOUR_KINDS)),
        ("sim/pages/suites.md", SUITES),
        ("sim/pages/pytest.md", PRESETS),
        ("lexis/pages/places.md", get_args(get_type_hints(PlaceRecognitionConfig)["method"])),
        ("lexis/pages/rooms.md", get_args(get_type_hints(SegmentationConfig)["method"])),
    ],
)
def test_every_name_that_can_be_chosen_is_on_its_page(page, names):
    shown = re.findall(r"`([^`\n]+)`", (ROOT / page).read_text(encoding="utf-8"))
    assert len(names) > 1
    assert [name for name in names if not any(re.search(rf"\b{re.escape(name)}\b", code) for code in shown)] == []


@pytest.mark.parametrize(("page", "words"), SHELL, ids=[" ".join([page, *words]) for page, words in SHELL])
def test_every_command_is_one_that_its_program_understands(page, words):
    program, *arguments = words
    PARSERS[program]().parse_args(arguments)


@pytest.mark.parametrize(("page", "content"), PYTHON)
def test_every_program_imports_what_there_is(page, content):
    imports = [node for node in ast.parse(content).body if isinstance(node, ast.Import | ast.ImportFrom)]
    exec(compile(ast.Module(imports, []), page, "exec"), {})


@pytest.mark.parametrize(("page", "path", "anchor"), LINKS)
def test_every_relative_link_leads_to_a_file_and_to_a_heading_in_it(page, path, anchor):
    target = (ROOT / page).parent / path if path else ROOT / page
    assert target.resolve().is_relative_to(ROOT) and target.exists()
    assert not anchor or anchor in anchors(target)


@pytest.mark.parametrize("page", PAGES)
def test_every_row_of_a_table_has_as_many_cells_as_its_heading(page):
    for heading, *rows in tables((ROOT / page).read_text()):
        assert [row for row in rows if len(row) != len(heading)] == []


def test_a_row_with_too_few_or_too_many_cells_is_found():
    found = tables("| a | `b|c` |\n|---|---|\n| 1 | 2 | 3 |\n\n| a\\|b |\n")
    assert [[len(row) for row in table] for table in found] == [[2, 2, 3], [1]]


@pytest.mark.slow
@pytest.mark.parametrize("page", FOLLOWED)
def test_everything_in_the_documentation_works(page, tmp_path):
    for number, block in enumerate(blocks(page)):
        if block.language == "sh":
            if "nox -s demo" in block.content:
                run_command(["lexis-sim", "demo"], tmp_path)  # the command that this session runs
            for words in block.commands:
                if not any(word.startswith(NEEDS_WEIGHTS) for word in words):
                    run_command(words, tmp_path)
        elif block.language == "python":
            path = tmp_path / f"{'test' if block.is_test else 'program'}_{number}.py"
            path.write_text(block.content)
            run_python(path, tmp_path)
