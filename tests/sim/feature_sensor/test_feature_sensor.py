"""Runs on simulated features: all of LEXIS without a single pixel, and without access to the truth."""

from dataclasses import fields, replace
from itertools import islice

import numpy as np
import pytest
from helpers.unchecked import unchecked

from lexis.config import Config, LabelConfig, SegmentationConfig
from lexis.encoder.open_clip_encoder import load_encoder
from lexis.errors import EncoderError
from lexis.map import load_map, relabel, save_map
from lexis.maths.se3 import inverse, transform
from lexis.types import Percept
from sim.errors import SimError
from sim.faults.delivery import Dropped, Frozen
from sim.faults.images import Blur, Smear
from sim.faults.world import ClosedDoors, MovedFurniture, Pedestrian
from sim.feature_sensor.covisibility_verifier import LoopModel, MeasuredEdges
from sim.feature_sensor.embedding import KERNELS, EmbeddingModel
from sim.feature_sensor.model import MINI_FEATURES, FeatureModel, fingerprint, load_features, save_features
from sim.feature_sensor.oracle import Oracle
from sim.feature_sensor.sensor import FeatureSensor
from sim.feature_sensor.surroundings import KINDS, survey
from sim.feature_sensor.true_view import true_views
from sim.feature_sensor.visible_shares import LABEL_WEIGHT, LABELS, SIZE, look
from sim.harness import Scenario, evaluate, run
from sim.harness.adapters import Lexis
from sim.harness.results import RoomFigures
from sim.harness.walk import walk
from sim.render.rig import build_rig
from sim.report.findings import rooms_without_keyframe
from sim.session import Session
from worlds.labels import ROOM_LABELS
from worlds.presets import sample_from_rooms

HOUSE = sample_from_rooms(("kitchen", "bedroom"), seed=21)
CONFIG = Scenario(house=HOUSE, seed=5, fidelity="features", frame_rate_hz=2.5, length_m=45.0)


class LabelEncoder:
    """Recognises nothing in images; encodes the labels of rooms as the dimensions of `fitted`."""

    name = fingerprint = "labels"

    def encode_image(self, image):
        return np.eye(len(ROOM_LABELS), dtype=np.float32)[int(image.mean()) % 3]

    def encode_rooms(self, names):
        return np.eye(len(ROOM_LABELS), dtype=np.float32)[[ROOM_LABELS.index(name) for name in names]]


@pytest.fixture(scope="module")
def fitted():
    """A model of an encoder that sees the typical contents of rooms with some error; most loops are found."""
    weights = np.zeros((SIZE, len(ROOM_LABELS)), np.float32)
    weights[LABELS] = np.eye(len(ROOM_LABELS)) / LABEL_WEIGHT
    errors = 0.05 * np.eye(len(ROOM_LABELS), dtype=np.float32)
    offset = np.full(len(ROOM_LABELS), 1e-3, np.float32)
    embedding = EmbeddingModel(weights, offset, errors, np.full(len(KERNELS), 1 / len(KERNELS)))
    edges = MeasuredEdges(
        np.full((3, 6), 0.005), np.repeat(np.eye(6)[None] * 1e-4, 3, axis=0), np.array([20, 30, 40]), np.full(3, 12)
    )
    nothing = MeasuredEdges(np.zeros((0, 6)), np.zeros((0, 6, 6)), np.zeros(0, int), np.zeros(0, int))
    loops = LoopModel(np.array([-3.0, 12.0, 0.0, -1.0, -1.0]), 0.5, 0.0, edges, nothing)
    return FeatureModel(fingerprint(LabelEncoder()), embedding, loops)


@pytest.fixture(scope="module")
def file(fitted, tmp_path_factory):
    path = tmp_path_factory.mktemp("features") / "labels.npz"
    save_features(fitted, path)
    return path


@pytest.fixture(scope="module")
def config(file):
    return replace(CONFIG, feature_model=file)


