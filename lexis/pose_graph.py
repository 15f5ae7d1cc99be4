"""The growing pose graph: keyframes, loop edges, and the current estimate of the poses (paper, Sec. III-A, III-D).

Odometry connects the keyframes of one session. Sessions that loops connect form a component, whose poses share a frame.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Float64, Int

from lexis.config import PoseGraphConfig
from lexis.errors import LexisError
from lexis.graph_optimisation import GraphOptimiser, loop_weights
from lexis.maths.growing_array import GrowingArray
from lexis.maths.se3 import between, inverse
from lexis.types import Keyframe, LoopEdge, Pose, Poses


@dataclass(frozen=True)
class _Extent:
    """Size of the graph at an optimisation."""

    keyframes: int = 0
    loops: int = 0


class PoseGraph:
    """Keyframes, loop edges and the current pose estimate. For the first keyframe, T_W_B equals T_O_B."""

    def __init__(self, config: PoseGraphConfig) -> None:
        """Create an empty graph."""
        self._config = config
        self._T_W_B = GrowingArray((4, 4))
        self._path_m, self._stamps = GrowingArray(()), GrowingArray(())
        self._embeddings = GrowingArray((0,), np.float32)
        self._optimiser: GraphOptimiser | None = None
        self._last_optimised, self._last_whole = _Extent(), _Extent()
        self._sessions = GrowingArray((), np.int64)
        self._component_of = np.zeros(0, int)  # by session
        self.session_start = 0
        """Id of the first keyframe of the last session."""
        self.keyframes: list[Keyframe] = []
        self.loops: list[LoopEdge] = []

    @property
    def T_W_B(self) -> Poses:
        """The current estimate: poses from the last optimisation; those of later keyframes continue them by odometry."""
        return self._T_W_B.rows

    @property
    def embeddings(self) -> Float32[np.ndarray, "n d"]:
        """CLIP embeddings of all keyframes (f_CLIP in the paper)."""
        return self._embeddings.rows

    @property
    def path_m(self) -> Float64[np.ndarray, "n"]:
        """Length of the odometry path to each keyframe from the first keyframe of its session [m]."""
        return self._path_m.rows

    @property
    def stamps(self) -> Float64[np.ndarray, "n"]:
        """Stamps of the keyframes [s]."""
        return self._stamps.rows

    @property
    def components(self) -> Int[np.ndarray, "n"]:
        """The component of every keyframe, named by the number of its earliest session."""
        return np.asarray(self._component_of[self._sessions.rows])

    @property
    def is_split(self) -> bool:
        """Whether there are several components."""
        return bool(self._component_of.any())

    def path_between(self, first: int, second: int) -> float:
        """Length of the odometry path between two keyframes, over which their estimated relative pose drifts [m].

        For keyframes of two sessions, it is the path of the second keyframe's session.
        """
        same = self.keyframes[first].session == self.keyframes[second].session
        return float(self.path_m[second] - (self.path_m[first] if same else 0.0))

    @property
    def loop_weights(self) -> Float64[np.ndarray, "loops"]:
        """Weights of the loop edges under the robust DCS kernel at the current estimate, in [0, 1]."""
        return loop_weights(self.T_W_B, self.loops, self._config)

    def add_keyframe(self, keyframe: Keyframe) -> None:
        """Append a keyframe at the pose that odometry predicts from the previous keyframe's pose.

        The first keyframe of a session begins a new component, at its odometry pose.
        """
        if self._optimiser is None or keyframe.session != self.keyframes[-1].session:
            self._begin_session(keyframe)
        else:
            step = between(self.keyframes[-1].T_O_B, keyframe.T_O_B)
            self._T_W_B.append(self.T_W_B[-1] @ step)
            self._optimiser.add_keyframe(self.T_W_B[-1], step, keyframe.step_covariance)
            self._path_m.append(self.path_m[-1] + np.linalg.norm(step[:3, 3]))
        self._stamps.append(keyframe.stamp)
        self._embeddings.append(keyframe.embedding)
        self._sessions.append(keyframe.session)
        self.keyframes.append(keyframe)

    def _begin_session(self, keyframe: Keyframe) -> None:
        if self._optimiser is None:
            self._optimiser = GraphOptimiser(keyframe.T_O_B, self._config)
            self._embeddings = GrowingArray(keyframe.embedding.shape, np.float32)
        else:
            self._optimiser.add_session(keyframe.T_O_B)
        self._T_W_B.append(keyframe.T_O_B)
        self._path_m.append(0.0)
        self._component_of = np.append(self._component_of, keyframe.session)
        self.session_start = keyframe.id

    def resume(
        self,
        keyframes: Sequence[Keyframe],
        T_W_B: Poses,
        loops: Sequence[LoopEdge],
        component_of: Int[np.ndarray, "sessions"],
    ) -> None:
        """Fill an empty graph with the keyframes, poses and loops of an earlier one, and the component of every session."""
        for keyframe in keyframes:
            self.add_keyframe(keyframe)
        self._move_to(T_W_B)
        self._component_of = component_of
        self.add_loops(loops)
        self._last_optimised = self._last_whole = _Extent(len(self.keyframes), len(self.loops))

    def join(self, loops: Sequence[LoopEdge], shift: Pose) -> None:
        """Join two components by loop edges that all lead from one of them to the other.

        `shift` moves the poses of the component of the loops' queries to where they belong beside their matches. The poses
        of the component with the earlier session stay as they are; the other one is moved.
        """
        components = self.components
        moved, kept = int(components[loops[0].query]), int(components[loops[0].match])
        if moved < kept:
            moved, kept, shift = kept, moved, np.asarray(inverse(shift))
        T_W_B = self.T_W_B.copy()
        T_W_B[components == moved] = shift @ T_W_B[components == moved]
        self._move_to(T_W_B)
        self._component_of = np.where(self._component_of == moved, kept, self._component_of)
        self.add_loops(loops)

    def _move_to(self, T_W_B: Poses) -> None:
        assert self._optimiser is not None
        self._T_W_B.replace(T_W_B)
        self._optimiser.restart_at(T_W_B)

    def add_loops(self, loops: Sequence[LoopEdge]) -> None:
        """Append verified loop edges; they take effect at the next optimisation.

        Raises LexisError, and appends no edge, unless every edge leads from a keyframe of the graph to an earlier keyframe.
        """
        if self._optimiser is not None:
            self._optimiser.add_loops(loops)
        elif loops:
            raise LexisError("loop edges were added to a graph without keyframes; valid: keyframes first")
        self.loops.extend(loops)

    def optimise_if_due(self, final: bool = False) -> bool:
        """Optimise if there are new loop edges and enough new keyframes (setting `every`) since the last optimisation.

        Most optimisations move the last keyframes only (`window`), and some the whole graph (`growth`). With `final`, new
        loop edges alone suffice, and the whole graph is optimised. Returns whether the graph was optimised.
        """
        now = _Extent(len(self.keyframes), len(self.loops))
        grown = now.keyframes - self._last_whole.keyframes >= self._config.growth * now.keyframes
        whole = final or grown
        last = self._last_whole if final else self._last_optimised
        waited = now.keyframes - last.keyframes >= self._config.every
        if now.loops == last.loops or not (waited or final):
            return False
        assert self._optimiser is not None
        self._T_W_B.replace(self._optimiser.optimise() if whole else self._optimiser.optimise_last(self._config.window))
        self._last_optimised = now
        if whole:
            self._last_whole = now
        return True
