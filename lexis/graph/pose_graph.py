"""The growing pose graph: keyframes, loop edges, and the current estimate of the poses (paper, Sec. III-A, III-D)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Float64

from lexis.config import PoseGraphConfig
from lexis.errors import LexisError
from lexis.graph.graph_optimisation import GraphOptimiser, loop_weights
from lexis.maths.growing_array import GrowingArray
from lexis.maths.se3 import between
from lexis.types import Keyframe, LoopEdge, Poses


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
        """Length of the odometry path from the first keyframe to each keyframe [m]."""
        return self._path_m.rows

    @property
    def stamps(self) -> Float64[np.ndarray, "n"]:
        """Stamps of the keyframes [s]."""
        return self._stamps.rows

    @property
    def loop_weights(self) -> Float64[np.ndarray, "loops"]:
        """Weights of the loop edges under the robust DCS kernel at the current estimate, in [0, 1]."""
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
        self._stamps.append(keyframe.stamp)
        self._embeddings.append(keyframe.embedding)
        self.keyframes.append(keyframe)

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