@pytest.fixture(scope="module")
def finished(config):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sim.world_states.build_scene", lambda *_: pytest.fail("something was rendered"))
        return run(config, Lexis(LabelEncoder()))


def test_labels_and_loops_come_out_of_features(finished):
    result = evaluate(finished, [])
    assert result.fidelity == "features"
    assert result.labels.accuracy > 0.8 and result.floors.accuracy == 1.0
    assert result.loops.true > 3 and result.loops.false == 0
    assert result.trajectory.ate_m < result.trajectory.ate_odometry_m


def test_the_same_seed_gives_the_same_run_and_another_one_another(config, finished):
    again, other = run(config, Lexis(LabelEncoder())), run(replace(config, seed=6), Lexis(LabelEncoder()))
    np.testing.assert_array_equal(again.estimate.similarities, finished.estimate.similarities)
    np.testing.assert_array_equal(again.estimate.T_W_B, finished.estimate.T_W_B)
    assert other.estimate.similarities[0].tolist() != finished.estimate.similarities[0].tolist()


def test_the_points_of_a_percept_are_where_rays_hit_the_house(finished):
    camera, around = finished.session.camera, survey(finished.house)
    for observation, truth in islice(finished.session, 20):
        points = transform(inverse(camera.T_B_C), observation.image.points)
        (view,) = true_views(look(around, truth.T_W_B[None], camera), truth.T_W_B[None], camera)
        ends = view.image.points.T
        assert 10 < len(points) <= 100
        assert np.abs(points[:, None] - ends).sum(axis=2).min(axis=1).max() < 1e-3


def test_a_map_by_sight_means_the_same_after_it_was_saved(config, tmp_path):
    settings = Config(labels=LabelConfig(method="sight"), segmentation=SegmentationConfig(method="sight"))
    encoder = LabelEncoder()
    lexis_map = run(config, Lexis(encoder, settings)).slam.map
    save_map(lexis_map, tmp_path / "map")
    again = relabel(load_map(tmp_path / "map"), lexis_map.room_names, encoder, settings)
    assert min(len(keyframe.landmarks.points) for keyframe in lexis_map.keyframes) > 10
    np.testing.assert_array_equal(again.labels, lexis_map.labels)
    assert [room.keyframes for room in again.rooms] == [room.keyframes for room in lexis_map.rooms]


def test_a_percept_has_no_place_for_truth(finished):
    observation, _ = next(iter(finished.session))
    assert isinstance(observation.image, Percept)
    assert {field.name for field in fields(Percept)} == {"embedding", "features", "points"}
    assert len(observation.image.features.keypoints) == 0


def images(fitted, *faults):
    walked = walk(CONFIG)
    sensor = FeatureSensor(fitted, build_rig(CONFIG.rig).front, CONFIG.seed)
    session = Session(walked.house, walked.tour, walked.odometry, build_rig(CONFIG.rig).front, faults, CONFIG.seed, sensor)
    return np.array([observation.image.embedding for observation, _ in session])


def test_moved_furniture_is_seen_from_then_on(fitted):
    same = np.isclose(images(fitted, MovedFurniture(1.0)), images(fitted), atol=1e-5).all(axis=1)
    half = len(same) // 2
    assert same[: half - 1].all() and not same[half + 1 :].all()


def test_faults_of_delivery_work_as_on_images(fitted):
    frozen, clean = (np.abs(np.diff(images(fitted, *faults), axis=0)).max(axis=1) for faults in ((Frozen(0.3),), ()))
    assert (frozen == 0.0).sum() > (clean == 0.0).sum()


@pytest.mark.parametrize("fault", [Blur(), Smear(), Pedestrian(), ClosedDoors()])
def test_faults_that_only_images_show_are_refused(fault):
    with pytest.raises(SimError, match=f"fault '{fault.name}' is seen in images only; valid: with fidelity 'render'"):
        replace(CONFIG, faults=(fault,))


