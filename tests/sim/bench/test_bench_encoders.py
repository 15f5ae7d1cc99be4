"""bench encoders: figures of an encoder with known abilities, and the tables made of them."""

import csv
import zlib
from dataclasses import replace

import numpy as np
import pytest
from helpers.painted_runs import painted, painted_run

from lexis.encoder.prompts import prompts
from lexis.errors import EncoderError
from sim.baselines.places.descriptors import strongest_orb
from sim.baselines.places.word_tree import WordTree
from sim.bench.encoders import times as encoder_times
from sim.bench.encoders.ceiling import by_own_room, ceiling_of, own_room, own_room_prevails
from sim.bench.encoders.measure import References, measure, overall_calibration_error, worst_names
from sim.bench.encoders.retrieval import found_at_1
from sim.bench.encoders.table import RANDOM, TRAINED, Accuracy, TableRow, draw_plot, write_csv
from sim.bench.encoders.times import Timing, example_image, random_weights, timed
from sim.cli import main
from sim.errors import SimError
from sim.training.array_cache import cached_arrays
from sim.training.frames import frames_origin
from sim.training.phrases import HELD_OUT_NAMES, ROOM_ACTIVITIES, ROOM_NAMES
from sim.training.viewpoints import LEXIS_VIEWS, TRAINING_VIEWS
from worlds.labels import ROOM_LABELS

RUNS = [painted_run(900_004), painted_run(900_005)]
ROOMS = np.repeat([0, 3, 5, 7], 6)


class Knowing:
    """Reads the room from the pixels, and knows only the trained names and activities."""

    def __init__(self, temperature):
        self.temperature = temperature
        self._known = {name: i for i, label in enumerate(ROOM_LABELS) for name in ROOM_NAMES[label]}
        self._known |= {done: i for i, label in enumerate(ROOM_LABELS) for done in ROOM_ACTIVITIES[label]}

    def encode_images(self, images):
        return np.eye(len(ROOM_LABELS), dtype=np.float32)[images[:, 0, 0, 0]]

    def encode_texts(self, texts):
        said = [max((name for name in self._known if name in text), key=len, default=None) for text in texts]
        return np.array(
            [self._noise(t) if s is None else self._one(self._known[s]) for s, t in zip(said, texts, strict=True)]
        )

    def encode_rooms(self, names):
        known = [name in self._known for name in names]
        return np.array(
            [self._one(self._known[n]) if k else self._noise(prompts(n)[0]) for n, k in zip(names, known, strict=True)]
        )

    def _one(self, i):
        return np.eye(len(ROOM_LABELS), dtype=np.float32)[i]

    def _noise(self, text):
        return np.random.default_rng(zlib.crc32(text.encode())).normal(size=len(ROOM_LABELS)).astype(np.float32)


def measured(*encoders):
    return list(zip(*measure(encoders, RUNS, References()), strict=True))


def test_what_an_encoder_knows_counts_and_what_it_does_not_know_is_chance():
    (houses,) = measured(Knowing(0.1))
    assert [house.seed for house in houses] == [run.draw.seed for run in RUNS]
    for house in houses:
        row = house.row
        assert row.accuracy == row.trained_names == row.activities == row.trained_looks == row.held_out_looks == 1.0
        assert row.held_out_names < 0.7 and row.held_out_questions < 0.7
        assert row.ceiling is None and row.recall_orb is None
        assert row.calibration_error < 1e-3
        assert row.recall is not None and row.recall < 1.0  # the room can be recognised, but not the place within it


