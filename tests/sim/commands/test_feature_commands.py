"""The commands of feature fidelity: bad input gives one line, and a fitted model can be read."""

import pytest
from helpers.command_line import status_of

from lexis.encoder.open_clip_encoder import load_encoder
from sim.feature_fitting import fit
from sim.feature_sensor.model import load_features


@pytest.mark.slow
def test_fit_features_writes_a_model_of_the_encoder(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(fit, "WALKS", fit.WALKS[:1])
    file = tmp_path / "mini.npz"
    assert status_of(["fit-features", "--houses", "2", "--out", file]) == 0
    model = load_features(file)
    model.check(load_encoder("mini"), str(file))
    assert f"loops: {len(model.loops.true_edges.inliers)} true and" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("argv", "hint"),
    [
        (["run", "--encoder", "oracle"], "valid: with fidelity 'features'"),
        (["run", "--fidelity", "features", "--fault", "blur"], "valid: with fidelity 'render'"),
        (["run", "--fidelity", "features", "--feature-model", "missing.npz"], "missing.npz: no feature model there"),
        (["run", "--feature-model", "missing.npz"], "missing.npz has no effect on images; valid: with --fidelity features"),
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
