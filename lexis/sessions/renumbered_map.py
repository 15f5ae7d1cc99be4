"""What a saved map knows about its keyframes, in the numbers that they get as further sessions of another map."""

from collections import defaultdict
from dataclasses import replace

import numpy as np

from lexis.graph.components import component_of, sessions_of
from lexis.graph.pose_graph import KnownPlace
from lexis.graph.walked_steps import carried_before
from lexis.maths.se3 import between
from lexis.maths.ties import rounded
from lexis.types import Keyframe, LexisMap, LoopDecision, LoopEdge


class RenumberedMap:
    """The keyframes of a map with new ids and sessions, and how the map has joined its sessions."""

    def __init__(self, map: LexisMap, first: int, session: int) -> None:
        """`first` is the new id of the map's first keyframe, and `session` the new number of its first session."""
        self._map, self._first, self._session = map, first, session
        self._sessions, self._components = sessions_of(map.keyframes), component_of(map)
        self._carried_before = set(carried_before(map).tolist())
        self._loops: defaultdict[int, list[LoopEdge]] = defaultdict(list)
        for loop in map.loops:
            if self._sessions[loop.query] != self._sessions[loop.match]:
                self._loops[loop.query].append(replace(loop, query=first + loop.query, match=first + loop.match))
        self._decisions = {(decision.query, decision.match): decision for decision in map.decisions}

    def keyframe(self, id: int) -> Keyframe:
        """Return the keyframe that has this id in the map, with its new numbers."""
        old = self._map.keyframes[id]
        anchor = None if old.anchor is None else self._first + old.anchor
        return replace(old, id=self._first + id, session=self._session + old.session, anchor=anchor)

    def place(self, id: int) -> KnownPlace | None:
        """Return where a keyframe lies, if the map knows this from something other than odometry.

        A retired keyframe has a place relative to its anchor. If the robot was carried elsewhere since the last keyframe
        that has not retired, a keyframe has a place relative to the one before it. The first keyframe of a session has a
        place relative to the nearest keyframe of the earlier sessions in its component, if there are any. For other
        keyframes, the result is None.
        """
        anchor = self._map.keyframes[id].anchor
        if anchor is not None:
            return self._relative(anchor, id)
        if id > 0 and self._sessions[id] == self._sessions[id - 1]:
            return self._relative(id - 1, id) if self._is_carried(id) else None
        earlier = np.flatnonzero(self._components[:id] == self._components[id])
        if not len(earlier):
            return None
        off_m = np.linalg.norm(self._map.T_W_B[earlier, :3, 3] - self._map.T_W_B[id, :3, 3], axis=1)
        return self._relative(int(earlier[rounded(off_m).argmin()]), id)

    def _is_carried(self, id: int) -> bool:
        """Whether the robot was carried between the last keyframe before `id` that has not retired and the keyframe `id`."""
        since = id
        while since not in self._carried_before and self._map.keyframes[since - 1].anchor is not None:
            since -= 1
        return since in self._carried_before

    def _relative(self, beside: int, id: int) -> KnownPlace:
        return KnownPlace(self._first + beside, np.asarray(between(self._map.T_W_B[beside], self._map.T_W_B[id])))

    def loops(self, id: int) -> list[LoopEdge]:
        """Return the loop edges that lead from a keyframe to other sessions, which join the sessions."""
        return self._loops[id]

    def decisions(self, id: int) -> list[LoopDecision]:
        """Return the decisions on these loop edges, as far as the map has them."""
        pairs = [(id, loop.match - self._first) for loop in self._loops[id]]
        old = [self._decisions[pair] for pair in pairs if pair in self._decisions]
        return [replace(decision, query=self._first + id, match=self._first + decision.match) for decision in old]