def test_orb_words_find_a_revisit_by_the_words_that_images_share(rng):
    coarse = rng.integers(0, 256, (len(RUNS[0].frames.images), 12, 16, 3), np.uint8)
    run = replace(RUNS[0], frames=replace(RUNS[0].frames, images=coarse.repeat(8, axis=1).repeat(8, axis=2)))
    descriptors = [strongest_orb(image) for image in run.frames.images]
    tree = WordTree.learned(descriptors, rng, depth=2)
    words = tree.histograms(descriptors)
    shared = np.minimum(words[:, None], words[None]).sum(axis=2)
    found = References(orb=tree).of(run).found["recall_orb"]
    assert 0 < found.sum() < len(found)
    np.testing.assert_array_equal(found, found_at_1(shared, run.T_W_B, run.stamps))


def test_low_confidence_in_correct_labels_is_a_calibration_error():
    sure, doubting = measured(Knowing(0.1), Knowing(10.0))
    assert [house.row.accuracy for house in doubting] == [1.0, 1.0]
    assert overall_calibration_error(doubting) > 0.6 > 1e-3 > overall_calibration_error(sure)


class Opposed(Knowing):
    """Takes one held-out name of a label for the label itself, and another one for its opposite."""

    def __init__(self, label):
        super().__init__(0.1)
        self._label, (self.good, self.bad) = ROOM_LABELS.index(label), HELD_OUT_NAMES[label][:2]

    def encode_rooms(self, names):
        sign = {self.good: 1.0, self.bad: -1.0}
        said = super().encode_rooms(names)
        return np.array([sign[n] * self._one(self._label) if n in sign else row for n, row in zip(names, said, strict=True)])


def test_a_name_costs_the_frames_that_it_loses():
    label = ROOM_LABELS[RUNS[0].frames.rooms[0]]
    encoder = Opposed(label)
    (houses,) = measured(encoder)
    found = {(room, name): loss for room, name, loss in worst_names(houses)}
    shares = [np.mean(run.frames.rooms == ROOM_LABELS.index(label)) for run in RUNS]
    assert (label, encoder.good) not in found
    assert found[label, encoder.bad] == pytest.approx(np.mean([share for share in shares if share > 0.0]))
    assert list(found.values()) == sorted(found.values(), reverse=True)


def test_the_ceiling_is_what_visible_things_tell(tmp_path):
    pytest.importorskip("sklearn")
    with pytest.raises(SimError, match="no frames"):
        ceiling_of(tmp_path)
    rng = np.random.default_rng(0)
    frames = painted(np.repeat(ROOMS, 5), rng)
    cached_arrays(tmp_path / "frames" / "a.npz", (frames_origin(TRAINING_VIEWS), "a house"), lambda: frames.arrays)
    assert (ceiling_of(tmp_path)(painted(ROOMS, rng)) == ROOMS).all()
    cached_arrays(tmp_path / "frames" / "b.npz", (frames_origin(LEXIS_VIEWS), "a house"), lambda: frames.arrays)
    with pytest.raises(SimError, match=r"b\.npz: made from other"):
        ceiling_of(tmp_path)


def test_bands_of_the_own_room_share_out_all_frames():
    rng = np.random.default_rng(1)
    own, right, ceiling = rng.random(500), rng.random(500) < 0.7, rng.random(500) < 0.5
    own[:2] = 0.0, 1.0
    answers = {"right": right, "ceiling": ceiling}
    *bands, all_frames = by_own_room(own, answers)
    assert sum(band.share for band in bands) == pytest.approx(all_frames.share) == 1.0
    for name, each in answers.items():
        assert sum(band.share * band.right[name] for band in bands) == pytest.approx(all_frames.right[name])
        assert all_frames.right[name] == each.mean()


def test_a_room_prevails_that_fills_half_of_the_image_and_none_that_another_fills_more_of():
    frames = painted(np.repeat(ROOMS, 20), np.random.default_rng(2))
    views = np.random.default_rng(3).dirichlet(np.full(len(ROOM_LABELS), 0.2), len(frames.rooms)).astype(np.float32)
    seen = replace(frames, views=views)
    own, prevails = own_room(seen), own_room_prevails(seen)
    assert prevails[own > 0.5].all() and (own > 0.5).any()
    assert np.array_equal(prevails, views.argmax(axis=1) == frames.rooms)


