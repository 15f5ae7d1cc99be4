"""Maps on disk: loading inverts saving, damaged maps are refused, nothing is unpickled and nothing half-written."""

import errno
import json
import os
import pickle
import shutil
from dataclasses import replace

import numpy as np
import pytest
from helpers.map_builder import corridor_with_offices, with_rear_camera, with_retired
from helpers.same_map import assert_same

from lexis.errors import LexisError, MapError
from lexis.files.arrays import read_arrays
from lexis.map.folder import load_map, save_map
from lexis.types import LOOP_OUTCOMES


@pytest.fixture
def lexis_map(rng):
    return corridor_with_offices(rng, loops=[(25, 3), (38, 12)], weights=[1.0, 0.25], refused=[1, 2])


def test_loading_gives_back_what_was_saved(lexis_map, tmp_path):
    save_map(lexis_map, tmp_path / "map")
    assert_same(load_map(tmp_path / "map"), lexis_map)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["map"]


def test_a_folder_may_be_named_by_a_string(lexis_map, tmp_path):
    save_map(lexis_map, str(tmp_path / "map"))
    assert_same(load_map(str(tmp_path / "map")), load_map(tmp_path / "map"))
    with pytest.raises(MapError, match=r"none/map\.json: no map there"):
        load_map(str(tmp_path / "none"))


def test_a_folder_that_holds_a_part_of_a_map_or_a_map_below_it_says_so(lexis_map, tmp_path):
    run = tmp_path / "run"
    save_map(lexis_map, run / "map")
    with pytest.raises(MapError, match=f"run: no map there; valid: {run / 'map'}, which holds one"):
        load_map(run)
    for name in ("arrays.npz", "map.json"):
        save_map(lexis_map, tmp_path / "part")
        (tmp_path / "part" / name).unlink()
        with pytest.raises(MapError, match=f"part: the map is incomplete: {name} is missing; valid: both files"):
            load_map(tmp_path / "part")
        shutil.rmtree(tmp_path / "part")


def test_a_map_without_loops_or_features_is_a_map(rng, tmp_path):
    bare = corridor_with_offices(rng)
    save_map(bare, tmp_path / "map", features=False)
    loaded = load_map(tmp_path / "map")
    assert all(len(k.features.keypoints) == len(k.landmarks.points) == 0 for k in loaded.keyframes)
    np.testing.assert_array_equal(loaded.T_W_B, bare.T_W_B)
    assert_same(loaded.rooms, bare.rooms)


@pytest.fixture
def of_a_rig(lexis_map, rng):
    return with_rear_camera(lexis_map, rng)


def test_the_views_of_further_cameras_are_kept(of_a_rig, tmp_path):
    save_map(of_a_rig, tmp_path / "map")
    assert_same(load_map(tmp_path / "map"), of_a_rig)
    save_map(of_a_rig, tmp_path / "bare", features=False)
    for loaded, saved in zip(load_map(tmp_path / "bare").keyframes, of_a_rig.keyframes, strict=True):
        np.testing.assert_array_equal(loaded.embeddings, saved.embeddings)
        assert len(loaded.points) == len(loaded.others[0].features.keypoints) == 0


RETIRED = {12: 3, 13: 3, 20: 8, 39: 15}


@pytest.mark.parametrize("rig", [False, True])
def test_keyframes_that_have_retired_take_no_embeddings_of_their_own(lexis_map, of_a_rig, tmp_path, rig):
    thinned = with_retired(of_a_rig if rig else lexis_map, RETIRED)
    save_map(thinned, tmp_path / "map")
    loaded = load_map(tmp_path / "map")
    assert_same(loaded, thinned)
    for id, anchor in RETIRED.items():
        pairs = zip(loaded.keyframes[id].views, loaded.keyframes[anchor].views, strict=True)
        assert all(np.shares_memory(own.embedding, other.embedding) for own, other in pairs)
    with np.load(tmp_path / "map" / "arrays.npz") as arrays:
        assert len(arrays["embedding"]) == 40 - len(RETIRED)


@pytest.mark.parametrize(
    ("anchors", "says"),
    [({0: 5}, "not earlier"), ({9: 9}, "not earlier"), ({9: -2}, "not earlier"), ({9: 4, 4: 2}, "retired itself")],
)
def test_anchors_that_are_not_active_or_not_earlier_are_refused(lexis_map, tmp_path, anchors, says):
    save_map(lexis_map, tmp_path / "map")
    column = np.full(40, -1)
    column[list(anchors)] = list(anchors.values())
    rewritten(tmp_path / "map", anchor=column)
    with pytest.raises(MapError, match=says):
        load_map(tmp_path / "map")


def test_embeddings_are_those_of_active_keyframes_and_sessions_begin_with_one(lexis_map, tmp_path):
    changes = {"embedding has 36 rows; valid: 40": {"anchor": np.full(40, -1)}}
    changes |= {"first keyframe of a session": {"session": np.repeat([0, 1], 20)}}
    for number, (message, changed) in enumerate(changes.items()):
        folder = tmp_path / f"map{number}"
        save_map(with_retired(lexis_map, RETIRED), folder)
        rewritten(folder, **changed)
        with pytest.raises(MapError, match=message):
            load_map(folder)


