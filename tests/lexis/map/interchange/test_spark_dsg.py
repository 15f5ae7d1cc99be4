"""Scene graphs are Spark-DSG's, and a map survives the way through a scene graph, also when Spark-DSG saves it again."""

import json
from dataclasses import replace

import numpy as np
import pytest
import spark_dsg
from helpers.map_builder import corridor_with_offices, with_rear_camera, with_retired
from helpers.same_map import assert_same
from scipy.special import softmax

from lexis.cli import main
from lexis.errors import MapError
from lexis.map.folder import load_map, save_map
from lexis.map.interchange import read_spark_dsg, write_spark_dsg
from lexis.planning import plan


@pytest.fixture
def lexis_map(rng):
    """Two floors and stairs, loops of several kinds, and landmarks."""
    flat = corridor_with_offices(
        rng, loops=[(25, 3), (25, 3), (26, 25), (38, 12)], weights=[1.0, 0.25, 0.5, 0.0], refused=[1]
    )
    names = (*flat.room_names, "stairs")
    floors = np.repeat([0, 0, -1, 1], 10)
    rooms = [replace(room, floor=floor) for room, floor in zip(flat.rooms, (None, 0, 1), strict=True)]
    similarities = np.column_stack((flat.similarities, np.full(40, 0.125)))
    probabilities = softmax(similarities, axis=1)
    return replace(
        flat, room_names=names, floors=floors, rooms=tuple(rooms), similarities=similarities, probabilities=probabilities
    )


@pytest.fixture
def saved(lexis_map, tmp_path):
    write_spark_dsg(lexis_map, tmp_path / "graph.json")
    return tmp_path / "graph.json"


def without_features(lexis_map, folder):
    """The map as a folder keeps it without key points and landmarks."""
    save_map(lexis_map, folder, features=False)
    return load_map(folder)


def assert_equal_but_rotations(a, b):
    """Rotations may differ by the rounding of quaternions."""
    np.testing.assert_allclose(a.T_W_B, b.T_W_B, atol=1e-11, rtol=0)
    np.testing.assert_array_equal(a.T_W_B[:, :3, 3], b.T_W_B[:, :3, 3])
    assert_same(replace(a, T_W_B=b.T_W_B), b)


def test_reading_gives_back_all_but_key_points_and_landmarks(lexis_map, saved, tmp_path):
    assert_equal_but_rotations(read_spark_dsg(saved), without_features(lexis_map, tmp_path / "map"))


def test_retired_keyframes_stay_retired(lexis_map, tmp_path):
    thinned = with_retired(lexis_map, {12: 3, 39: 15})
    write_spark_dsg(thinned, tmp_path / "graph.json")
    assert_equal_but_rotations(read_spark_dsg(tmp_path / "graph.json"), without_features(thinned, tmp_path / "map"))


def test_the_views_of_further_cameras_are_kept(lexis_map, tmp_path, rng):
    of_a_rig = with_rear_camera(lexis_map, rng)
    write_spark_dsg(of_a_rig, tmp_path / "graph.json")
    assert_equal_but_rotations(read_spark_dsg(tmp_path / "graph.json"), without_features(of_a_rig, tmp_path / "map"))


def test_a_second_round_changes_nothing(saved, tmp_path):
    once = read_spark_dsg(saved)
    write_spark_dsg(once, tmp_path / "again.json")
    assert_same(read_spark_dsg(tmp_path / "again.json"), once)


def test_what_spark_dsg_saves_again_is_the_same_map(saved, tmp_path):
    spark_dsg.DynamicSceneGraph.load(str(saved)).save(str(tmp_path / "again.json"))
    assert_same(read_spark_dsg(tmp_path / "again.json"), read_spark_dsg(saved))


@pytest.fixture
def resumed(lexis_map):
    """The map, with its last 25 keyframes in a second session, whose clock starts at 0 again."""
    keyframes = [replace(k, session=1, stamp=k.stamp - 15.0) if k.id >= 15 else k for k in lexis_map.keyframes]
    return replace(lexis_map, keyframes=tuple(keyframes))


