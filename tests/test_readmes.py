"""README.md and sim/README.md are executed word by word: their commands and programs run in order.

worlds/README.md has a separate test, which is part of every test run.
"""

import ast

import pytest
from helpers.documentation import CONSOLE_SCRIPTS, blocks, run_command, run_python

from lexis.cli import parser as lexis_parser
from sim.cli import parser as sim_parser

READMES = ("README.md", "sim/README.md")
PARSERS = {"lexis": lexis_parser, "lexis-sim": sim_parser}
NEEDS_WEIGHTS = ("ViT-", "hf-hub:", "local-dir:")
"""Words of commands that need weights which are not available here; only the arguments of these commands are checked."""
SHELL = [
    (readme, words) for readme in READMES for block in blocks(readme) if block.language == "sh" for words in block.commands
]
PYTHON = [block.content for readme in READMES for block in blocks(readme) if block.language == "python"]


def test_the_readmes_have_commands_and_programs_of_both_kinds():
    assert {words[0] for _, words in SHELL} == set(CONSOLE_SCRIPTS)
    assert len(PYTHON) >= 4


@pytest.mark.parametrize("words", [words for _, words in SHELL], ids=" ".join)
def test_every_command_is_one_that_its_program_understands(words):
    program, *arguments = words
    PARSERS[program]().parse_args(arguments)


@pytest.mark.parametrize("content", PYTHON)
def test_every_program_imports_what_there_is(content):
    imports = [node for node in ast.parse(content).body if isinstance(node, ast.Import | ast.ImportFrom)]
    exec(compile(ast.Module(imports, []), "README", "exec"), {})


@pytest.mark.slow
@pytest.mark.parametrize("readme", READMES)
def test_everything_in_the_documentation_works(readme, tmp_path):
    for number, block in enumerate(blocks(readme)):
        if block.language == "sh":
            if "nox -s demo" in block.content:
                run_command(["lexis-sim", "demo"], tmp_path)  # the command that this session runs
            for words in block.commands:
                if not any(word.startswith(NEEDS_WEIGHTS) for word in words):
                    run_command(words, tmp_path)
        elif block.language == "python":
            path = tmp_path / f"{'test' if 'def test_' in block.content else 'program'}_{number}.py"
            path.write_text(block.content)
            run_python(path, tmp_path)
