"""Training of the image tower: frames agree with the truth, houses stay separate, both stages learn, resume and export."""

import json
import pickle
from dataclasses import fields, replace
from functools import partial

import numpy as np
import open_clip
import pytest
import torch
from open_clip.transformer import TextTransformer
from rich.console import Console
from safetensors.torch import load_file

from lexis.encoder.open_clip_encoder import OpenClipEncoder, load_encoder
from lexis.encoder.preprocessing import squashing
from lexis.evaluation import calibration_error
from lexis.questions.calibration import load_calibration
from sim.cli import main
from sim.errors import SimError
from sim.training.align import AlignLearner, _search_loss, room_embeddings
from sim.training.batches import STRETCH, batches, chosen_once
from sim.training.command import TrainingRun, train_encoder
from sim.training.dense import DenseLearner, accuracy_among_present
from sim.training.export import model_config, start_trunk_from
from sim.training.fit import Progress, Schedule, fit
from sim.training.frames import BARE, THINGS, Frames, frames_at, frames_by_house, frames_of_house, rendered
from sim.training.houses import HELD_OUT_LOOKS, TEST_SEEDS, TRAINING_SEEDS, TUNING_SEEDS, HouseDraw, draw_houses
from sim.training.settling import settle
from sim.training.temperature import best_temperature
from sim.training.text_tower import EMBED_DIM, TEXT_CFG, DistilConfig, save_text_tower
from sim.training.viewpoints import IMAGE_SIZE, ViewpointConfig
from worlds.errors import WorldsError
from worlds.house import build_house
from worlds.labels import ROOM_LABELS
from worlds.presets import PRESETS, sample_house

HOUSE = HouseDraw("uh2-apt", TRAINING_SEEDS[0])


@pytest.fixture(scope="module")
def frames():
    return frames_of_house(HOUSE, ViewpointConfig(spacing_m=1.5))


@pytest.fixture(scope="module")
def text():
    torch.manual_seed(0)
    return TextTransformer(output_dim=EMBED_DIM, **TEXT_CFG).eval()


def test_houses_are_disjoint_and_leave_the_seeds_of_demos_and_acceptance_alone():
    draws = [list(draw_houses(300, seeds, np.random.default_rng(0))) for seeds in (TRAINING_SEEDS, TUNING_SEEDS, TEST_SEEDS)]
    seeds = [draw.seed for part in draws for draw in part]
    assert len(set(seeds)) == 900 and min(seeds) >= 100_000 and max(seeds) < 1_000_000
    assert {draw.preset for draw in draws[0]} == set(PRESETS)
    assert not {(draw.texture, draw.light) for part in draws for draw in part} & set(HELD_OUT_LOOKS)


def test_more_houses_begin_with_the_same_ones():
    few, many = (list(draw_houses(n, TRAINING_SEEDS, np.random.default_rng(3))) for n in (10, 40))
    assert many[:10] == few


def test_walls_that_cannot_be_opened_stay_as_they_are(monkeypatch):
    def closed(preset, seed, openness=None, clutter=1.0):
        if openness is not None:
            raise WorldsError("no wall can be opened")
        return sample_house(preset, seed, clutter=clutter)

    monkeypatch.setattr("sim.training.houses.sample_house", closed)
    assert HouseDraw("uh2-apt", 5, openness=1.0).spec() == HouseDraw("uh2-apt", 5).spec()


def test_frames_show_the_rooms_and_things_of_the_house(frames):
    labels = {ROOM_LABELS[k] for k in frames.rooms}
    assert {"dining room", "living room", "bedroom", "bathroom", "stairs"} <= labels
    assert frames.images.shape[1:] == (IMAGE_SIZE[1], IMAGE_SIZE[0], 3)
    in_bedroom = frames.rooms == ROOM_LABELS.index("bedroom")
    bed = frames.shares[:, THINGS.index("double bed")]
    assert bed[in_bedroom].mean() > 10 * bed[~in_bedroom].mean()


def test_what_is_in_view_adds_up(frames):
    n = len(frames.rooms)
    things = frames.shares.sum(axis=1)
    assert (frames.views.sum(axis=1) <= 1 + 1e-6).all() and (things <= frames.content + 0.05).all()
    own = frames.views[np.arange(n), frames.rooms]
    assert own.mean() > 0.5 and (frames.content >= frames.views.sum(axis=1) - own - 1e-6).all()
    assert 0 < np.mean(frames.content < BARE) < 0.3


