"""SLAM systems that claim the truth, except for one planted bug. They know the scenario, which no real SLAM does."""

import numpy as np

from sim.harness import Estimate, run
from sim.harness.walk import walk
from worlds.truth import boundary_openness, room_at


class Planted:
    """Claims true poses, labels, rooms and floors; subclasses spoil one of them."""

    def __init__(self, scenario):
        self.scenario, self.frames, self.odometry = scenario, [], []

    def start(self, camera, room_names):
        self.names = room_names

    def process(self, observation):
        self.frames.append(observation.index)
        self.odometry.append(observation.T_O_B)

    def finish(self):
        walked, frames = walk(self.scenario), np.array(self.frames)
        self.house = walked.house
        poses = walked.tour.T_W_B[frames]
        rooms = room_at(self.house, poses[:, :3, 3])
        labels = np.array([self.names.index(self.house.rooms[room].label) for room in rooms])
        bases = np.array([storey.floor_m for storey in self.house.storeys])
        floors = np.maximum(np.searchsorted(bases, poses[:, 2, 3], side="right") - 1, 0)
        return Estimate(frames, **self.claims(poses, rooms, labels, floors))

    def claims(self, poses, rooms, labels, floors):
        return {"T_W_B": poses, "rooms": rooms, "labels": labels, "floors": floors}


class OpenPlanBug(Planted):
    """Swaps the labels of two rooms where more than half of the boundary between them is open."""

    def claims(self, poses, rooms, labels, floors):
        place = {room.id: k for k, room in enumerate(self.house.rooms)}
        swapped = labels.copy()
        for pair, share in boundary_openness(self.house).items():
            if share > 0.5:
                a, b = (place[self.house.room_by_id[room].id] for room in pair)
                in_a, in_b = rooms == a, rooms == b
                swapped[in_a], swapped[in_b] = (self.names.index(self.house.rooms[k].label) for k in (b, a))
        return super().claims(poses, rooms, swapped, floors)


class FloorBug(Planted):
    """Says that every floor above the first storey is the first one."""

    def claims(self, poses, rooms, labels, floors):
        return super().claims(poses, rooms, labels, np.minimum(floors, 0))


class DriftBug(Planted):
    """Claims the poses of the odometry."""

    def claims(self, poses, rooms, labels, floors):
        return super().claims(np.array(self.odometry), rooms, labels, floors)


def planted(kind):
    """Runs a planted SLAM on a scenario, as `FailureTest` wants it."""
    return lambda scenario, progress: run(scenario, kind(scenario), progress)
