"""Mistakes in the pose graph: its edges, their covariances, the robust kernel and the optimisation."""

from sim.bench.mutation.planting import Mutant

GRAPH_MUTANTS = (
    Mutant(
        "odometry is added in the world frame",
        "graph/pose_graph.py",
        "T_W_B = orthonormal(self.T_W_B[beside] @ T_beside_B)",
        "T_W_B = orthonormal(T_beside_B @ self.T_W_B[beside])",
    ),
    Mutant(
        "new keyframes start at the odometry pose, not at the corrected one",
        "graph/pose_graph.py",
        "T_W_B = orthonormal(self.T_W_B[beside] @ T_beside_B)",
        "T_W_B = keyframe.T_O_B",
    ),
    Mutant(
        "the graph is never optimised",
        "graph/pose_graph.py",
        "if now.loops == last.loops or not (waited or final):",
        "if True:",
    ),
    Mutant(
        "the last loops are not used, because the final optimisation is forgotten",
        "slam.py",
        "        self._optimise(final=True)\n        self._correct_kidnapping()\n",
        "        self._correct_kidnapping()\n",
    ),
    Mutant(
        "the newest keyframe of the map has the pose of the odometry",
        "slam.py",
        "        semantics = self._derive_semantics(T_W_B)\n        return LexisMap(",
        "        T_W_B[-1] = self._graph.keyframes[-1].T_O_B\n"
        "        semantics = self._derive_semantics(T_W_B)\n        return LexisMap(",
    ),
    Mutant(
        "the newest keyframe of the map has the orientation of the odometry",
        "slam.py",
        "        semantics = self._derive_semantics(T_W_B)\n        return LexisMap(",
        "        T_W_B[-1, :3, :3] = self._graph.keyframes[-1].T_O_B[:3, :3]\n"
        "        semantics = self._derive_semantics(T_W_B)\n        return LexisMap(",
    ),
    Mutant(
        "the optimised poses are thrown away",
        "graph/pose_graph.py",
        "self._move(self._optimiser.optimise(tolerance) if whole else self._optimiser.optimise_last(window, tolerance))",
        "self._optimiser.optimise()",
    ),
    Mutant(
        "stamps are taken for milliseconds",
        "graph/pose_graph.py",
        "self._stamps.append(keyframe.stamp)",
        "self._stamps.append(1000.0 * keyframe.stamp)",
    ),
    Mutant(
        "the path of the graph counts the displacement along x only",
        "graph/pose_graph.py",
        "np.linalg.norm(step[:3, 3])",
        "abs(step[0, 3])",
    ),
    Mutant(
        "loop edges have no robust kernel",
        "graph/graph_optimisation.py",
        "noise = gtsam.noiseModel.Robust.Create(self._kernel, plain)",
        "noise = plain",
    ),
    Mutant(
        "loop edges are added the wrong way round",
        "graph/graph_optimisation.py",
        "gtsam.BetweenFactorPose3(loop.match, loop.query, gtsam.Pose3(loop.T_match_query), noise)",
        "gtsam.BetweenFactorPose3(loop.query, loop.match, gtsam.Pose3(loop.T_match_query), noise)",
    ),
    Mutant(
        "rotation and translation are swapped in the covariances of loops",
        "graph/graph_optimisation.py",
        "gtsam.noiseModel.Gaussian.Covariance(loop.covariance)",
        "gtsam.noiseModel.Gaussian.Covariance(np.roll(loop.covariance, 3, (0, 1)))",
    ),
    Mutant(
        "the covariances of the odometry are taken for information matrices",
        "graph/graph_optimisation.py",
        "noise = gtsam.noiseModel.Gaussian.Covariance(covariance + self._min_covariance)",
        "noise = gtsam.noiseModel.Gaussian.Information(covariance + self._min_covariance)",
    ),
    Mutant(
        "every optimisation stops after one iteration",
        "graph/graph_optimisation.py",
        "parameters.setMaxIterations(self._config.max_iterations)",
        "parameters.setMaxIterations(1)",
    ),
    Mutant(
        "the threshold of the robust kernel is squared",
        "graph/graph_optimisation.py",
        "return gtsam.noiseModel.mEstimator.DCS.Create(config.outlier_threshold)",
        "return gtsam.noiseModel.mEstimator.DCS.Create(config.outlier_threshold**2)",
    ),
)