def test_frames_are_the_same_each_time_and_are_kept(tmp_path):
    frames = frames_of_house(HOUSE)
    for again in (Frames.joined(list(rendered([HOUSE], tmp_path))) for _ in range(2)):  # first rendered, then loaded
        assert np.array_equal(frames.images, again.images) and np.array_equal(frames.things, again.things)
    (file,) = tmp_path.iterdir()
    for workers in (1, 2):
        with pytest.raises(SimError, match="delete its folder"):
            list(rendered([HOUSE._replace(light="dim")], tmp_path, workers))
    file.write_bytes(b"no frames")
    with pytest.raises(SimError, match="delete it"):
        list(rendered([HOUSE], tmp_path))


def test_a_house_that_is_never_entered_has_no_frames():
    none = frames_at(build_house(HOUSE.spec()), np.zeros((0, 4, 4)))
    assert {len(getattr(none, field.name)) for field in fields(Frames)} == {0}


def test_patches_move_with_the_image():
    """An object whose patch is also painted in the image is found where the image shows it, after mirroring and zooming."""
    n, things = 32, np.zeros((32, 3, 4, len(THINGS)), np.uint8)
    images = np.zeros((n, 96, 128, 3), np.uint8)
    rng = np.random.default_rng(0)
    for i, (row, column) in enumerate(rng.integers((3, 4), size=(n, 2))):
        things[i, row, column, 7] = 255
        images[i, row * 32 : row * 32 + 32, column * 32 : column * 32 + 32] = 255
    frames = _made_up(images, houses=np.arange(n), things=things)
    (batch,) = batches(frames, n, rng, torch.device("cpu"))
    bright = torch.nn.functional.avg_pool2d(batch.images.mean(dim=1, keepdim=True), 32).flatten(1).argmax(dim=1)
    assert (batch.patches[:, 7].flatten(1)[torch.arange(n), bright] == 1).float().mean() > 0.9
    assert batch.patches.sum() == batch.patches[:, 7].sum() and set(batch.things.sum(dim=1).tolist()) <= {0.0, 1.0}


def test_frames_of_a_house_are_mirrored_alike_and_lit_alike():
    images = np.zeros((32, 96, 128, 3), np.uint8)
    images[:, :, 64:] = 200
    houses = np.repeat(np.arange(8), 4)
    (batch,) = batches(_made_up(images, houses), 32, np.random.default_rng(0), torch.device("cpu"))
    left, right = batch.images[..., :8].mean(dim=(2, 3)).numpy(), batch.images[..., -8:].mean(dim=(2, 3)).numpy()
    for sides in (left, right):
        np.testing.assert_allclose(sides.reshape(8, 4, 3), np.repeat(sides[::4, None], 4, axis=1), atol=1e-3)
    assert 0 < (left > right)[:, 0].sum() < 32 and len(np.unique(left.round(3), axis=0)) == 8


def _made_up(images, houses, things=None):
    n = len(images)
    things = np.zeros((n, 3, 4, len(THINGS)), np.uint8) if things is None else things
    views, content = np.full((n, len(ROOM_LABELS)), 0.04, np.float32), np.ones(n, np.float32)
    return Frames(images, np.zeros(n, int), things, views, content, houses, np.tile(np.eye(4), (n, 1, 1)))


def test_batches_hold_stretches_of_walks_and_every_frame_at_most_once():
    houses = np.repeat([7, 3, 5], [90, 40, 110])
    chosen = list(chosen_once(houses, 32, np.random.default_rng(0)))
    assert [len(one) for one in chosen] == [32] * 7 and len(np.unique(np.concatenate(chosen))) == 224
    neighbours = [np.mean(np.diff(one) == 1) for one in chosen]
    assert np.mean(neighbours) > 0.95 * (1 - 1 / STRETCH)
    again, other = (list(chosen_once(houses, 32, np.random.default_rng(seed))) for seed in (0, 1))
    assert np.array_equal(chosen, again) and not np.array_equal(chosen, other)


class StoppedError(Exception):
    pass


@pytest.mark.parametrize("stage", ["dense", "align"])
def test_a_stage_learns_and_resumes_to_the_same_weights(frames, text, stage, tmp_path):
    torch.set_num_threads(1)
    some = frames[np.arange(0, len(frames.rooms), 6)]
    schedule = Schedule(epochs=3, learning_rate=3e-3, batch=6)

    def learner():
        dense = DenseLearner(some)
        return dense if stage == "dense" else AlignLearner(dense.module, text, some, wordings=(2, 1))

    whole, history = learner(), []
    fit(whole, some, some, schedule, history.append)
    assert history[-1].loss < 0.9 * history[0].loss

    def stop(progress: Progress) -> None:
        if progress.epoch == 2:
            raise StoppedError

    with pytest.raises(StoppedError):
        fit(learner(), some, some, schedule, stop, tmp_path / "checkpoint.pt")
    resumed = learner()
    fit(resumed, some, some, schedule, lambda progress: None, tmp_path / "checkpoint.pt")
    for name, value in whole.module.state_dict().items():
        assert torch.equal(value, resumed.module.state_dict()[name]), name


