"""Minimal examples of every kind of input file: houses, a map, a feature model, and a recording in every format."""

import json

import cv2
import numpy as np
from helpers.map_builder import build_map

from lexis.datasets.tum_rgbd import write_dataset
from lexis.map.folder import load_map, save_map
from lexis.map.interchange import write_spark_dsg
from lexis.maths.quaternions import pose_rows
from lexis.maths.se3 import exp
from lexis.types import Camera, Intrinsics, Observation
from sim.feature_sensor.covisibility_verifier import LoopModel, MeasuredEdges
from sim.feature_sensor.embedding import KERNELS, EmbeddingModel
from sim.feature_sensor.model import FeatureModel, save_features
from sim.feature_sensor.visible_shares import SIZE
from sim.record.messages import Messages
from sim.render.lens import Distortion
from worlds.plan_import.importer import to_geojson
from worlds.presets import sample_from_rooms
from worlds.spec import HouseSpec

CAMERA = Camera(
    Intrinsics(32, 24, 20.0, 20.0, 15.5, 11.5), np.array([[0, 0, 1, 0.1], [-1, 0, 0, 0], [0, -1, 0, 0.3], [0, 0, 0, 1.0]])
)
FRAMES = 4

_SQUARE, _NEXT = [[0, 0], [4, 0], [4, 3], [0, 3]], [[4, 0], [7, 0], [7, 3], [4, 3]]


def houses():
    """Contents of house files: a handwritten house with a bit of everything, and a sampled one of two rooms."""
    door = {"rooms": ["a", "b"], "kind": "door", "start_m": [4, 1], "end_m": [4, 1.9], "leaf": {"into": "a", "hinge": "end"}}
    sofa = {
        "id": "f",
        "kind": "sofa",
        "room": "a",
        "position_m": [1.5, 2.4, 0],
        "yaw_rad": 3.14,
        "size_m": [2, 0.8, 0.8],
        "seed": 0,
    }
    storey = {
        "height_m": 2.6,
        "rooms": [
            {"id": "a", "label": "kitchen", "polygon_m": _SQUARE},
            {"id": "b", "label": "office", "polygon_m": _NEXT, "seed": 3},
        ],
        "openings": [door],
        "windows": [{"room": "b", "start_m": [5, 0], "end_m": [6, 0]}],
        "furniture": [sofa],
    }
    return [{"storeys": [storey], "seed": 1}, json.loads(sample_from_rooms(("kitchen", "bedroom"), seed=31).to_json())]


def observations():
    """A few frames along a curve."""
    rng, pose = np.random.default_rng(5), np.eye(4)
    for i in range(FRAMES):
        yield Observation(i, 100.0 + 0.1 * i, rng.integers(0, 256, (24, 32, 3), dtype=np.uint8), pose, 1e-4 * np.eye(6))
        pose = pose @ exp(np.array([0.0, 0.02, 0.1, 0.2, 0.0, 0.0]))


def write_map(folder):
    """Write a map of six keyframes in two rooms, with one loop edge."""
    rng = np.random.default_rng(4)
    positions = [[0.5 * i, 0.1 * i * i, 0.0] for i in range(6)]
    rooms = [("kitchen", (0, 1, 2)), ("office", (3, 4, 5))]
    lexis_map = build_map(positions, [0, 0, 0, 1, 1, 1], rooms, ("kitchen", "office"), rng, loops=[(5, 1)], weights=[0.5])
    save_map(lexis_map, folder)


def write_features(path):
    """Write a feature model with two-dimensional embeddings."""
    edges = MeasuredEdges(
        np.full((2, 6), 0.005), np.repeat(np.eye(6)[None] * 1e-4, 2, axis=0), np.array([20, 30]), np.array([12, 15])
    )
    loops = LoopModel(np.array([-3.0, 12.0, 0.0, -1.0, -1.0]), 0.5, 0.0, edges, edges)
    weights, errors, kernels = (
        np.full((SIZE, 2), 0.1, np.float32),
        np.eye(2, dtype=np.float32),
        np.full(len(KERNELS), 1 / len(KERNELS)),
    )
    embedding = EmbeddingModel(weights, np.ones(2, np.float32), errors, kernels)
    save_features(FeatureModel(np.full((4, 2), 0.7, np.float32), embedding, loops), path)


