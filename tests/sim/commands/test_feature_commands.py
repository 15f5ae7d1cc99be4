"""The commands of feature fidelity: bad input gives one line."""

import pytest

from sim.cli import main


def status_of(argv):
    try:
        return main(argv)
    except SystemExit as end:
        return end.code


@pytest.mark.parametrize(
    ("argv", "hint"),
    [
        (["run", "--encoder", "oracle"], "valid: with fidelity 'features'"),
        (["run", "--fidelity", "features", "--fault", "blur"], "valid: with fidelity 'render'"),
        (["run", "--fidelity", "features", "--feature-model", "missing.npz"], "missing.npz: no feature model there"),
        (["bench", "fidelity", "--encoder", "oracle"], "told the truth"),
        (["bench", "segmentation", "--encoder", "oracle", "--fidelity", "features"], "told the truth"),
        (["fit-features", "--encoder", "RN50"], "--out is missing"),
        (
            ["fit-features", "--out", "no/such/f.npz"],
            "no/such/f.npz: its folder does not exist; valid: a file in a folder that exists",
        ),
        (["fit-features", "--out", "."], ".: is a folder; valid: the name of a file"),
        (["fit-features", "--out", "/proc/f.npz"], "/proc/f.npz: cannot be written"),
        (["train-encoder", "--out", "."], ".: is a folder; valid: the name of a file"),
    ],
)
def test_bad_input(argv, hint, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sim.feature_fitting.fit.fit_features", lambda *_, **__: pytest.fail("rendered for nothing"))
    assert status_of(argv) == 2
    printed = capsys.readouterr()
    assert hint in printed.err and printed.err.count("\n") == 1 and printed.out == ""


def test_help_has_an_example(capsys):
    with pytest.raises(SystemExit, match="0"):
        main(["fit-features", "--help"])
    assert "  lexis-sim fit-features --encoder mini --out" in capsys.readouterr().out
