"""The commands of feature fidelity: bad input gives one line."""

import pytest
from helpers.command_line import status_of


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