def test_a_model_of_another_encoder_is_refused(config):
    class Other(LabelEncoder):
        name = "other"

        def encode_rooms(self, names):
            return super().encode_rooms(names)[:, ::-1]

    with pytest.raises(SimError, match=r"was fitted to another encoder than 'other'.*fit-features --encoder other"):
        run(config, Lexis(Other()))


def test_the_model_that_ships_is_of_the_encoder_that_ships():
    load_features(MINI_FEATURES).check(load_encoder("mini"), "mini")


def test_nobody_writes_into_a_model_that_runs_share():
    model = load_features(MINI_FEATURES)
    for part in (model, model.embedding, model.loops, model.loops.true_edges, model.loops.false_edges):
        arrays = [getattr(part, field.name) for field in fields(part)]
        assert not any(array.flags.writeable for array in arrays if isinstance(array, np.ndarray))


def test_models_keep_what_they_are_in_files(fitted, file):
    read = load_features(file)
    for name in ("weights", "offset", "errors", "kernels"):
        np.testing.assert_allclose(getattr(read.embedding, name), getattr(fitted.embedding, name), atol=1e-3)
    for part in ("true_edges", "false_edges"):
        for field in fields(MeasuredEdges):
            np.testing.assert_allclose(
                getattr(getattr(read.loops, part), field.name), getattr(getattr(fitted.loops, part), field.name), atol=1e-6
            )
    assert read.loops.query_share == 0.5 and read.loops.false_rate == 0.0


def test_a_kind_of_furniture_that_is_newer_than_the_model_does_not_show_in_embeddings(tmp_path):
    """All other kinds keep their weights, wherever the new kind is in the order of kinds."""
    with np.load(MINI_FEATURES) as whole:
        arrays = dict(whole)
    known = arrays["kinds"].tobytes().decode().split("\n")
    new, n = known.index("piano"), len(known)
    arrays["kinds"] = np.frombuffer("\n".join(kind for kind in known if kind != "piano").encode(), np.uint8)
    arrays["embedding.weights"] = np.delete(arrays["embedding.weights"], (new, n + new), axis=0)
    np.savez_compressed(tmp_path / "older.npz", **arrays)
    expected = load_features(MINI_FEATURES).embedding.weights.copy()
    expected[[KINDS.index("piano"), len(KINDS) + KINDS.index("piano")]] = 0.0
    np.testing.assert_array_equal(load_features(tmp_path / "older.npz").embedding.weights, expected)


def test_what_is_no_model_is_refused(fitted, tmp_path):
    with pytest.raises(SimError, match="no feature model there: No such file"):
        load_features(tmp_path / "missing.npz")
    (tmp_path / "text.npz").write_text("no model")
    with pytest.raises(SimError, match=r"no feature model: .*; valid: a file of 'lexis-sim fit-features'"):
        load_features(tmp_path / "text.npz")
    np.savez(tmp_path / "other.npz", weights=np.zeros(3))
    with pytest.raises(SimError, match="no feature model"):
        load_features(tmp_path / "other.npz")
    old = replace(fitted, embedding=replace(fitted.embedding, weights=np.zeros((3, 25), np.float32)))
    save_features(old, tmp_path / "old.npz")
    with pytest.raises(SimError, match="those of this version"):
        load_features(tmp_path / "old.npz")


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"loops.query_share": np.zeros(3, np.float32)}, r"loops.query_share is float32 \(3,\)"),
        ({"loops.query_share": np.array(1.5, np.float32)}, "between 0 and 1"),
        ({"loops.false_rate": np.array(0.5, np.float32)}, "no edges to draw from"),
        ({"embedding.offset": np.full(len(ROOM_LABELS), np.nan, np.float32)}, "not finite"),
        ({"embedding.offset": np.full(len(ROOM_LABELS), 1e30, np.float32)}, "too large"),
        ({"loops.true_edges.covariance": np.repeat(-np.eye(6, dtype=np.float32)[None], 3, axis=0)}, "no covariances"),
        ({"loops.true_edges.inliers": np.array([b"x"] * 3)}, "no feature model"),
        ({"embedding.kernels": np.zeros(2, np.float32)}, "those of this version"),
    ],
)
def test_a_model_with_parts_that_nothing_can_be_drawn_from_is_refused(changes, says, file, tmp_path):
    with np.load(file) as whole:
        arrays = {name: whole[name] for name in whole.files}
    np.savez_compressed(tmp_path / "changed.npz", **(arrays | changes))
    with pytest.raises(SimError, match=says) as error:
        load_features(tmp_path / "changed.npz")
    assert "\n" not in str(error.value)