def test_a_map_of_one_camera_has_nothing_of_others(lexis_map, tmp_path):
    save_map(lexis_map, tmp_path / "map")
    assert "other" not in (tmp_path / "map" / "map.json").read_text()
    with np.load(tmp_path / "map" / "arrays.npz") as arrays:
        assert not [name for name in arrays.files if name.startswith("other")]


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"other_landmark_points": "far"}, "other_landmark_points has a position beyond"),
        ({"other_embedding": None}, "lacks the arrays other_embedding"),
        ({"other_embedding": np.zeros((40, 2, 16), np.float32)}, "other_embedding"),
        ({"other_embedding": np.full((40, 1, 16), np.nan, np.float32)}, "finite"),
        ({"other_embedding": np.ones((40, 1, 16), np.float32)}, "array other_embedding has norm 4 in row 0; valid: unit"),
        ({"other_descriptors": "narrow"}, "other_descriptors has 60 columns; valid: 61"),
        ({"descriptors": "narrow"}, "array descriptors has 60 columns; valid: 61"),
        ({"other_feature_count": np.zeros((40, 1), int)}, "other_feature_count does not add up"),
        ({"other_landmark_count": np.zeros((40, 2), int)}, "other_landmark_count"),
        ({"other_landmark_count": np.zeros((40, 1), int)}, "other_landmark_count does not add up"),
    ],
)
def test_damaged_views_of_further_cameras_are_refused(of_a_rig, tmp_path, changes, says):
    save_map(of_a_rig, tmp_path / "map")
    rewritten(tmp_path / "map", **changes)
    with pytest.raises(MapError, match=says):
        load_map(tmp_path / "map")


def test_a_landmark_of_a_feature_that_its_image_lacks_is_refused(of_a_rig, tmp_path):
    save_map(of_a_rig, tmp_path / "map")
    count = sum(len(keyframe.others[0].landmarks.points) for keyframe in of_a_rig.keyframes)
    for wrong in (100, -2):
        rewritten(tmp_path / "map", other_landmark_feature=np.full(count, wrong))
        with pytest.raises(MapError, match="other_landmark_feature refers to a feature"):
            load_map(tmp_path / "map")


def test_an_earlier_map_is_replaced_and_anything_else_is_left_alone(lexis_map, tmp_path):
    save_map(lexis_map, tmp_path / "map")
    save_map(lexis_map, tmp_path / "map")
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter1.tex").write_text("years of work")
    with pytest.raises(LexisError, match="thesis"):
        save_map(lexis_map, tmp_path / "thesis")
    assert (tmp_path / "thesis" / "chapter1.tex").read_text() == "years of work"


def test_a_failed_save_leaves_nothing(lexis_map, tmp_path, monkeypatch):
    def full(*args, **kwargs):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(LexisError, match="No space left"):
        save_map(lexis_map, tmp_path / "map")
    assert not list(tmp_path.iterdir())


def rewritten(folder, **changes):
    """Replace arrays in the folder of a map; "narrow" removes the last column, "far" adds 1e300, and None the array."""
    with np.load(folder / "arrays.npz") as arrays:
        content = {name: arrays[name] for name in arrays.files}
    makers = {"narrow": lambda array: array[:, :-1], "far": lambda array: array + 1e300}
    changes = {k: makers[v](content[k]) if isinstance(v, str) else v for k, v in changes.items()}
    np.savez(folder / "arrays.npz", **{k: v for k, v in (content | changes).items() if v is not None})


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"labels": np.full(40, 7)}, "labels"),
        ({"decision_outcome": np.full(6, len(LOOP_OUTCOMES))}, "decision_outcome"),
        ({"decision_counts": np.full((6, 3), -2)}, "decision_counts"),
        ({"labels": np.zeros(39, int)}, "labels"),
        ({"labels": np.zeros(40)}, "labels"),
        ({"T_W_B": None}, "lacks the arrays T_W_B"),
        ({"T_W_B": np.zeros((40, 4, 4))}, "rigid"),
        ({"stamp": np.full(40, np.nan)}, "finite"),
        ({"embedding": np.eye(40, 16, dtype=np.float32)}, "array embedding has norm 0 in row 16; valid: unit norm"),
        ({"stamp": np.zeros(40)}, "ascend"),
        ({"loop_match": np.array([0, 40])}, "loop_match"),
        ({"loop_match": np.array([39, 39])}, r"loop 0 leads from keyframe \d+ to 39, which is not earlier; valid: "),
        ({"loop_weight": np.array([0.5, 1.5])}, "loop_weight"),
        ({"feature_count": np.zeros(40, int)}, "feature_count"),
        ({"room_of": np.zeros(40, int)}, "no keyframe"),
        ({"labels": np.array([pickle.loads] * 40, object)}, "no arrays of a map"),
        ({"step_covariance": -np.tile(np.eye(6), (40, 1, 1))}, "step_covariance has a matrix that is no covariance"),
        ({"loop_covariance": np.full((2, 6, 6), 1e300)}, "loop_covariance has a matrix that is no covariance"),
        ({"loop_covariance": np.zeros((2, 6, 6))}, "loop_covariance has a singular matrix"),
        ({"feature_count": np.array([2**62, 2**62, 2**62, 2**62] + [0] * 36)}, "feature_count does not add up"),
        ({"stamp": np.arange(40) * 1e300}, "array stamp has a time beyond"),
        ({"room_mean": np.full((3, 3), 1e300)}, "room_mean has a position beyond"),
        ({"landmark_points": "far"}, "landmark_points has a position beyond"),
        ({"T_W_B": np.eye(4)[None] + np.pad([[1e155]], ((0, 3), (3, 0))) * np.ones((40, 1, 1))}, "T_W_B .* position beyond"),
    ],
)
def test_arrays_that_contradict_the_map_are_refused(lexis_map, tmp_path, changes, says):
    save_map(lexis_map, tmp_path / "map")
    rewritten(tmp_path / "map", **changes)
    with pytest.raises(MapError, match=says) as error:
        load_map(tmp_path / "map")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("schema", 1),
        ("encoder", {"name": "mini"}),
        ("room_names", []),
        ("room_names", ["a", "a", "b"]),
        ("camera", {"width": 4}),
        ("more", 1),
    ],
)
def test_a_broken_header_is_refused(lexis_map, tmp_path, field, value):
    save_map(lexis_map, tmp_path / "map")
    header = json.loads((tmp_path / "map" / "map.json").read_text())
    (tmp_path / "map" / "map.json").write_text(json.dumps(header | {field: value}))
    with pytest.raises(MapError) as error:
        load_map(tmp_path / "map")
    assert "\n" not in str(error.value) and str(tmp_path) in str(error.value)


