"""The growing pose graph: keyframes, loop edges, and the current estimate of the poses (paper, Sec. III-A, III-D).

Odometry connects the keyframes of one session. Sessions that loops connect form a component, whose poses share a frame.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import compress
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float32, Float64, Int

from lexis.config import PoseGraphConfig
from lexis.graph.far_loops import FarLoops, steps_of
from lexis.graph.graph_optimisation import CONVERGED, ROUGHLY, GraphOptimiser, check_loops, loop_weights
from lexis.graph.thinning import STAYS, Retired, anchors, as_retired, fits, thinned_loops
from lexis.graph.trusted_loops import is_trusted
from lexis.inputs import MAX_VARIANCE
from lexis.maths.growing_array import GrowingArray
from lexis.maths.se3 import between, compose_covariance, inverse, orthonormal
from lexis.types import Camera, Covariance, Keyframe, LoopArrays, LoopEdge, Pose, Poses

_SESSION_M = 1e6
"""Length of path that is assumed between consecutive sessions [m], so that keyframes of two sessions count as two visits."""


@dataclass(frozen=True)
class _Extent:
    """Numbers of keyframes and loop edges in the graph at an optimisation."""

    keyframes: int = 0
    loops: int = 0
    """Number of loop edges that have been added so far, those of keyframes that have retired included."""


class KnownPlace(NamedTuple):
    """The place of a new keyframe, relative to a keyframe of the graph."""

    beside: int
    """Id of the keyframe of the graph."""
    T_beside_B: Pose
    """Pose of the new keyframe relative to it."""


class PoseGraph:
    """Keyframes, loop edges and the current pose estimate.

    For the first keyframe, T_W_B equals T_O_B, or the pose that it had in the earlier graph that is resumed.

    Active keyframes take part in the optimisation. Odometry connects each active keyframe to the active keyframe before it.
    """

    def __init__(self, config: PoseGraphConfig, camera: Camera | None = None) -> None:
        """Create an empty graph. `camera` is the camera of all keyframes; only a rig of several cameras has to be given."""
        self._config = config
        self.rotations = np.stack([np.eye(3)] if camera is None else [each.T_B_C[:3, :3] for each in camera.rig])
        """Rotations of the cameras on the body, from C to B (cameras, 3, 3)."""
        self._T_W_B = GrowingArray((4, 4))
        self._path_m, self._stamps = GrowingArray(()), GrowingArray(())
        self._embeddings = GrowingArray((1, 0), np.float32)
        self._active = GrowingArray((), np.int64)
        self._covariances: list[Covariance] = []
        self._retired = Retired()
        self._bridged = GrowingArray((), bool)  # by the trusted loops of keyframes that have retired
        self._added = 0  # number of loop edges so far
        self._optimiser: GraphOptimiser | None = None
        self._first: Pose | None = None  # the pose at which the first keyframe is held
        self._last_optimised, self._last_whole, self._last_final = _Extent(), _Extent(), _Extent()
        self._sessions = GrowingArray((), np.int64)
        self._component_of = np.zeros(0, int)  # one entry for each session
        self.session_start = 0
        """Id of the first keyframe of the last session."""
        self.keyframes: list[Keyframe] = []
        self.loops: list[LoopEdge] = []
        """The loop edges, without those of keyframes that have retired, except the first one between two sessions; see
        `lexis.graph.thinning`."""
        self.far_loops = FarLoops()
        """Loops that the current poses rule out; they are not part of the graph."""

    @property
    def T_W_B(self) -> Poses:
        """The current pose estimate.

        Odometry predicts the poses of the keyframes that were added since the last optimisation. The next optimisation
        changes the result in place: copy poses to keep.
        """
        return self._T_W_B.rows

    @property
    def active(self) -> Int[np.ndarray, "k"]:
        """Ids of the keyframes in the optimisation, ascending. The others have retired; see `lexis.graph.thinning`."""
        return self._active.rows

    @property
    def retired(self) -> Int[np.ndarray, "r"]:
        """Ids of the keyframes that have retired, in the order in which they retired."""
        return self._retired.ids

    @property
    def shown_by(self) -> Int[np.ndarray, "n"]:
        """Id of the keyframe whose images stand for those of each keyframe: its anchor if it has retired, or itself."""
        ids = np.arange(len(self.keyframes))
        ids[self._retired.ids] = self._retired.anchors
        return ids

    @property
    def embeddings(self) -> Float32[np.ndarray, "k cameras d"]:
        """CLIP embeddings of the images of the active keyframes, in the order of `active` (f_CLIP in the paper)."""
        return self._embeddings.rows

    def embeddings_of(self, ids: Int[np.ndarray, "m"]) -> Float32[np.ndarray, "m cameras d"]:
        """Return the embeddings of the images of some active keyframes."""
        if np.array_equal(ids, self.active[: len(ids)]):
            return self.embeddings[: len(ids)]  # without a copy
        return np.asarray(self.embeddings[np.searchsorted(self.active, ids)])

    @property
    def path_m(self) -> Float64[np.ndarray, "n"]:
        """Length of the odometry path to each keyframe from the first keyframe of its session [m]."""
        return self._path_m.rows

    @property
    def stamps(self) -> Float64[np.ndarray, "n"]:
        """Stamps of the keyframes [s]."""
        return self._stamps.rows

    @property
    def sessions(self) -> Int[np.ndarray, "n"]:
        """The session of every keyframe."""
        return self._sessions.rows

    @property
    def components(self) -> Int[np.ndarray, "n"]:
        """The component of every keyframe, named by the number of its earliest session."""
        return np.asarray(self._component_of[self._sessions.rows])

    @property
    def is_split(self) -> bool:
        """Whether there are several components."""
        return bool(self._component_of.any())

    def path_between(self, first: int, second: int) -> float:
        """Return the length of the odometry path between two keyframes, over which their estimated relative pose drifts [m].

        For keyframes of two sessions, this is the path from the first keyframe of the second keyframe's session.
        """
        same = self.keyframes[first].session == self.keyframes[second].session
        return float(self.path_m[second] - (self.path_m[first] if same else 0.0))

    @property
    def loop_weights(self) -> Float64[np.ndarray, "loops"]:
        """Weights of the loop edges under the robust kernel at the current estimate, in [0, 1]."""
        return loop_weights(self.T_W_B, self.loops, self._config)

    @property
    def bridged(self) -> Bool[np.ndarray, "n"]:
        """For every keyframe, whether a trusted loop bridges the step of the odometry that leads to it.

        A loop bridges all steps between its two keyframes, if both are of one session. Loops count, too, that were dropped
        because their keyframe retired, if they were trusted then. (`FarLoops` also counts loops that are not trusted.)
        """
        bridged = self._bridged.rows.copy()
        for loop in self._trusted_within_sessions():
            bridged[steps_of(loop)] = True
        return bridged

    def _trusted_within_sessions(self) -> list[LoopEdge]:
        """Return the trusted loop edges between two keyframes of one session."""
        return self.within_sessions(compress(self.loops, is_trusted(self.loop_weights)))

    def add_keyframe(self, keyframe: Keyframe, place: KnownPlace | None = None) -> None:
        """Append a keyframe at the pose that odometry predicts from the pose of the last active keyframe.

        The first keyframe of a session begins a new component, at its odometry pose. With `place`, it joins the component of
        the keyframe `place.beside`, at the given relative pose. The caller must then add the loop edges that connect it,
        because the optimiser knows no other relation. Any other keyframe lies at the given place, too, if there is one.
        """
        T_W_B, covariance = orthonormal(keyframe.T_O_B), keyframe.step_covariance
        if self._optimiser is None or keyframe.session != self.keyframes[-1].session:
            component = keyframe.session
            if place is not None:
                T_W_B = self.T_W_B[place.beside] @ place.T_beside_B
                component = int(self.components[place.beside])
            self._begin_session(keyframe, T_W_B, component)
        else:
            last = int(self.active[-1])
            step, covariance = self._step_from(last, keyframe)
            beside, T_beside_B = (last, step) if place is None else place
            T_W_B = orthonormal(self.T_W_B[beside] @ T_beside_B)
            self._optimiser.add_keyframe(T_W_B, step, covariance)
        self._active.append(len(self.keyframes))
        self._covariances.append(covariance)
        self._embeddings.append(keyframe.embeddings)
        self._append(keyframe, T_W_B)

    def add_retired(self, keyframe: Keyframe, T_anchor_B: Pose) -> None:
        """Append a keyframe that has retired in an earlier run, at a pose relative to its anchor, which is in its component.

        If the anchor has retired in this run, the keyframe is anchored to the anchor's anchor. The keyframe is not the first
        one of its session, because first keyframes do not retire.
        """
        assert keyframe.anchor is not None
        shown_by = self.keyframes[keyframe.anchor]
        anchor, own = shown_by.id, shown_by.anchor
        if own is not None:
            keyframe = as_retired(keyframe, self.keyframes[own])
            T_anchor_B, anchor = between(self.T_W_B[own], self.T_W_B[anchor]) @ T_anchor_B, own
        self._retired.add(keyframe.id, anchor, T_anchor_B)
        self._append(keyframe, self.T_W_B[anchor] @ T_anchor_B)
        if shown_by.session == keyframe.session:  # loops that are gone have told the earlier run that both show one place
            self._bridged.replace(slice(shown_by.id + 1, keyframe.id + 1), True)

    def _append(self, keyframe: Keyframe, T_W_B: Pose) -> None:
        path_m = 0.0
        if self.keyframes and keyframe.session == self.keyframes[-1].session:
            step = between(self.keyframes[-1].T_O_B, keyframe.T_O_B)
            path_m = self.path_m[-1] + np.linalg.norm(step[:3, 3])
        self._path_m.append(path_m)
        self._T_W_B.append(T_W_B)
        self._stamps.append(keyframe.stamp)
        self._sessions.append(keyframe.session)
        self._bridged.append(False)
        self.keyframes.append(keyframe)
        self.far_loops.add_step()

    def _step_from(self, last: int, keyframe: Keyframe) -> tuple[Pose, Covariance]:
        """Return the odometry step from the last active keyframe to a new one, and its covariance.

        There are retired keyframes between both if they have retired in an earlier run.
        """
        first, *others = (*self.keyframes[last + 1 :], keyframe)
        covariance, before = first.step_covariance, first
        for after in others:
            covariance = compose_covariance(covariance, between(before.T_O_B, after.T_O_B), after.step_covariance)
            before = after
        return between(self.keyframes[last].T_O_B, keyframe.T_O_B), covariance

    def _begin_session(self, keyframe: Keyframe, T_W_B: Pose, component: int) -> None:
        if self._optimiser is None:
            self._first = T_W_B if self._first is None else self._first
            self._optimiser = GraphOptimiser(self._first, self._config)
            self._embeddings = GrowingArray(keyframe.embeddings.shape, np.float32)
        else:
            self._optimiser.add_session(T_W_B)
        self._component_of = np.append(self._component_of, component)
        self.session_start = keyframe.id
        self.far_loops.begin_session()

    def resume(
        self,
        keyframes: Sequence[Keyframe],
        T_W_B: Poses,
        loops: Sequence[LoopEdge],
        component_of: Int[np.ndarray, "sessions"],
    ) -> None:
        """Fill an empty graph with keyframes, poses, loops, and the component of every session, from an earlier graph.

        The frame W is that of the poses, which the user may have moved.
        """
        self._first = T_W_B[0].copy()
        for keyframe in keyframes:
            if keyframe.anchor is None:
                self.add_keyframe(keyframe)
            else:
                self.add_retired(keyframe, between(T_W_B[keyframe.anchor], T_W_B[keyframe.id]))
        self._move_to(T_W_B)
        self._component_of = component_of
        self.add_loops(loops)
        self._last_optimised = self._last_whole = self._last_final = _Extent(len(self.keyframes), self._added)

    def join(self, loops: Sequence[LoopEdge], shift: Pose) -> None:
        """Join two components by loop edges that all lead from one component to the other.

        `shift` is the rigid motion that moves the component with the queries of the loops into the frame of the other
        component. The component with the earlier session stays as it is; the other one is moved.
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

    def displace(self, step: int, shift: Pose, loops: Sequence[LoopEdge]) -> None:
        """Move the keyframes from the id `step` on, because the robot was carried elsewhere before it, and add loop edges.

        They are the last keyframes of the last session. The rigid motion `shift` moves them to where the loops see them. The
        odometry step that leads to the first of them becomes unknown.
        """
        unknown = MAX_VARIANCE * np.eye(6)
        self.keyframes[step] = replace(self.keyframes[step], step_covariance=unknown)
        self._covariances[int(np.searchsorted(self.active, step))] = unknown
        T_W_B = self.T_W_B.copy()
        T_W_B[step:] = shift @ T_W_B[step:]
        self._move_to(T_W_B)
        self.add_loops(loops)

    def _move_to(self, T_W_B: Poses) -> None:
        self._T_W_B.replace(np.arange(len(T_W_B)), T_W_B)
        self._retired.follow(T_W_B)
        self._restart()

    def add_loops(self, loops: Sequence[LoopEdge]) -> None:
        """Append verified loop edges; they take effect at the next optimisation.

        Raises LexisError, and appends no edge, unless every edge leads from a keyframe of the graph to an earlier keyframe,
        and has a positive definite covariance.
        """
        check_loops(loops, len(self.keyframes))
        if loops and self._optimiser is not None:
            self._optimiser.add_loops(self._acting(loops))
        self.loops.extend(loops)
        self._added += len(loops)
        self.far_loops.bridge(self.within_sessions(loops))

    def add_far_loops(self, query: int, candidates: Sequence[int], loops: Sequence[LoopEdge]) -> None:
        """Keep verified loops that the current poses rule out, outside the graph; those between two sessions are dropped.

        They are the far loops of the newest keyframe, `query`, which was compared with the candidates.
        """
        self.far_loops.add(query, candidates, self.within_sessions(loops), self.T_W_B)

    def within_sessions(self, loops: Iterable[LoopEdge]) -> list[LoopEdge]:
        """Return the loops whose two keyframes are of one session."""
        return [loop for loop in loops if self.keyframes[loop.query].session == self.keyframes[loop.match].session]

    def optimise_if_due(self, final: bool = False) -> bool:
        """Optimise if there are new loop edges and enough new keyframes (setting `every`) since the last optimisation.

        Most optimisations move only the last keyframes (`window`), but some move the whole graph (`growth`). After an
        optimisation of the whole graph, keyframes that are no longer needed retire (`copies`). These optimisations end early
        (`ROUGHLY`). With `final`, loop edges that are new since the last final optimisation suffice, the whole graph is
        optimised until it has converged, and no keyframe retires. Returns whether the graph was optimised.
        """
        now = _Extent(len(self.keyframes), self._added)
        grown = now.keyframes - self._last_whole.keyframes >= self._config.growth * len(self.active)
        whole = final or grown
        last = self._last_final if final else self._last_optimised
        waited = now.keyframes - last.keyframes >= self._config.every
        if now.loops == last.loops or not (waited or final):
            return False
        assert self._optimiser is not None
        tolerance, window = CONVERGED if final else ROUGHLY, self._config.window
        self._move(self._optimiser.optimise(tolerance) if whole else self._optimiser.optimise_last(window, tolerance))
        self._last_optimised = now
        if whole:
            self._last_whole = now
        if final:
            self._last_final = now
        elif grown:
            self._retire()
        return True

    def _move(self, last: Poses) -> None:
        """Set the poses of the newest active keyframes to `last`, and let retired keyframes follow their anchors.

        A retired keyframe takes no part in the optimisation. It has a fixed pose relative to its anchor, an active keyframe.
        """
        moved = self.active[len(self.active) - len(last) :]
        self._T_W_B.replace(moved, last)
        followers, T_W_B = self._retired.following(int(moved[0]), self.T_W_B)
        if len(followers):
            self._T_W_B.replace(followers, T_W_B)

    def _retire(self) -> None:
        """Let active keyframes before the last `window` ones retire if enough earlier keyframes show their places.

        No keyframe retires while there are several components, because poses of two components cannot be compared. The first
        keyframe of a session stays, because loop edges from it are ignored; so does the last keyframe before it.
        """
        if self._config.copies is None or len(self.active) <= self._config.retire_above or self.is_split:
            return
        old = self.active[: -self._config.window]
        path_m = self.path_m + _SESSION_M * self._sessions.rows
        anchor = anchors(self.T_W_B[old], path_m[old], self._linked(path_m)[old], self._config.copies)
        leaving = np.flatnonzero(anchor != STAYS)
        if not len(leaving):
            return
        for id, new in self._retired.add_all(old[leaving], old[anchor[leaving]], self.T_W_B).items():
            self.keyframes[id] = as_retired(self.keyframes[id], self.keyframes[new])
        self._drop_loops_of_retired()
        self._leave_out(leaving)
        self._restart()

    def _drop_loops_of_retired(self) -> None:
        """Drop the loop edges from keyframes that have retired, and remember the steps that trusted ones bridge."""
        for loop in self._trusted_within_sessions():
            if self.keyframes[loop.query].anchor is not None:
                self._bridged.replace(steps_of(loop), True)
        self.loops = thinned_loops(self.loops, self.keyframes)

    def _linked(self, path_m: Float64[np.ndarray, "n"]) -> Bool[np.ndarray, "n"]:
        """Return which keyframes have a loop edge to an earlier visit that fits the current poses.

        The loop edges of the first keyframe of a session are ignored.
        """
        edges = LoopArrays.of(self.loops)
        T_match_query = between(self.T_W_B[edges.match], self.T_W_B[edges.query])
        linked = np.zeros(len(self.keyframes), bool)
        fitting = fits(T_match_query, edges.T_match_query, path_m[edges.query] - path_m[edges.match])
        linked[edges.query[fitting]] = True
        linked[np.flatnonzero(np.diff(self._sessions.rows, prepend=-1))] = False
        return linked

    def _leave_out(self, rows: Int[np.ndarray, "k"]) -> None:
        """Remove rows of `active`. The odometry steps before and after a removed keyframe become one step.

        The covariance of the new step is composed of the covariances of both.
        """
        for row in rows.tolist():
            step = between(self.keyframes[self.active[row]].T_O_B, self.keyframes[self.active[row + 1]].T_O_B)
            self._covariances[row + 1] = compose_covariance(self._covariances[row], step, self._covariances[row + 1])
        kept = np.delete(np.arange(len(self.active)), rows)
        self._covariances = [self._covariances[row] for row in kept.tolist()]
        ids, embeddings = self.active[kept], self.embeddings[kept]
        self._active, self._embeddings = GrowingArray((), np.int64), GrowingArray(embeddings.shape[1:], np.float32)
        for id, embedding in zip(ids.tolist(), embeddings, strict=True):
            self._active.append(id)
            self._embeddings.append(embedding)

    def _restart(self) -> None:
        """Begin a new optimiser with the active keyframes at their current poses and the loop edges between them."""
        T_O_B = np.stack([self.keyframes[id].T_O_B for id in self.active.tolist()])
        steps, begins = between(T_O_B[:-1], T_O_B[1:]), np.diff(self._sessions.rows[self.active]) > 0
        assert self._first is not None
        self._optimiser = GraphOptimiser(self._first, self._config)
        for id, step, covariance, new in zip(self.active[1:], steps, self._covariances[1:], begins, strict=True):
            if new:
                self._optimiser.add_session(self.T_W_B[id])
            else:
                self._optimiser.add_keyframe(self.T_W_B[id], step, covariance)
        self._optimiser.add_loops(self._acting(self.loops))

    def _acting(self, loops: Sequence[LoopEdge]) -> list[LoopEdge]:
        """Return the loop edges from active keyframes, with rows of `active` in place of ids, as the optimiser needs them.

        An edge to a keyframe that has retired becomes an edge to its anchor.
        """
        held = [self._to_anchor(loop) for loop in loops if self.keyframes[loop.query].anchor is None]
        rows = np.searchsorted(self.active, [(loop.query, loop.match) for loop in held]).reshape(-1, 2).tolist()
        return [replace(loop, query=query, match=match) for loop, (query, match) in zip(held, rows, strict=True)]

    def _to_anchor(self, loop: LoopEdge) -> LoopEdge:
        anchor = self.keyframes[loop.match].anchor
        if anchor is None:
            return loop
        T_anchor_match = between(self.T_W_B[anchor], self.T_W_B[loop.match])
        return replace(loop, match=anchor, T_match_query=T_anchor_match @ loop.T_match_query)