def test_the_oracle_labels_by_what_is_truly_in_view(file):
    result = evaluate(run(replace(CONFIG, encoder="oracle", feature_model=file)), [])
    assert result.encoder == "oracle" and result.labels.accuracy > 0.8


def test_rooms_of_the_walk_without_a_keyframe_are_named(config, finished):
    """All frames but one are lost. That one may be labelled perfectly, which says nothing about the other rooms."""
    assert finished.unseen_rooms == () and rooms_without_keyframe(()) is None
    blind = run(replace(config, faults=(Dropped(1.0),)), Lexis(LabelEncoder()))
    result = evaluate(blind, [])
    walked = dict.fromkeys(truth.room for truth in finished.session.truths)
    _, *others = (finished.house.rooms[room].id for room in walked)
    assert result.run.keyframes == 1 and result.rooms == RoomFigures()
    assert [*blind.unseen_rooms] == others and len(others) == 2
    rest = f"so the figures of labels and rooms do not cover {' and '.join(others)}."
    told = f"No keyframe was taken in 2 rooms of the walk, {rest}"
    assert rooms_without_keyframe(blind.unseen_rooms) == told


def test_the_oracle_sees_no_images_and_knows_no_other_rooms():
    with pytest.raises(SimError, match="sees no images; valid: with fidelity 'features'"):
        replace(CONFIG, encoder="oracle", fidelity="render")
    with pytest.raises(EncoderError, match="cannot encode images; valid"):
        Oracle().encode_image(np.zeros((2, 2, 3), np.uint8))
    with pytest.raises(EncoderError, match="knows no room 'dungeon'"):
        Oracle().encode_rooms(["kitchen", "dungeon"])


def test_an_unknown_fidelity_is_refused():
    with pytest.raises(SimError, match=r"scenario\.fidelity is 'sound'; valid: render, features"):
        unchecked(Scenario, fidelity="sound")


def test_a_rear_camera_sees_what_the_front_camera_would_see_from_a_turned_body(fitted):
    """The cameras of this rig are at the origin of the body, so that turning the body exchanges them."""
    house, T_W_B = walk(CONFIG).house, walk(CONFIG).tour.T_W_B[:20]
    turn = np.diag([-1.0, -1.0, 1.0, 1.0])
    front = replace(build_rig(CONFIG.rig).front, others=())
    rig = replace(front, others=(replace(front, T_B_C=turn @ front.T_B_C),))
    seen = list(FeatureSensor(fitted, rig, 5).tour([house] * 20, T_W_B).percepts())
    turned = FeatureSensor(fitted, front, 5).tour([house] * 20, T_W_B @ turn).percepts()
    alone = FeatureSensor(fitted, front, 5).tour([house] * 20, T_W_B).percepts()
    for (first, second), (ahead,), (behind,) in zip(seen, alone, turned, strict=True):
        np.testing.assert_array_equal(first.embedding, ahead.embedding)
        np.testing.assert_allclose(second.embedding, behind.embedding, atol=1e-5)
        np.testing.assert_allclose(second.points, transform(turn, behind.points), atol=1e-4)
