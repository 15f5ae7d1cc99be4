"""Mistakes in the proposal of loop candidates, and in the decision which loops are trusted."""

from sim.bench.mutation.planting import Mutant

PLACE_MUTANTS = (
    Mutant(
        "the probability of a revisit ignores the estimated poses",
        "place_recognition.py",
        "- np.minimum(misplaced, config.lost_log_odds)",
        "- 0.0 * misplaced",
    ),
    Mutant(
        "the probability of a revisit grows with the distance from the estimate",
        "place_recognition.py",
        "- np.minimum(misplaced, config.lost_log_odds)",
        "+ np.minimum(misplaced, config.lost_log_odds)",
    ),
    Mutant(
        "the probability of a revisit ignores the direction of view",
        "place_recognition.py",
        " + (angles_rad / config.place_rad) ** 2",
        "",
    ),
    Mutant(
        "all old keyframes count as likely revisits",
        "place_recognition.py",
        "if not (odds >= least).any():",
        "if not len(odds):",
    ),
    Mutant(
        "the least likely candidates are proposed",
        "place_recognition.py",
        'np.argsort(-odds, kind="stable")',
        'np.argsort(odds, kind="stable")',
    ),
    Mutant(
        "only one loop candidate is proposed",
        "place_recognition.py",
        'np.argsort(-odds, kind="stable")[: config.candidates]',
        'np.argsort(-odds, kind="stable")[: min(1, config.candidates)]',
    ),
    Mutant(
        "the previous keyframes count as old enough for a loop",
        "place_recognition.py",
        "reaches(seconds, config.min_gap_s) & reaches(metres, config.min_gap_m) & (seconds > 0)",
        "(seconds > 0)",
    ),
    Mutant(
        "places are compared by odometry poses instead of corrected ones",
        "place_recognition.py",
        "T_old_query = between(graph.T_W_B[ids, None], T_W_query)",
        "T_old_query = between(np.reshape([graph.keyframes[i].T_O_B for i in ids], (-1, 1, 4, 4)), query.T_O_B[None])",
    ),
    Mutant(
        "loops are not compared with the current estimate",
        "verification.py",
        "return np.asarray(near & level & turned)",
        "return np.ones(len(path_m), bool)",
    ),
    Mutant(
        "the heights of loops are not compared with the estimate",
        "verification.py",
        "return np.asarray(near & level & turned)",
        "return np.asarray(near & turned)",
    ),
    Mutant(
        "the largest distance of a loop from the estimate is taken for centimetres",
        "verification.py",
        "near = np.linalg.norm(off_m, axis=1) <= config.gate_m + config.gate_share * path_m",
        "near = np.linalg.norm(off_m, axis=1) <= 0.01 * (config.gate_m + config.gate_share * path_m)",
    ),
    Mutant(
        "loops that turn the estimate count even if their inliers lie in a small part of the image",
        "verification.py",
        "few_cells = decision.cells is not None and decision.cells < config.min_cells_turned",
        "few_cells = False",
    ),
    Mutant(
        "uncertain loops that contradict the estimate count",
        "verification.py",
        "((turned or shifted) and _is_uncertain(edge, config))",
        "False",
    ),
    Mutant(
        "the weights of loops are those of the odometry's poses",
        "graph/pose_graph.py",
        "return loop_weights(self.T_W_B, self.loops, self._config)",
        "return loop_weights(np.stack([each.T_O_B for each in self.keyframes]), self.loops, self._config)",
    ),
    Mutant(
        "all loops count as trusted",
        "graph/pose_graph.py",
        "return loop_weights(self.T_W_B, self.loops, self._config)",
        "return np.full(len(self.loops), 0.9)",
    ),
    Mutant(
        "the loops with the fewest inliers are kept",
        "verification.py",
        "key=lambda edge: -edge.inliers",
        "key=lambda edge: edge.inliers",
    ),
    Mutant(
        "PnP returns the pose of the camera instead of the body",
        "locator.py",
        "T_match_query = inverse(fit.T_C_match[0]) @ inverse(self._camera.T_B_C)",
        "T_match_query = inverse(fit.T_C_match[0])",
    ),
    Mutant(
        "landmarks of neighbouring keyframes are not moved into the frame of the candidate",
        "locator.py",
        "found[camera].append((pairs[:, 0], transform(T_match_neighbour, points)))",
        "found[camera].append((pairs[:, 0], points))",
    ),
    Mutant(
        "verified loops are not added to the graph",
        "slam.py",
        "        self._graph.add_loops(verified.edges)",
        "        self._graph.add_loops(verified.edges[:0])",
    ),
    Mutant(
        "loop candidates of nearly equal probability are ranked at random",
        "place_recognition.py",
        "odds = of_pairs.max(axis=(1, 2, 3))",
        "odds = of_pairs.max(axis=(1, 2, 3)) + 0.1 * np.random.random(len(ids))",
    ),
    Mutant(
        "stamps are kept in single precision",
        "graph/pose_graph.py",
        "self._stamps.append(keyframe.stamp)",
        "self._stamps.append(np.float32(keyframe.stamp))",
    ),
    Mutant(
        "time alone makes a keyframe old enough for a loop, without any path",
        "place_recognition.py",
        "reaches(seconds, config.min_gap_s) & reaches(metres, config.min_gap_m) & (seconds > 0)",
        "reaches(seconds, config.min_gap_s) & (seconds > 0)",
    ),
    Mutant(
        "places are forgotten after two and a half minutes",
        "place_recognition.py",
        "reaches(seconds, config.min_gap_s) & reaches(metres, config.min_gap_m) & (seconds > 0)",
        "reaches(seconds, config.min_gap_s) & reaches(metres, config.min_gap_m) & (seconds > 0) & (seconds < 150.0)",
    ),
    Mutant(
        "the difference between a loop and the estimate counts with its sign",
        "verification.py",
        "near = np.linalg.norm(off_m, axis=1) <= config.gate_m + config.gate_share * path_m",
        "near = off_m.max(axis=1) <= config.gate_m + config.gate_share * path_m",
    ),
)