def test_sessions_are_written_and_read(resumed, tmp_path):
    write_spark_dsg(resumed, tmp_path / "graph.json")
    assert_equal_but_rotations(read_spark_dsg(tmp_path / "graph.json"), without_features(resumed, tmp_path / "map"))


def test_no_edge_leads_from_one_session_to_the_next(resumed, tmp_path):
    write_spark_dsg(resumed, tmp_path / "graph.json")
    graph = spark_dsg.DynamicSceneGraph.load(str(tmp_path / "graph.json"))
    for category in "pa":
        steps = [graph.has_edge(symbol(category, i), symbol(category, i + 1)) for i in range(39)]
        assert [i for i, walked in enumerate(steps) if not walked] == [14]


def test_a_graph_without_session_numbers_is_one_session(saved):
    data = json.loads(saved.read_text())
    for node in data["nodes"]:
        node["attributes"]["metadata"]["lexis"].pop("session", None)
    saved.write_text(json.dumps(data))
    assert {keyframe.session for keyframe in read_spark_dsg(saved).keyframes} == {0}


def symbol(category, index):
    return spark_dsg.NodeSymbol(category, index)


def test_spark_dsg_sees_floors_rooms_places_and_agents(lexis_map, saved):
    graph = spark_dsg.DynamicSceneGraph.load(str(saved))
    counts = {name: graph.get_layer(name).num_nodes() for name in ("FLOORS", "ROOMS", "PLACES", "AGENTS")}
    assert counts == {"FLOORS": 2, "ROOMS": 3, "PLACES": 40, "AGENTS": 40}
    stairs, office, above = (graph.get_node(symbol("R", i)) for i in range(3))
    assert [room.attributes.name for room in (stairs, office, above)] == ["corridor", "office 1", "office 2"]
    assert not stairs.has_parent()
    assert above.get_parent() == symbol("F", 1).value
    assert graph.get_labelspace(4, 0).get_category(office.attributes.semantic_label) == "office"
    for i, keyframe in enumerate(lexis_map.keyframes):
        place, agent = graph.get_node(symbol("p", i)), graph.get_node(symbol("a", i))
        assert place.get_parent() == symbol("R", int(lexis_map.room_of[i])).value
        assert agent.get_parent() == place.id.value
        np.testing.assert_array_equal(place.attributes.semantic_feature.ravel(), keyframe.embedding)
        np.testing.assert_array_equal(agent.attributes.position, lexis_map.T_W_B[i, :3, 3])
        assert agent.attributes.timestamp.total_seconds() == pytest.approx(keyframe.stamp)
    assert graph.get_edge(symbol("a", 12), symbol("a", 38)).info.weight == 0.0
    assert graph.has_edge(symbol("R", 0), symbol("R", 1)) and not graph.has_edge(symbol("R", 1), symbol("R", 2))


def test_what_is_changed_in_spark_dsg_is_changed_in_the_map(saved):
    graph = spark_dsg.DynamicSceneGraph.load(str(saved))
    graph.get_node(symbol("p", 7)).attributes.semantic_label = 2
    graph.get_node(symbol("a", 7)).attributes.position = np.array([1.0, 2.0, 3.0])
    table = spark_dsg.ObjectNodeAttributes()
    graph.add_node(2, symbol("O", 0), table)
    graph.save(str(saved))
    changed = read_spark_dsg(saved)
    assert changed.label_of(7) == "kitchen"
    np.testing.assert_array_equal(changed.T_W_B[7, :3, 3], [1, 2, 3])


def test_commands_write_and_read_a_graph_with_which_plans_are_made(lexis_map, tmp_path, capsys):
    save_map(lexis_map, tmp_path / "map")
    assert main(["export", str(tmp_path / "map"), "--format", "spark-dsg", "-o", str(tmp_path / "graph.json")]) == 0
    assert main(["import", str(tmp_path / "graph.json"), "-o", str(tmp_path / "back")]) == 0
    back = load_map(tmp_path / "back")
    assert plan(back, "corridor", "office 1").keyframes == plan(lexis_map, "corridor", "office 1").keyframes
    assert "40 keyframes" in capsys.readouterr().out


