"""Exported maps can be read by the tools that they are meant for: evo and GTSAM."""

import json
from dataclasses import replace

import gtsam
import numpy as np
import pytest
from evo.tools import file_interface
from helpers.map_builder import corridor_with_offices

from lexis.errors import LexisError, MapError
from lexis.files.tum_trajectory import read_tum
from lexis.map.export import FORMATS, export_map
from lexis.maths.se3 import between


@pytest.fixture
def lexis_map(rng):
    return corridor_with_offices(rng, loops=[(25, 3)], weights=[1.0])


def test_trajectories_are_evos(lexis_map, tmp_path):
    export_map(lexis_map, "tum", tmp_path / "t.tum")
    export_map(lexis_map, "kitti", tmp_path / "t.kitti")
    tum = file_interface.read_tum_trajectory_file(tmp_path / "t.tum")
    kitti = file_interface.read_kitti_poses_file(tmp_path / "t.kitti")
    np.testing.assert_allclose(tum.poses_se3, lexis_map.T_W_B, atol=1e-7)
    np.testing.assert_allclose(tum.timestamps, [k.stamp for k in lexis_map.keyframes])
    np.testing.assert_allclose(kitti.poses_se3, lexis_map.T_W_B, atol=1e-7)


def in_sessions(lexis_map, starts, stamp_s):
    """The map as if its keyframes from each of `starts` on were of one more session, whose first stamp is `stamp_s`."""
    keyframes = list(lexis_map.keyframes)
    for session, first in enumerate(starts, 1):
        shift = stamp_s[session - 1] - keyframes[first].stamp
        keyframes[first:] = [replace(k, session=session, stamp=k.stamp + shift) for k in keyframes[first:]]
    return replace(lexis_map, keyframes=tuple(keyframes))


def test_a_trajectory_can_be_read_again_or_is_not_written(lexis_map, tmp_path):
    export_map(in_sessions(lexis_map, [10, 25], [100.0, 200.0]), "tum", tmp_path / "t.tum")
    stamps, poses = read_tum(tmp_path / "t.tum")
    assert len(stamps) == 40 and (stamps[9], stamps[10], stamps[25]) == (4.5, 100.0, 200.0)
    np.testing.assert_allclose(poses, lexis_map.T_W_B, atol=1e-7)
    for stamp_s in ([100.0, 5.0], [100.0, 107.0000001]):  # the session before begins at 100.0 s and ends at 107.0 s
        with pytest.raises(MapError, match=r"of session 2 follows 107.* of session 1, .*; valid: ") as error:
            export_map(in_sessions(lexis_map, [10, 25], stamp_s), "tum", tmp_path / "no.tum")
        assert not (tmp_path / "no.tum").exists() and str(tmp_path / "no.tum") in str(error.value)


def test_gtsam_reads_the_graph_with_poses_and_covariances(lexis_map, tmp_path):
    export_map(lexis_map, "g2o", tmp_path / "map.g2o")
    graph, values = gtsam.readG2o(str(tmp_path / "map.g2o"), True)
    for i, pose in enumerate(lexis_map.T_W_B):
        np.testing.assert_allclose(values.atPose3(i).matrix(), pose, atol=1e-7)
    assert graph.size() == len(lexis_map.keyframes)  # 39 odometry edges and one loop edge
    a, b = lexis_map.keyframes[7:9]
    step, loop = graph.at(7), graph.at(39)
    assert list(step.keys()) == [7, 8] and list(loop.keys()) == [3, 25]
    np.testing.assert_allclose(step.measured().matrix(), between(a.T_O_B, b.T_O_B), atol=1e-7)
    np.testing.assert_allclose(step.noiseModel().covariance(), b.step_covariance, rtol=1e-3, atol=2e-8)
    np.testing.assert_allclose(loop.noiseModel().covariance(), lexis_map.loops[0].covariance, rtol=1e-3, atol=2e-8)


@pytest.mark.parametrize("format", FORMATS)
def test_a_file_may_be_named_by_a_string(lexis_map, tmp_path, format):
    export_map(lexis_map, format, tmp_path / "one")
    export_map(lexis_map, format, str(tmp_path / "two"))
    one, two = tmp_path / "one", tmp_path / "two"
    if one.is_dir():
        assert sorted(path.name for path in one.iterdir()) == sorted(path.name for path in two.iterdir())
    else:
        assert one.read_bytes() == two.read_bytes()


def test_json_names_every_keyframes_room(lexis_map, tmp_path):
    export_map(lexis_map, "json", tmp_path / "map.json")
    data = json.loads((tmp_path / "map.json").read_text())
    assert [room["name"] for room in data["rooms"]] == ["corridor", "office 1", "office 2"]
    assert [k["room"] for k in data["keyframes"][8:12]] == ["corridor"] * 2 + ["office 1"] * 2
    assert data["loops"] == [{"query": 25, "match": 3, "inliers": 20, "weight": 1.0}]


def test_json_tells_what_became_of_every_loop_candidate(rng, tmp_path):
    tried = corridor_with_offices(rng, loops=[(25, 3)], weights=[0.75], refused=[12])
    export_map(tried, "json", tmp_path / "map.json")
    good, bad = json.loads((tmp_path / "map.json").read_text())["candidates"]
    assert (good["query"], good["match"], good["outcome"], good["weight"]) == (25, 3, "accepted", 0.75)
    assert (good["room"], good["cells"], good["misfit_m"]) == ("corridor", 7, 0.25)
    assert good["similarity"] == pytest.approx(tried.keyframes[25].embedding @ tried.keyframes[3].embedding, abs=1e-6)
    assert (bad["room"], bad["outcome"], bad["matches"]) == ("office 1", "few matches", 3)
    assert bad["inliers"] is bad["misfit_m"] is bad["weight"] is None


def test_unknown_formats_and_unwritable_places_are_refused(lexis_map, tmp_path):
    with pytest.raises(LexisError, match="tum, kitti, g2o, json"):
        export_map(lexis_map, "ply", tmp_path / "map.ply")
    for format in FORMATS.keys() - {"ros"}:  # which makes the folders that it needs
        with pytest.raises(LexisError, match="cannot be written"):
            export_map(lexis_map, format, tmp_path / "absent" / "map")
