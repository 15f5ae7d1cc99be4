"""Rendered walks on which methods of place recognition are compared: what they are given, and the truth about it.

LEXIS maps every walk once. A listener in the place of its encoder and of its place recognition collects the evidence.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float16, Float32, Float64, Int, UInt8

from lexis.config import Config, PlaceRecognitionConfig
from lexis.evaluation.place_recognition import at_one_place
from lexis.graph.pose_graph import PoseGraph
from lexis.maths.se3 import between, rotation_angle
from lexis.perception import Encoder
from lexis.place_recognition import old_enough, propose
from lexis.types import Image, Keyframe, Poses, RoomInstance
from sim.baselines.places.descriptors import strongest_orb
from sim.baselines.places.patches import patch_features
from sim.baselines.places.place_method import SeenKeyframes
from sim.harness import Run, Scenario, run
from sim.harness.adapters import Lexis
from sim.harness.adapters.lexis import load
from sim.harness.walk import with_walk_m
from sim.harness.world_tests import RENDER_FRAME_RATE_HZ

WALK_M = 250.0
"""Default length of a walk [m]: about half of its keyframes show a place for the second time."""
_ALL = 1_000_000


@dataclass(frozen=True, eq=False)
class PlaceWalk:
    """A walk through a house: the keyframes as methods see them, and the truth about the keyframes."""

    preset: str
    seed: int
    seen: SeenKeyframes
    T_W_B: Poses
    """True poses of the body."""
    right: Bool[np.ndarray, "n n"]
    """Whether each pair of keyframes is truly at one place, within 1 m and 0.5 rad."""
    rooms: Int[np.ndarray, "n"]
    """True room of every keyframe, as an index into the rooms of the house."""
    labels: Int[np.ndarray, "n"]
    """True label of the room of every keyframe."""
    storeys: Int[np.ndarray, "n"]


@dataclass(eq=False)
class _Listener:
    """An encoder that keeps descriptors of the images of keyframes, and place recognition that keeps all evidence."""

    encoder: Encoder
    orb: list[UInt8[np.ndarray, "_ 32"]] = field(default_factory=list)
    patches: list[Float16[np.ndarray, "_ channels"]] = field(default_factory=list)
    keyframes: list[Keyframe] = field(default_factory=list)
    old: list[Bool[np.ndarray, "k"]] = field(default_factory=list)
    estimated: list[tuple[Float64[np.ndarray, "k"], Float64[np.ndarray, "k"]]] = field(default_factory=list)
    active: list[Int[np.ndarray, "_"]] = field(default_factory=list)
    in_room: list[Sequence[int]] = field(default_factory=list)

    @property
    def name(self) -> str:
        return self.encoder.name

    @property
    def fingerprint(self) -> str:
        return self.encoder.fingerprint

    def encode_rooms(self, names: Sequence[str]) -> Float32[np.ndarray, "rooms d"]:
        return self.encoder.encode_rooms(names)

    def encode_image(self, image: Image) -> Float32[np.ndarray, "d"]:
        self.orb.append(strongest_orb(image))  # LEXIS encodes the images of keyframes only, in their order
        self.patches.append(patch_features(image))
        return self.encoder.encode_image(image)

    def __call__(
        self, query: Keyframe, label: str, rooms: Sequence[RoomInstance], graph: PoseGraph, config: PlaceRecognitionConfig
    ) -> tuple[int, ...]:
        T_old_query = between(graph.T_W_B[: query.id + 1], graph.T_W_B[query.id])
        self.estimated.append((np.linalg.norm(T_old_query[:, :3, 3], axis=1), rotation_angle(T_old_query)))
        self.old.append(old_enough(query.id, graph.stamps, graph.path_m, config))
        self.active.append(graph.active.copy())
        paper = PlaceRecognitionConfig(method="room", candidates=_ALL)
        self.in_room.append(propose(query, label, rooms, graph, paper))
        self.keyframes.append(query)
        return propose(query, label, rooms, graph, PlaceRecognitionConfig())

    def seen(self) -> SeenKeyframes:
        n = len(self.keyframes)
        eligible, active, in_room = np.zeros((3, n, n), bool)
        estimated = np.full((2, n, n), np.inf)
        for query in range(n):
            eligible[query, : len(self.old[query])] = self.old[query]
            active[query, self.active[query]] = in_room[query, list(self.in_room[query])] = True
            estimated[:, query, : query + 1] = self.estimated[query]
        akaze = tuple(keyframe.features.descriptors for keyframe in self.keyframes)
        embeddings = np.array([keyframe.embedding for keyframe in self.keyframes])
        local = tuple(self.orb), akaze, tuple(self.patches)
        return SeenKeyframes(embeddings, *local, eligible, estimated[0], estimated[1], active, in_room)


def record_walks(
    presets: Sequence[str], seeds: Sequence[int], length_m: float = WALK_M, rate_hz: float | None = None
) -> Iterator[PlaceWalk]:
    """Walk through a house of every preset and seed, and render every walk once.

    `length_m` is the length of each walk [m], see `with_walk_m`, and `rate_hz` the number of frames per second [Hz]; None:
    the usual one.
    """
    rate_hz = rate_hz or RENDER_FRAME_RATE_HZ
    for preset in presets:
        for seed in seeds:
            yield record_walk(with_walk_m(Scenario(preset=preset, seed=seed, frame_rate_hz=rate_hz), length_m))


def record_walk(scenario: Scenario) -> PlaceWalk:
    """Let LEXIS map a rendered walk, and return its keyframes as methods of place recognition see them, with the truth."""
    listener = _Listener(load(scenario.encoder))
    # The rooms that the paper searches are needed at every keyframe; the candidates are those of the default method.
    with_rooms = Config(place_recognition=PlaceRecognitionConfig(method="room"))
    finished = run(scenario, Lexis(listener, with_rooms, place_recogniser=listener))
    return _with_truth(finished, listener.seen())


def _with_truth(finished: Run, seen: SeenKeyframes) -> PlaceWalk:
    poses = finished.true_poses
    truth = finished.true_rooms, finished.true_labels, finished.true_storeys
    return PlaceWalk(finished.scenario.preset, finished.scenario.seed, seen, poses, at_one_place(poses), *truth)