def changed(data, path, value):
    """Set or delete an entry of nested data; `path` is separated by points."""
    *parents, last = (int(key) if key.isdigit() else key for key in path.split("."))
    for key in parents:
        data = data[key]
    if value is None:
        del data[last]
    else:
        data[last] = value


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        ("metadata.lexis", None, r"metadata\.lexis: Field required"),
        ("metadata.lexis.schema", 1, r"metadata\.lexis\.schema"),
        ("metadata.lexis.room_names", ["corridor", "corridor", "a", "b"], "more than once"),
        ("metadata.lexis.camera.fx", -1, "intrinsics"),
        ("nodes.2.attributes.semantic_label", 9, "R0 has no keyframe, or a label that is not among room_names"),
        ("nodes.5.id", 8070450532247928833, "node p0 is missing"),
        ("nodes.5.attributes.semantic_label", 77, "labels has a value outside"),
        ("nodes.6.attributes.semantic_feature.data", [1.0], "p1 has an embedding of 1 numbers in 16 rows; valid: 16"),
        ("nodes.6.attributes.semantic_feature.data", [0.5] * 16, "array embedding has norm 2 in row 1; valid: unit norm"),
        ("nodes.6.attributes.metadata.lexis.similarities", [1.0], "p1 has 1 similarities; valid: 4"),
        ("nodes.45.attributes.world_R_body.w", 3.0, "a0 has a rotation that is no unit quaternion"),
        ("nodes.45.attributes.position", [1e300, 0, 0], "position beyond"),
        ("nodes.2.attributes.position", [0, 1e300, 0], "array room_mean has a position beyond"),
        ("nodes.45.attributes.metadata.lexis.stamp", 1e6, "stamp does not ascend"),
        ("nodes.84", None, "40 nodes p|39 nodes a"),
        ("edges.1.target", 8070450532247929832, "p1000 is no keyframe"),
        ("edges.1.source", 5908722711110090760, "edge leads from R8|R0 has no keyframe"),
        ("metadata.lexis.decisions.0.query", 2**70, r"metadata\.lexis\.decisions\.0\.query"),
        ("metadata.lexis.decisions.1.match", -1, r"metadata\.lexis\.decisions\.1\.match"),
        ("metadata.lexis.decisions.0.matches", 2**70, r"metadata\.lexis\.decisions\.0\.matches"),
        ("metadata.lexis.decisions.0.inliers", -2, r"metadata\.lexis\.decisions\.0\.inliers"),
        ("metadata.lexis.decisions.0.cells", 2**63, r"metadata\.lexis\.decisions\.0\.cells"),
        ("metadata.lexis.decisions.0.outcome", "lost", r"metadata\.lexis\.decisions\.0\.outcome"),
        ("edges.50.source", "kitchen", r"edges\.50\.source"),
    ],
)
def test_damage_is_named(saved, path, value, says):
    data = json.loads(saved.read_text())
    changed(data, path, value)
    saved.write_text(json.dumps(data))
    with pytest.raises(MapError, match=says) as error:
        read_spark_dsg(saved)
    assert str(saved) in str(error.value) and "\n" not in str(error.value)
    assert len(str(error.value)) < 600


@pytest.mark.parametrize(("node", "name"), [(2, "R0"), (5, "p0"), (45, "a0")])
def test_a_node_that_is_there_twice_is_refused(saved, node, name):
    data = json.loads(saved.read_text())
    data["nodes"].append(data["nodes"][node])
    saved.write_text(json.dumps(data))
    with pytest.raises(MapError, match=f"node {name} is there twice; valid: each node once"):
        read_spark_dsg(saved)


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_an_embedding_that_is_too_large_is_refused_without_a_warning(saved):
    data = json.loads(saved.read_text())
    data["nodes"][6]["attributes"]["semantic_feature"]["data"][0] = 1e300
    saved.write_text(json.dumps(data))
    with pytest.raises(MapError, match="array embedding has values that are not finite"):
        read_spark_dsg(saved)