@pytest.mark.parametrize("damage", ["absent", "no header", "truncated", "not a zip"])
def test_what_is_no_map_is_refused(lexis_map, tmp_path, damage):
    if damage != "absent":
        save_map(lexis_map, tmp_path / "map")
    arrays = tmp_path / "map" / "arrays.npz"
    if damage == "no header":
        (tmp_path / "map" / "map.json").unlink()
    elif damage == "truncated":
        arrays.write_bytes(arrays.read_bytes()[:-2000])
    elif damage == "not a zip":
        arrays.write_bytes(b"no zip")
    with pytest.raises(MapError):
        load_map(tmp_path / "map")


@pytest.mark.parametrize("name", ["map.json", "arrays.npz"])
def test_the_files_of_two_maps_are_no_map(lexis_map, tmp_path, name):
    """Both maps have equal numbers of keyframes and rooms, so that all sizes fit."""
    later = replace(lexis_map, keyframes=tuple(replace(k, stamp=k.stamp + 1.0) for k in lexis_map.keyframes))
    for folder, each in (("a", lexis_map), ("b", later)):
        save_map(each, tmp_path / folder)
        assert load_map(tmp_path / folder).keyframes[0].stamp == each.keyframes[0].stamp
    shutil.copy(tmp_path / "b" / name, tmp_path / "a" / name)
    with pytest.raises(MapError, match=r"map\.json belongs to another arrays\.npz, or one of them was changed; valid: b"):
        load_map(tmp_path / "a")


def test_a_map_that_is_replaced_between_the_reading_of_its_two_files_is_read_again(lexis_map, tmp_path, monkeypatch):
    """A run with `--save-every` replaces its map while another program may read it."""
    later = replace(lexis_map, keyframes=tuple(replace(k, stamp=k.stamp + 1.0) for k in lexis_map.keyframes))
    save_map(lexis_map, tmp_path / "map")

    def replacing(*arguments):
        monkeypatch.undo()
        save_map(later, tmp_path / "map")
        return read_arrays(*arguments)

    monkeypatch.setattr("lexis.map.folder.read_arrays", replacing)
    assert_same(load_map(tmp_path / "map"), later)


def test_a_compressed_map_is_refused(lexis_map, tmp_path):
    """Arrays are stored uncompressed, so that loading a map never needs more memory than the file has bytes."""
    save_map(lexis_map, tmp_path / "map")
    with np.load(tmp_path / "map" / "arrays.npz") as arrays:
        np.savez_compressed(tmp_path / "map" / "arrays.npz", **{name: arrays[name] for name in arrays.files})
    with pytest.raises(MapError, match="unpacks to"):
        load_map(tmp_path / "map")


@pytest.mark.parametrize("name", ["map.json", "arrays.npz"])
def test_a_pipe_in_the_place_of_a_file_holds_nobody_up(name, lexis_map, tmp_path):
    save_map(lexis_map, tmp_path / "map")
    (tmp_path / "map" / name).unlink()
    os.mkfifo(tmp_path / "map" / name)
    with pytest.raises(MapError, match="is a device or a pipe"):
        load_map(tmp_path / "map")
