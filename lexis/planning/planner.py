"""Shortest paths between rooms.

1. A path begins at the innermost keyframe of the start (`lexis.planning.path_ends`).
2. Keyframes are connected where a robot can travel between them (`lexis.planning.connections`).
3. The path is the shortest one over this graph, by Dijkstra's algorithm, to a keyframe at which the robot is surely inside
   the goal (`lexis.planning.arrivals`). The last keyframe therefore depends on where the path comes from.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Int
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from lexis.config import PlannerConfig, SightConfig
from lexis.errors import PlanError
from lexis.graph.walked_steps import walked_steps
from lexis.planning.arrivals import surely_inside
from lexis.planning.connections import as_graph, lengths_of, unwalked_steps
from lexis.planning.path_ends import PathEnd, clear_ends, path_end
from lexis.planning.shortcuts import chunks, points_between
from lexis.room_names import find_rooms, instance_names, no_such_room
from lexis.sight.passages import Passages, passages_in
from lexis.types import LexisMap, Pairs, RoomInstance


@dataclass(frozen=True)
class Plan:
    """A path over the pose graph."""

    start: RoomInstance
    goal: RoomInstance
    keyframes: tuple[int, ...]
    """Ids of the keyframes from start to goal. The first and the last may belong to neighbouring rooms; see `path_end`."""
    length_m: float
    """Sum of the straight-line distances between consecutive keyframes of the path [m]."""


def plan(map: LexisMap, start: str, goal: str, config: PlannerConfig | None = None, avoid: Sequence[str] = ()) -> Plan:
    """Return the shortest path between two rooms, named as instances ("office 2") or by label ("office").

    See `PathPlanner.plan`. To plan several paths in one map, create one `PathPlanner`, which is faster.
    """
    return PathPlanner(map, config).plan(start, goal, avoid)


class PathPlanner:
    """Plans any number of paths in one map."""

    def __init__(self, map: LexisMap, config: PlannerConfig | None = None) -> None:
        self._map, self._config = map, config or PlannerConfig()
        self._ends: dict[int, PathEnd] = {}
        self._inside: dict[int, np.ndarray] = {}

    def plan(self, start: str, goal: str, avoid: Sequence[str] = ()) -> Plan:
        """Return the shortest path between two rooms, named as instances ("office 2") or by label ("office").

        A label stands for all its instances; of these, the start and the goal with the shortest path are chosen. Instances
        with little evidence are ignored unless the label has no other (`clear_ends`). The path begins well inside the start
        (`path_end`), and ends at the first keyframe at which a robot on this path is surely inside the goal
        (`surely_inside`). If the goal has no such keyframe, or its innermost keyframe is nearer, the path ends there.

        Args:
            start: the room where the path begins.
            goal: the room where the path ends.
            avoid: rooms, named like start and goal, whose keyframes the path may not contain, and through which it takes no
                shortcut. A label stands for all its rooms.

        Raises:
            PlanError: the map lacks one of the rooms, the start or the goal is to be avoided, or no path connects them.
        """
        closed = self._closed(avoid)
        starts = [(end.room, end.keyframe) for end in self._clear_ends(start) if not closed[end.keyframe]]
        goals = [arrival for arrival in self._arrivals(goal) if not closed[arrival[1]]]
        for name, ends in ((start, starts), (goal, goals)):
            if not ends:
                raise PlanError(
                    f"every place where the path could begin or end in {name!r} is in a room to avoid; "
                    "valid: other rooms to avoid"
                )
        graph = self._graph(closed)
        lengths = dijkstra(graph, indices=[keyframe for _, keyframe in starts])[:, [keyframe for _, keyframe in goals]]
        s, g = (int(i) for i in np.unravel_index(lengths.argmin(), lengths.shape))
        if not np.isfinite(lengths[s, g]):
            if closed.any():
                raise PlanError(f"no path from {start} to {goal} without {', '.join(avoid)}; valid: fewer rooms to avoid")
            raise PlanError(
                f"no path from {start} to {goal}: the walk was interrupted between them; valid: rooms of one walk"
            )
        keyframes = shortest_path(graph, starts[s][1], goals[g][1])
        return Plan(starts[s][0], goals[g][0], keyframes, float(lengths[s, g]))

    def _closed(self, avoid: Sequence[str]) -> Bool[np.ndarray, "n"]:
        """Return which keyframes belong to the rooms to avoid. Raises PlanError for an unknown name."""
        closed = np.zeros(len(self._map.keyframes), bool)
        for room in (room for name in avoid for room in self._known_rooms(name)):
            closed[list(room.keyframes)] = True
        return closed

    def _clear_ends(self, name: str) -> list[PathEnd]:
        """Return the path ends of all rooms named `name` that are not doubtful. Raises PlanError for an unknown name."""
        return clear_ends(self._map, [self._end(room) for room in self._known_rooms(name)])

    def _arrivals(self, name: str) -> list[tuple[RoomInstance, int]]:
        """Return where a path to `name` may end: pairs of a room and one of its keyframes.

        Raises PlanError for an unknown name.
        """
        return [
            (end.room, keyframe)
            for end in self._clear_ends(name)
            for keyframe in sorted({end.keyframe, *self._surely_inside(end.room).tolist()})
        ]

    def _end(self, room: RoomInstance) -> PathEnd:
        if room.id not in self._ends:
            self._ends[room.id] = path_end(self._map, room)
        return self._ends[room.id]

    def _surely_inside(self, room: RoomInstance) -> Int[np.ndarray, "k"]:
        if room.id not in self._inside:
            most = max(self._end(other).evidence for other in self._map.rooms if other.label == room.label)
            self._inside[room.id] = surely_inside(self._map, room, most, self._doorways)
        return self._inside[room.id]

    @cached_property
    def _doorways(self) -> Passages:
        """The narrow passages by the default settings, because a map does not store those that it was made with."""
        return passages_in(self._map, SightConfig())

    @cached_property
    def graph(self) -> csr_array:
        """Lengths of the connections between keyframes that a robot can travel [m], as a symmetric sparse matrix (n, n)."""
        return as_graph(self._map, np.concatenate(self._steps))

    @cached_property
    def _steps(self) -> tuple[Pairs, Int[np.ndarray, "k 2"]]:
        """The steps that the camera walked, and the other ones."""
        return walked_steps(self._map), unwalked_steps(self._map, self._config)

    def _graph(self, closed: Bool[np.ndarray, "n"]) -> csr_array:
        """Return the graph without connections that end at a closed keyframe, and without unwalked ones that lead past one.

        A step leads past a closed keyframe if this is the nearest keyframe anywhere on the step.
        """
        if not closed.any():
            return self.graph
        walked, other = (steps[~closed[steps].any(axis=1)] for steps in self._steps)
        return as_graph(self._map, np.concatenate([walked, other[~self._leads_past(other, closed)]]))

    def _leads_past(self, steps: Pairs, closed: Bool[np.ndarray, "n"]) -> Bool[np.ndarray, "m"]:
        positions = self._map.T_W_B[:, :3, 3]
        longest = float(lengths_of(steps, positions).max(initial=0.0))
        tree, parts = cKDTree(positions), chunks(steps, longest)
        past = [closed[tree.query(points_between(positions, part, longest))[1]].any(axis=1) for part in parts]
        return np.concatenate([np.zeros(0, bool), *past])

    def _known_rooms(self, name: str) -> tuple[RoomInstance, ...]:
        """Return the rooms named `name`. Raises PlanError for an unknown name."""
        rooms = find_rooms(self._map.rooms, name)
        if not rooms:
            valid = ", ".join(instance_names(self._map.rooms))
            raise PlanError(f"{no_such_room(self._map.rooms, name)}; valid: {valid}, or one of these without its number")
        return rooms


def shortest_path(graph: csr_array, start: int, goal: int) -> tuple[int, ...]:
    """Return the keyframes of a shortest path; if several are shortest, the same one in both directions."""
    first, last = sorted((start, goal))
    before = dijkstra(graph, indices=[first], return_predecessors=True)[1][0]
    path = [last]
    while path[-1] != first:
        path.append(int(before[path[-1]]))
    return tuple(path if start == last else reversed(path))