@pytest.mark.parametrize("content", [b"no checkpoint", pickle.dumps({"epoch": 1}), "other parts", "a tensor", "cut"])
def test_a_checkpoint_that_nothing_can_go_on_from_is_named_on_one_line(content, tmp_path):
    path = tmp_path / "dense.pt"
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        other = {"epoch": 1, "parts": [{"weight": torch.zeros(2)}] * 3}
        torch.save(torch.zeros(2) if content == "a tensor" else other, path)
        path.write_bytes(path.read_bytes()[: -200 if content == "cut" else None])
    frames = _made_up(np.zeros((8, 96, 128, 3), np.uint8), np.arange(8))
    with pytest.raises(SimError, match=r"dense\.pt: cannot resume from it.*delete it") as error:
        fit(DenseLearner(frames), frames, frames, Schedule(1, 1e-3, batch=8), print, path)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("name", ["settings.json", "text-tower.safetensors"])
@pytest.mark.parametrize("content", [b'{"seed": 0, "epo', b"\xff\x00", b"[1]", "a narrower tower"])
def test_what_is_damaged_in_the_work_folder_is_named_on_one_line(name, content, tmp_path):
    path = tmp_path / name
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        save_text_tower(TextTransformer(output_dim=EMBED_DIM, **{**TEXT_CFG, "width": 20}), path)
    with pytest.raises(SimError, match=f"{path}: no .*delete it") as error:
        train_encoder(TrainingRun(1, 1, work=tmp_path), Console(quiet=True))
    assert "\n" not in str(error.value)


def test_a_work_folder_is_of_one_run_whatever_workers_teacher_and_output(tmp_path):
    path = tmp_path / "text-tower.safetensors"
    path.write_bytes(b"damaged")  # the part after the settings
    run = TrainingRun(1, 1, work=tmp_path)
    for same in ({}, {"workers": 1}, {"teacher": tmp_path}, {"out": tmp_path / "b.safetensors"}):
        with pytest.raises(SimError, match="no text tower"):
            train_encoder(replace(run, **same), Console(quiet=True))
    other = {
        "houses": 2, "tuning_houses": 2, "epochs": (1, 1), "settling_houses": 3, "settling_steps": 1, "seed": 1, "batch": 64,
        "wordings": (2, 1), "start": tmp_path / "a.safetensors", "distillation": DistilConfig(epochs=1),
    }  # fmt: skip
    for name, value in other.items():
        with pytest.raises(
            SimError, match=rf"belongs to a run with {name} [^;]*; valid: the same settings, or another folder"
        ):
            train_encoder(replace(run, **{name: value}), Console(quiet=True))


def test_the_projection_settles_on_no_fewer_houses_than_the_tower_is_trained_on():
    with pytest.raises(SimError, match=r"settling_houses.*at least the number of houses to train on, 3"):
        TrainingRun(houses=3, settling_houses=2)


def test_a_batch_without_any_thing_costs_nothing_instead_of_spoiling_all_weights():
    logits = torch.randn(2, 3, requires_grad=True)
    for shown, is_zero in (([[0, 0, 0], [0, 0, 0]], True), ([[0, 1, 0], [0, 0, 0]], False)):
        loss = _search_loss(logits, torch.tensor(shown, dtype=torch.float32))
        (slope,) = torch.autograd.grad(loss, logits)
        assert torch.isfinite(slope).all() and (loss.item() == 0.0) == (not slope.any()) == is_zero


@pytest.mark.parametrize("name", ["mini", "mini.pt", "mini.json"])  # the last one is the file of the configuration
def test_weights_that_could_not_be_loaded_again_are_refused_before_the_work(name, tmp_path, capsys):
    assert main(["train-encoder", "--work", str(tmp_path / "work"), "--out", str(tmp_path / name)]) == 2
    assert "valid: a name that ends in .safetensors" in capsys.readouterr().err
    assert list(tmp_path.rglob("*")) == [tmp_path / "work"]


