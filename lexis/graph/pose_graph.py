"""The growing pose graph: keyframes, loop edges, and the current estimate of the poses (paper, Sec. III-A, III-D)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float32, Float64, Int

from lexis.config import PoseGraphConfig
from lexis.errors import LexisError
from lexis.graph.graph_optimisation import GraphOptimiser, loop_weights
from lexis.graph.thinning import STAYS, Retired, anchors
from lexis.maths.growing_array import GrowingArray
from lexis.maths.se3 import between, compose_covariance
from lexis.types import Covariance, Keyframe, LoopEdge, Poses


@dataclass(frozen=True)
class _Extent:
    """Size of the graph at an optimisation."""

    keyframes: int = 0
    loops: int = 0


class PoseGraph:
    """Keyframes, loop edges and the current pose estimate. For the first keyframe, T_W_B equals T_O_B.

    Active keyframes are those in the optimisation. Each is joined by odometry to the active keyframe before it.
    """

    def __init__(self, config: PoseGraphConfig) -> None:
        """Create an empty graph."""
        self._config = config
        self._T_W_B = GrowingArray((4, 4))
        self._path_m, self._stamps = GrowingArray(()), GrowingArray(())
        self._embeddings = GrowingArray((0,), np.float32)
        self._active = GrowingArray((), np.int64)
        self._covariances: list[Covariance] = []
        self._retired = Retired()
        self._acting: list[LoopEdge] = []
        self._optimiser: GraphOptimiser | None = None
        self._last_optimised, self._last_whole = _Extent(), _Extent()
        self.keyframes: list[Keyframe] = []
        self.loops: list[LoopEdge] = []

    @property
    def T_W_B(self) -> Poses:
        """The current estimate: poses from the last optimisation; those of later keyframes continue them by odometry."""
        return self._T_W_B.rows

    @property
    def active(self) -> Int[np.ndarray, "k"]:
        """Ids of the keyframes in the optimisation, ascending. The others have retired; see `lexis.graph.thinning`."""
        return self._active.rows

    @property
    def embeddings(self) -> Float32[np.ndarray, "n d"]:
        """CLIP embeddings of all keyframes (f_CLIP in the paper)."""
        return self._embeddings.rows

    @property
    def path_m(self) -> Float64[np.ndarray, "n"]:
        """Length of the odometry path from the first keyframe to each keyframe [m]."""
        return self._path_m.rows

    @property
    def stamps(self) -> Float64[np.ndarray, "n"]:
        """Stamps of the keyframes [s]."""
        return self._stamps.rows

    @property
    def loop_weights(self) -> Float64[np.ndarray, "loops"]:
        """Weights of the loop edges under the robust kernel at the current estimate, in [0, 1].

        The edges of retired keyframes have weights, too, though they no longer take part in the optimisation.
        """
        return loop_weights(self.T_W_B, self.loops, self._config)

    def add_keyframe(self, keyframe: Keyframe) -> None:
        """Append a keyframe at the pose that odometry predicts from the previous keyframe's pose."""
        if self._optimiser is None:
            self._optimiser = GraphOptimiser(keyframe.T_O_B, self._config)
            self._embeddings = GrowingArray(keyframe.embedding.shape, np.float32)
            self._T_W_B.append(keyframe.T_O_B)
            self._path_m.append(0.0)
        else:
            step = between(self.keyframes[-1].T_O_B, keyframe.T_O_B)
            self._T_W_B.append(self.T_W_B[-1] @ step)
            self._optimiser.add_keyframe(self.T_W_B[-1], step, keyframe.step_covariance)
            self._path_m.append(self.path_m[-1] + np.linalg.norm(step[:3, 3]))
        self._active.append(len(self.keyframes))
        self._covariances.append(keyframe.step_covariance)
        self._stamps.append(keyframe.stamp)
        self._embeddings.append(keyframe.embedding)
        self.keyframes.append(keyframe)

    def add_loops(self, loops: Sequence[LoopEdge]) -> None:
        """Append verified loop edges; they take effect at the next optimisation, except those to retired keyframes.

        Raises LexisError, and appends no edge, unless every edge leads from a keyframe of the graph to an earlier keyframe.
        """
        n = len(self.keyframes)
        for loop in loops:
            if not 0 <= loop.match < loop.query < n:
                edge = f"{loop.match} -> {loop.query}"
                raise LexisError(f"loop edge {edge} does not fit the graph; valid: 0 <= match < query < {n}")
        if self._optimiser is not None:
            self._acting.extend(acting := self._between_active(loops))
            self._optimiser.add_loops(self._by_rows(acting))
        self.loops.extend(loops)

    def optimise_if_due(self, final: bool = False) -> bool:
        """Optimise if there are new loop edges and enough new keyframes (setting `every`) since the last optimisation.

        Most optimisations move the last keyframes only (`window`), and some the whole graph (`growth`). After those,
        keyframes that are no longer needed retire (`copies`). With `final`, new loop edges alone suffice, and the whole
        graph is optimised. Returns whether the graph was optimised.
        """
        now = _Extent(len(self.keyframes), len(self.loops))
        grown = now.keyframes - self._last_whole.keyframes >= self._config.growth * len(self.active)
        whole = final or grown
        last = self._last_whole if final else self._last_optimised
        waited = now.keyframes - last.keyframes >= self._config.every
        if now.loops == last.loops or not (waited or final):
            return False
        assert self._optimiser is not None
        self._move(self._optimiser.optimise() if whole else self._optimiser.optimise_last(self._config.window))
        self._last_optimised = now
        if whole:
            self._last_whole = now
        if grown and not final:
            self._retire()
        return True

    def _move(self, last: Poses) -> None:
        """Set the poses of the last active keyframes; retired keyframes follow their anchors."""
        moved = self.active[len(self.active) - len(last) :]
        self._T_W_B.replace(moved, last)
        self._T_W_B.replace(*self._retired.following(int(moved[0]), self.T_W_B))

    def _retire(self) -> None:
        """Let active keyframes before the last `window` ones retire if enough earlier ones show their places."""
        if self._config.copies is None:
            return
        old = self.active[: -self._config.window]
        rows = np.array([(loop.query, loop.match) for loop in self._by_rows(self._acting)], int).reshape(-1, 2)
        anchor = anchors(self.T_W_B[old], self.path_m[old], rows[rows[:, 0] < len(old)], self._config.copies)
        leaving = np.flatnonzero(anchor != STAYS)
        if len(leaving):
            self._retired = self._retired.joined_by(old[leaving], old[anchor[leaving]], self.T_W_B)
            self._leave_out(leaving)
            self._restart()

    def _leave_out(self, rows: Int[np.ndarray, "k"]) -> None:
        """Remove rows of `active`, and add the covariances of their odometry steps to those of the steps after them."""
        for row in rows.tolist():
            step = between(self.keyframes[self.active[row]].T_O_B, self.keyframes[self.active[row + 1]].T_O_B)
            self._covariances[row + 1] = compose_covariance(self._covariances[row], step, self._covariances[row + 1])
        kept = np.delete(np.arange(len(self.active)), rows)
        self._covariances = [self._covariances[row] for row in kept.tolist()]
        ids, self._active = self.active[kept], GrowingArray((), np.int64)
        for id in ids.tolist():
            self._active.append(id)

    def _restart(self) -> None:
        """Begin the optimiser anew with the active keyframes at their current poses, and the loop edges between them."""
        T_O_B = np.stack([self.keyframes[id].T_O_B for id in self.active.tolist()])
        steps = between(T_O_B[:-1], T_O_B[1:])
        self._optimiser = GraphOptimiser(T_O_B[0], self._config)
        for id, step, covariance in zip(self.active[1:].tolist(), steps, self._covariances[1:], strict=True):
            self._optimiser.add_keyframe(self.T_W_B[id], step, covariance)
        self._acting = self._between_active(self._acting)
        self._optimiser.add_loops(self._by_rows(self._acting))

    def _between_active(self, loops: Sequence[LoopEdge]) -> list[LoopEdge]:
        """The loop edges both of whose keyframes are active."""
        ids = np.array([(loop.query, loop.match) for loop in loops], int).reshape(-1, 2)
        rows = np.flatnonzero(np.isin(ids, self.active).all(axis=1))
        return [loops[row] for row in rows.tolist()]

    def _by_rows(self, loops: Sequence[LoopEdge]) -> list[LoopEdge]:
        """The loop edges with rows of `active` in place of ids, as the optimiser numbers keyframes."""
        rows = np.searchsorted(self.active, [(loop.query, loop.match) for loop in loops]).reshape(-1, 2).tolist()
        return [replace(loop, query=query, match=match) for loop, (query, match) in zip(loops, rows, strict=True)]
