"""Geometric verification of loop candidates by PnP (paper, Sec. III-D).

For each candidate of a query keyframe:

1. Match the query's key points to the landmarks of the candidate and of its neighbours on the path; one keyframe alone has
   too few landmarks.
2. Find the query's pose by PnP with LO-RANSAC, since many matches are wrong. With a rig, each camera of the query is matched
   to the landmarks of all cameras, so that a rear camera can recognise what a front camera saw. PnP is solved for every
   camera; the pose with which most key points of all cameras agree is refined.
3. Require enough inliers, spread over one image: a poster or another repeated object matches in one spot only.
4. Estimate the covariance of the pose, which says how certain the loop is.
5. Refuse a loop too far from the current estimate, because odometry drifts only little per metre, and least in height. An
   uncertain loop has to be close to the estimate however long the path is. A loop whose inliers cover little of every image
   has to agree with the estimated rotation within `gate_rad`.
6. With the setting `max_contradiction`, refuse loops that contradict other loops of the same query. Neighbouring candidates
   show the same place, so their loops have to lead to the same pose of the query.
7. Keep the loops with the most inliers, up to `max_edges` per query.

The first four steps are in `lexis.locator`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float64

from lexis.config import VerificationConfig
from lexis.graph.pose_estimate import PoseEstimate
from lexis.locator import Locator
from lexis.maths.se3 import between, log, rotation_angle
from lexis.types import Camera, Keyframe, LoopArrays, LoopDecision, LoopEdge, LoopOutcome, Poses

_NEIGHBOURS_M = 3.0
"""Two earlier keyframes are neighbours if the path between them is at most this long [m]."""


@dataclass(frozen=True, eq=False)
class Verification:
    """The loop edges from a new keyframe, and what became of every candidate."""

    edges: tuple[LoopEdge, ...]
    """The confirmed loop edges, those with the most inliers first."""
    decisions: tuple[LoopDecision, ...] = ()
    """One decision for every candidate, in the order of the candidates. A verifier may leave the decisions out."""
    far: tuple[LoopEdge, ...] = ()
    """Edges with a sure pose that were refused, because they are far from the estimate."""


@runtime_checkable
class Verifier(Protocol):
    """A function that confirms or rejects the loop candidates of a new keyframe: `verify`, or one in its place."""

    def __call__(
        self, query: Keyframe, candidates: Sequence[int], graph: PoseEstimate, camera: Camera, config: VerificationConfig, /
    ) -> Verification:
        """Return the confirmed loop edges; see `verify` for the arguments and the result."""
        ...


def verify(
    query: Keyframe, candidates: Sequence[int], graph: PoseEstimate, camera: Camera, config: VerificationConfig
) -> Verification:
    """Return loop edges from a new keyframe to the candidates that pass verification, and a decision on each candidate.

    A candidate passes if PnP confirms the loop and the loop is close enough to the current estimate of the poses.

    Args:
        query: the new keyframe, already in the graph.
        candidates: ids of earlier keyframes.
        graph: the keyframes and the current estimate of their poses.
        camera: the camera of all keyframes.
        config: thresholds, and the largest number of edges to return.
    """
    located = Locator(query, graph.keyframes, camera, config, graph)
    return plausible([located.from_match(match) for match in candidates], graph, config)


def plausible(
    located: Sequence[tuple[LoopDecision, LoopEdge | None]], graph: PoseEstimate, config: VerificationConfig
) -> Verification:
    """Keep the loop edges of one new keyframe that are close to the current estimate of the poses.

    With the setting `max_contradiction`, the edges also have to agree with each other. At most `max_edges` are kept, those
    with the most inliers first.

    Args:
        located: for every candidate, the decision so far, and the loop edge if the candidate has been accepted. An edge
            whose decision does not state the number of cells counts as one that covers enough of the image.
        graph: the current estimate of the poses.
        config: the tolerances, and the largest number of edges.
    """
    judged = [(decision if edge is None else _compared(decision, edge, graph, config), edge) for decision, edge in located]
    fitting = [edge for decision, edge in judged if edge is not None and decision.outcome == "accepted"]
    agreeing = _agreeing(sorted(fitting, key=lambda edge: -edge.inliers), graph, config)
    kept = agreeing[: config.max_edges]
    outcomes: dict[int, LoopOutcome] = {edge.match: "contradicted" for edge in fitting}
    outcomes |= {edge.match: "surplus" for edge in agreeing}
    outcomes |= {edge.match: "accepted" for edge in kept}
    decisions = (replace(decision, outcome=outcomes.get(decision.match, decision.outcome)) for decision, _ in judged)
    refused = (edge for decision, edge in judged if edge is not None and decision.outcome == "far from the estimate")
    far = (edge for edge in refused if not _is_uncertain(edge, config))
    return Verification(tuple(kept), tuple(decisions), tuple(far))


def _compared(decision: LoopDecision, edge: LoopEdge, graph: PoseEstimate, config: VerificationConfig) -> LoopDecision:
    """Refuse a loop that is far from the current estimate.

    The tolerance grows with the path between the two keyframes, as drift does. An uncertain loop must also be close to the
    estimate however long the path is, because it must not correct drift: the covariance of a wrong one is so large that the
    robust kernel would trust it. A loop whose inliers cover little of the images must agree with the estimated rotation,
    because its landmarks have errors in common that rotate the pose around them, and the covariance does not show this.
    """
    measured, estimated = graph.T_W_B[edge.match] @ edge.T_match_query, graph.T_W_B[edge.query]
    path_m = graph.path_between(edge.match, edge.query)
    distance_m = float(np.linalg.norm(measured[:3, 3] - estimated[:3, 3]))
    angle_rad = float(rotation_angle(between(measured, estimated)))
    turned, shifted = angle_rad > config.gate_rad, distance_m >= config.uncertain_gate_m
    few_cells = decision.cells is not None and decision.cells < config.min_cells_turned
    outcome = decision.outcome
    if not within_drift(measured[None], estimated[None], np.array([path_m]), config)[0]:
        outcome = "far from the estimate"
    elif (turned and few_cells) or ((turned or shifted) and _is_uncertain(edge, config)):
        outcome = "uncertain pose"
    return replace(decision, outcome=outcome, misfit_m=distance_m, misfit_rad=angle_rad)


def _is_uncertain(edge: LoopEdge, config: VerificationConfig) -> bool:
    """Whether the rotation or the translation of a loop edge has a large standard deviation in some direction."""
    rotation, translation = (np.linalg.eigvalsh(edge.covariance[part, part])[-1] for part in (slice(0, 3), slice(3, 6)))
    return bool(rotation > config.sure_sigma_rad**2 or translation > config.sure_sigma_m**2)


def _agreeing(edges: Sequence[LoopEdge], graph: PoseEstimate, config: VerificationConfig) -> list[LoopEdge]:
    """Return the loop edges of one query without those that contradict others, in the given order.

    Edges are compared if their earlier keyframes are neighbours on the path of one session (`_NEIGHBOURS_M`), and thus show
    one place. They contradict each other if they lead to poses of the query whose difference is unlikely, given the
    covariances of the edges and the drift of the path between the earlier keyframes. The one of two such edges that has
    more support is kept. The support of an edge is the number of inliers of all compared edges that agree with it, itself
    included. Edges to different places are not compared: the robust kernel, which knows the loops of other queries, decides
    which place is the right one.
    """
    if config.max_contradiction is None or len(edges) < 2:
        return list(edges)
    loops = LoopArrays.of(edges)
    T_W_query = graph.T_W_B[loops.match] @ loops.T_match_query
    off = log(between(T_W_query[:, None], T_W_query[None]))
    matches = loops.match.tolist()
    path_m = np.array([[graph.path_between(min(a, b), max(a, b)) for b in matches] for a in matches])
    drift = path_m[..., None] * np.repeat([config.gate_rad_m, config.gate_share], 3)
    covariance = loops.covariance[:, None] + loops.covariance[None] + drift[..., None] ** 2 * np.eye(6)
    squared = (off * np.linalg.solve(covariance, off[..., None])[..., 0]).sum(axis=-1)
    sessions = graph.sessions[loops.match]
    compared = (path_m <= _NEIGHBOURS_M) & (sessions[:, None] == sessions)
    agree = squared <= config.max_contradiction
    kept: list[int] = []
    for i in np.argsort(-((compared & agree) @ loops.inliers), kind="stable").tolist():
        if not (compared & ~agree)[i, kept].any():
            kept.append(i)
    return [edges[i] for i in sorted(kept)]


def within_drift(
    measured: Poses, estimated: Poses, path_m: Float64[np.ndarray, "k"], config: VerificationConfig
) -> Bool[np.ndarray, "k"]:
    """Whether measured poses differ from estimated ones by no more than odometry drifts over the given lengths of path [m].

    Both kinds of poses are in one frame, whose z axis is vertical.
    """
    off_m = measured[:, :3, 3] - estimated[:, :3, 3]
    near = np.linalg.norm(off_m, axis=1) <= config.gate_m + config.gate_share * path_m
    level = np.abs(off_m[:, 2]) <= config.gate_m + config.gate_height_share * path_m
    turned = rotation_angle(between(measured, estimated)) <= config.gate_rad + config.gate_rad_m * path_m
    return np.asarray(near & level & turned)