def write_tum_run(folder):
    """Write the frames as a TUM dataset."""
    write_dataset(folder, CAMERA, observations())


def write_euroc_run(folder):
    """Write the frames as a EuRoC dataset with lens distortion."""
    sensor, odometry = folder / "mav0" / "cam0", folder / "mav0" / "odom0"
    (sensor / "data").mkdir(parents=True)
    odometry.mkdir()
    place = f"T_BS:\n  cols: 4\n  rows: 4\n  data: {CAMERA.T_B_C.ravel().tolist()}\n"
    (sensor / "sensor.yaml").write_text(
        f"sensor_type: camera\n{place}resolution: [32, 24]\ncamera_model: pinhole\nintrinsics: [20.0, 20.0, 15.5, 11.5]\n"
        "distortion_model: radial-tangential\ndistortion_coefficients: [0.1, 0.01, 0.0, 0.0]\n"
    )
    (odometry / "sensor.yaml").write_text(f"T_BS:\n  data: {np.eye(4).ravel().tolist()}\n")
    images, poses = ["#timestamp [ns],filename"], ["#timestamp, p, q, cov"]
    for seen in observations():
        stamp = round(seen.stamp * 1e9)
        (sensor / "data" / f"{stamp}.png").write_bytes(cv2.imencode(".png", seen.image)[1].tobytes())
        images.append(f"{stamp},{stamp}.png")
        row = pose_rows(seen.T_O_B[None])[0][[0, 1, 2, 6, 3, 4, 5]]
        poses.append(
            ",".join([str(stamp), *map(repr, row.tolist()), *map(repr, seen.increment_covariance.ravel().tolist())])
        )
    (sensor / "data.csv").write_text("\n".join(images) + "\n")
    (odometry / "data.csv").write_text("\n".join(poses) + "\n")


def write_bag_run(folder, storage="SQLITE3"):
    """Write the frames as a ROS 2 bag with PNG images."""
    from rosbags.rosbag2 import StoragePlugin, Writer

    messages, places, connections = Messages.load(), {"cam0": CAMERA}, {}
    with Writer(folder, version=8, storage_plugin=StoragePlugin[storage]) as writer:

        def write(stamp, topic, message):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, message.__msgtype__, typestore=messages.types)
            writer.write(connections[topic], stamp, messages.types.serialize_cdr(message, message.__msgtype__))

        for seen in observations():
            stamp = round(seen.stamp * 1e9)
            if not seen.index:
                write(stamp, "/tf_static", messages.static_transforms(stamp, places))
            png = cv2.imencode(".png", seen.image)[1].tobytes()
            write(stamp, "/cam0/camera_info", messages.camera_info(stamp, "cam0", CAMERA, CAMERA, Distortion()))
            write(stamp, "/cam0/image_raw/compressed", messages.compressed_image(stamp, "cam0", "png", png))
            odometry = messages.odometry(stamp, seen.T_O_B, np.eye(6), np.eye(4), np.eye(6), 0.1)
            write(stamp, "/odom", odometry)
            write(stamp, "/odom/increment_covariance", messages.matrix(seen.increment_covariance))


def write_all(folder):
    """Write one example of each kind of input to a folder."""
    write_map(folder / "map")
    write_spark_dsg(load_map(folder / "map"), folder / "graph.json")
    write_features(folder / "features.npz")
    write_tum_run(folder / "tum")
    write_euroc_run(folder / "euroc")
    write_bag_run(folder / "bag")
    write_bag_run(folder / "mcap", "MCAP")
    (folder / "house.json").write_text(json.dumps(houses()[0]))
    (folder / "house.geojson").write_text(to_geojson(HouseSpec.model_validate(houses()[0])))
    (folder / "rooms.json").write_text(json.dumps({"labels": ["kitchen", "office"]}))
