"""All commands of both console scripts: the examples in the help can be parsed; bad input gives one line and status 2."""

import argparse
import re
import shlex

import pytest

from lexis import cli as lexis_cli
from lexis.command_line import Parser
from sim import cli as sim_cli

CONSOLES = {"lexis": lexis_cli, "lexis-sim": sim_cli}
ROOTS = {name: console.parser() for name, console in CONSOLES.items()}


def tree(parser):
    """The parser and all parsers of subcommands below it."""
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                yield from tree(below)


def examples(parser):
    """The command lines in the help of a parser, without pipes and redirections."""
    shown = re.split("^examples?:\n", parser.epilog, flags=re.MULTILINE)[1].split("\n\n")[0]
    return [shlex.split(line.split(" > ")[0]) for line in shown.splitlines()]


def main(argv):
    try:
        return CONSOLES[argv[0]].main(argv[1:])
    except SystemExit as end:
        return end.code


PARSERS = [parser for root in ROOTS.values() for parser in tree(root)]
LEAVES = [parser for parser in PARSERS if parser.get_default("command")]
each_parser = pytest.mark.parametrize("parser", PARSERS, ids=lambda parser: parser.prog)
each_leaf = pytest.mark.parametrize("parser", LEAVES, ids=lambda parser: parser.prog)


def test_a_parser_either_runs_a_command_or_chooses_one():
    assert len(LEAVES) > 20
    for parser in PARSERS:
        chooses = any(isinstance(action, argparse._SubParsersAction) for action in parser._actions)
        assert isinstance(parser, Parser) and chooses != (parser in LEAVES), parser.prog


@each_parser
def test_examples_begin_with_the_command_and_are_understood(parser):
    lines = examples(parser)
    assert " ".join(lines[0]).startswith(parser.prog)
    for console, *words in lines:
        understood = ROOTS[console].parse_args(words)
        assert callable(understood.command)
    assert parser not in LEAVES or ROOTS[lines[0][0]].parse_args(lines[0][1:]).command == parser.get_default("command")


@each_parser
def test_options_say_what_they_mean(parser):
    assert not [action.option_strings for action in parser._actions if action.option_strings and not action.help]


@each_parser
def test_help_ends_well(parser, capsys):
    assert main([*parser.prog.split(), "--help"]) == 0
    assert capsys.readouterr().out.startswith(f"usage: {parser.prog}")


@each_leaf
def test_an_option_of_no_command_is_refused_in_a_line_that_names_the_command(parser, capsys):
    assert main([*examples(parser)[0], "--no-such-option"]) == 2
    printed = capsys.readouterr()
    wanted = f"{parser.prog}: unrecognized arguments: --no-such-option; see {parser.prog} --help\n"
    assert (printed.out, printed.err) == ("", wanted)


@pytest.mark.parametrize(
    "parser",
    [leaf for leaf in LEAVES if any(not action.option_strings and action.choices is None for action in leaf._actions)],
    ids=lambda parser: parser.prog,
)
def test_what_is_to_be_read_and_is_not_there_costs_one_line(parser, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(examples(parser)[0]) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and printed.err.count("\n") == 1 and not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (["sessions", "--every", "0"], "--every: '0'; valid: a number from 0.1 to 100000"),
        (["scale", "--length", "-1"], "--length: '-1'; valid: a number from 1 to 1e+06"),
        (["encoders", "--seed", "900000"], "--seed 900000 with --houses 5: their sum is too large; valid: at most "),
        (
            ["kernels", "--plot", "kernels.csv"],
            "kernels.csv: cannot be written in this format; valid: a name that ends in .png or .svg",
        ),
        (["all", "-o", "tables", "--pose-graphs", "missing.g2o"], "--pose-graphs: no file missing.g2o; valid: g2o files"),
        (
            ["all", "-o", "/proc/tables"],
            "/proc/tables: cannot be written: No such file or directory; valid: a folder",
        ),
    ],
)
def test_a_benchmark_refuses_bad_values_before_it_begins(command, said, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["lexis-sim", "bench", *command]) == 2
    assert said in capsys.readouterr().err and not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("benchmark", "option"),
    [
        ("speed", ["--encoder", "mini"]),
        ("speed", ["--pictures", "drives"]),
        ("segmentation", ["--worst", "3"]),
        ("fidelity", ["--preset", "home"]),
        ("kernels", ["--fidelity", "features"]),
        ("encoders", ["--pictures", "drives"]),
    ],
)
def test_a_benchmark_refuses_the_options_of_another(benchmark, option, capsys):
    assert main(["lexis-sim", "bench", benchmark, *option]) == 2
    refusal = f"lexis-sim bench {benchmark}: unrecognized arguments: {' '.join(option)}; see"
    assert capsys.readouterr().err.startswith(refusal)


@pytest.mark.parametrize(
    ("benchmark", "option", "valid"),
    [
        ("openness", ["--presets", "ori"], "--preset with one value"),
        ("openness", ["--presets=ori"], "--preset with one value"),
        ("table2", ["--preset", "ori"], "--presets with one value or more"),
        ("table2", ["--house", "3"], "--houses with one value"),
        ("openness", ["--fit", "--presets", "ori"], "--preset with one value"),
    ],
)
def test_an_option_in_the_other_grammatical_number_is_answered_with_the_right_one(benchmark, option, valid, capsys):
    assert main(["lexis-sim", "bench", benchmark, *option]) == 2
    refusal = f"lexis-sim bench {benchmark}: unrecognized arguments: {' '.join(option)}; valid: {valid}; see"
    assert capsys.readouterr().err.startswith(refusal)


@pytest.mark.parametrize("blocked", ["taken", "taken/below"])
def test_pictures_do_not_go_where_a_file_is(blocked, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "taken").write_text("a file")
    assert main(["lexis-sim", "bench", "planning", "--pictures", blocked]) == 2
    said = capsys.readouterr().err
    assert "taken: is a file; valid: the name of a folder" in said and said.count("\n") == 1