def test_weights_to_start_from_are_read_before_the_work(tmp_path):
    for start in (tmp_path / "none.safetensors", tmp_path):
        run = TrainingRun(1, 1, work=tmp_path / "work", start=start)
        with pytest.raises(SimError, match=f"{start}: no image tower to start from"):
            train_encoder(run, Console(quiet=True))
    assert list(run.work.iterdir()) == []  # another start may be given


def test_settling_finds_rooms_by_text_and_leaves_the_trunk_unchanged(frames, text):
    align = AlignLearner(DenseLearner(frames).module, text, frames, wordings=(2, 1))
    align.module.eval()
    dense = {name: value.clone() for name, value in align.module.dense.state_dict().items()}
    before = align.accuracy(frames)
    settle(align, [frames, frames[np.arange(0)]], seed=0, steps=1000)  # no tour is found in some houses
    assert align.accuracy(frames) > before + 0.2
    for name, value in align.module.dense.state_dict().items():
        assert torch.equal(value, dense[name]), name


def test_the_command_trains_resumes_and_writes_what_open_clip_loads(text, tmp_path, monkeypatch):
    few = ViewpointConfig(most=40)
    monkeypatch.setattr("sim.training.frames.TRAINING_VIEWS", few)
    monkeypatch.setattr("sim.training.frames.frames_of_house", partial(frames_of_house, views=few))
    monkeypatch.setattr("sim.training.random_questions._MOST", 10)
    work = tmp_path / "work"
    work.mkdir()
    save_text_tower(text, work / "text-tower.safetensors")
    (work / "frames").mkdir()
    tiny = {"epochs": (1, 1), "settling_steps": 700, "batch": 16, "wordings": (2, 1)}
    run = TrainingRun(1, 1, work=work, out=tmp_path / "mini.safetensors", workers=1, **tiny)
    history = train_encoder(run, Console(quiet=True))
    assert [(progress.stage, progress.epoch) for progress in history] == [("dense", 1), ("align", 1)]
    before = run.out.read_bytes()
    with monkeypatch.context() as patch:  # what is done is not done again
        patch.delattr("sim.training.settling._SeenFrames")
        assert train_encoder(run, Console(quiet=True)) == [] and run.out.read_bytes() == before
    with pytest.raises(SimError, match="another folder"):
        train_encoder(replace(run, epochs=(2, 1)), Console(quiet=True))
    assert json.loads((tmp_path / "mini.json").read_text()) == model_config()
    calibration = load_calibration(tmp_path / "mini.calibration.json")
    assert calibration.fingerprint == load_encoder(f"lexis-mini:{run.out}").fingerprint
    weights = {name: value.float() for name, value in load_file(run.out).items()}
    model = open_clip.CLIP(**model_config())
    model.load_state_dict(weights)
    tokenizer = open_clip.tokenizer.SimpleTokenizer(context_length=24)
    encoder = OpenClipEncoder("mini", model, tokenizer, squashing(IMAGE_SIZE[1], IMAGE_SIZE[0]))
    said = encoder.encode_rooms(["kitchen", "place to cook"])
    np.testing.assert_allclose(said, room_embeddings(text, ["kitchen", "place to cook"]), atol=0.02)
    seen = Frames.joined(list(frames_by_house(work / "frames")))
    untrained = AlignLearner(DenseLearner(seen).module.eval(), text, seen, wordings=(2, 1)).accuracy(seen)
    embedded = np.array([encoder.encode_image(image) for image in seen.images])
    assert accuracy_among_present(embedded @ encoder.encode_rooms(ROOM_LABELS).T, seen.rooms) > untrained + 0.1
    dense = DenseLearner(frames_of_house(HOUSE, ViewpointConfig(most=2))).module
    start_trunk_from(run.out, dense)
    torch.testing.assert_close(dense.trunk.state_dict()["stem.conv.weight"], weights["visual.trunk.stem.conv.weight"])
    with pytest.raises(SimError, match="no image tower"):
        start_trunk_from(work / "text-tower.safetensors", dense)


def test_the_fitted_temperature_is_the_one_that_answers_were_drawn_with():
    rng = np.random.default_rng(0)
    similarities = rng.normal(0.0, 0.1, (20_000, 6))
    odds = np.exp(similarities / 0.05)
    chance = odds / odds.sum(axis=1, keepdims=True)
    own = (rng.random((20_000, 1)) < chance.cumsum(axis=1)).argmax(axis=1)
    assert best_temperature(similarities, own) == pytest.approx(0.05, rel=0.05)
    confidence, right = chance.max(axis=1), chance.argmax(axis=1) == own
    assert calibration_error(confidence, right) < 0.02 < calibration_error(np.ones(20_000), right)
