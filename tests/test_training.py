"""The encoder's training: frames tell the truth, captions hold out what they should, training learns and resumes."""

import numpy as np
import open_clip
import pytest
import torch
from safetensors.torch import load_file

from lexis.encoder import MINI_CONFIG
from sim.training.frames import OBJECT_KINDS, TRAINING_SEEDS, Frames, _draw_houses, frames_of_house
from sim.training.phrases import HELD_OUT_NAMES, ROOM_NAMES, TEMPLATES, room_caption
from sim.training.train import Progress, TrainingConfig, export, train
from worlds.labels import ROOM_LABELS


@pytest.fixture(scope="module")
def frames():
    return frames_of_house(("uh2-apt", TRAINING_SEEDS[0]))


def test_training_stays_on_its_own_seeds():
    seeds = [seed for _, seed in _draw_houses(200, seed=0)]
    assert min(seeds) >= 100_000 and max(seeds) < 1_000_000 and len(set(seeds)) == 200


def test_frames_show_the_rooms_and_objects_of_the_house(frames):
    labels = {ROOM_LABELS[k] for k in frames.rooms}
    assert {"dining room", "living room", "bedroom", "bathroom", "stairs"} <= labels
    assert frames.images.shape[1:] == (96, 128, 3) and (frames.shares.sum(axis=1) <= 1.0 + 1e-6).all()
    in_bedroom = frames.rooms == ROOM_LABELS.index("bedroom")
    bed = frames.shares[:, OBJECT_KINDS.index("double bed")]
    assert bed[in_bedroom].mean() > 10 * bed[~in_bedroom].mean()


def test_frames_are_the_same_each_time(frames):
    again = frames_of_house(("uh2-apt", TRAINING_SEEDS[0]))
    assert np.array_equal(again.images, frames.images) and np.array_equal(again.shares, frames.shares)


def test_held_out_names_are_never_trained_on():
    trained = {name for names in ROOM_NAMES.values() for name in names}
    assert not trained & set(HELD_OUT_NAMES.values()) and set(ROOM_NAMES) == set(ROOM_LABELS)
    rng = np.random.default_rng(0)
    captions = {room_caption(label, rng) for label in ROOM_LABELS for _ in range(40)}
    assert len(captions) > len(ROOM_LABELS) * len(TEMPLATES) / 2


def test_training_learns_and_resumes_to_the_same_weights(frames, tmp_path):
    torch.set_num_threads(1)
    half = Frames(frames.images[::2], frames.rooms[::2], frames.shares[::2])
    config = TrainingConfig(epochs=5, batch=16, learning_rate=3e-3)
    straight: list[Progress] = []
    whole = train(half, frames, config, straight.append)
    assert straight[-1].loss < 0.75 * straight[0].loss

    class StoppedError(Exception):
        pass

    def stop_after_three(progress):
        if progress.epoch == 4:
            raise StoppedError

    with pytest.raises(StoppedError):
        train(half, frames, config, stop_after_three, tmp_path / "checkpoint.pt")
    resumed = train(half, frames, config, lambda progress: None, tmp_path / "checkpoint.pt")
    for name, value in whole.state_dict().items():
        assert torch.equal(value, resumed.state_dict()[name]), name
    export(resumed, tmp_path / "mini.safetensors")
    shipped = open_clip.create_model(MINI_CONFIG.stem)
    shipped.load_state_dict({name: value.float() for name, value in load_file(tmp_path / "mini.safetensors").items()})