ROWS = (
    TableRow("mini", TRAINED, {"home": Accuracy((0.8, 0.9))}, {"cpu": Timing(9.0, 3.0, 0.3), "gpu": "no GPU"}),
    TableRow("RN50", RANDOM, {}, {"cpu": Timing(100.0, 60.0, 1.5), "gpu": "no GPU"}),
)


def test_the_table_of_random_weights_has_times_and_no_accuracy(tmp_path):
    write_csv(ROWS, tmp_path / "table.csv")
    with (tmp_path / "table.csv").open(newline="") as file:
        mini, random = csv.DictReader(file)
    assert float(mini["home accuracy mean"]) == pytest.approx(0.85)
    assert float(mini["home accuracy std"]) == pytest.approx(np.std([0.8, 0.9]), abs=1e-4)
    assert random["weights"] == RANDOM and random["home accuracy mean"] == ""
    assert float(random["cpu image_ms"]) == 100.0 and random["gpu image_ms"] == mini["gpu image_ms"] == ""


def test_the_plot_is_a_picture(tmp_path):
    pytest.importorskip("matplotlib")
    draw_plot(ROWS, tmp_path / "plot.png")
    assert (tmp_path / "plot.png").read_bytes().startswith(b"\x89PNG")


def test_an_architecture_is_timed_with_random_weights_that_leave_nothing_behind(monkeypatch):
    monkeypatch.setattr(encoder_times, "_TIMES", 1)
    with random_weights("ViT-S-32-alt") as model:
        found = timed(model, "cpu", example_image())
    assert isinstance(found, Timing) and found.image_ms > 0.0 and found.text_ms > 0.0 and found.loading_s > 0.0
    assert "no checkpoint" in timed(model, "cpu", example_image())
    with pytest.raises(EncoderError, match="no architecture 'ViT-Z'"), random_weights("ViT-Z"):
        pass


def test_an_architecture_that_cannot_be_made_costs_its_own_row_alone(tmp_path, capsys, monkeypatch):
    def unreachable(*_, **__):
        raise OSError("no network\nto fetch a tokenizer from")

    monkeypatch.setattr("open_clip.create_model", unreachable)
    monkeypatch.setattr("lexis.encoder.open_clip_encoder.load_encoder", lambda model: Knowing(0.1))
    monkeypatch.setattr("sim.bench.encoders.runs.encoder_runs", lambda *_: RUNS)
    monkeypatch.setattr("sim.bench.peers.place_methods.word_tree", lambda levels: None)
    monkeypatch.setattr(encoder_times, "timed", lambda model, way, image: Timing(1.0, 2.0, 3.0))
    csv_file, plot = tmp_path / "table.csv", tmp_path / "plot.png"
    asked = ["--presets", "uh2-apt", "--architectures", "roberta-ViT-B-32", "--csv", str(csv_file), "--plot", str(plot)]
    assert main(["bench", "encoders", *asked]) == 0
    shown = capsys.readouterr().out
    assert "no network" in shown and plot.exists() and "…" not in shown  # no header or figure is cut off
    with csv_file.open(newline="") as file:
        mini, failed = csv.DictReader(file)
    assert float(mini["uh2-apt accuracy mean"]) == 1.0 and float(mini["cpu image_ms"]) == 1.0
    assert (failed["encoder"], failed["weights"], failed["cpu image_ms"]) == ("roberta-ViT-B-32", RANDOM, "")


def test_what_cannot_be_written_or_timed_is_said_before_anything_is_measured(tmp_path, capsys):
    for options in (["--csv", str(tmp_path / "none" / "a.csv")], ["--architectures", "ViT-Z"]):
        assert main(["bench", "encoders", "--houses", "1", *options]) == 2
        assert len(capsys.readouterr().err.splitlines()) == 1
