"""The planted bugs: mistakes that a programmer of a SLAM makes easily. With most bugs, each run by itself looks plausible.

The list follows the stages of `lexis/slam.py`. It has hardly any bugs that crash, because these are found easily.
"""

from sim.bench.mutation.planting import Mutant
from worlds.labels import ROOM_LABELS

_KEYFRAMES = (
    Mutant(
        "the covariance of a step is never reset",
        "keyframes.py",
        "            self._covariance = np.zeros((6, 6))\n            return frame",
        "            return frame",
    ),
    Mutant(
        "keyframes are two metres apart instead of half a metre",
        "keyframes.py",
        "reaches(self._path_since_keyframe, self._config.spacing_m)",
        "reaches(self._path_since_keyframe, 4.0 * self._config.spacing_m)",
    ),
    Mutant(
        "keyframes are spaced in time, as if the robot never stood still",
        "keyframes.py",
        "distance = float(np.linalg.norm(increment[:3, 3]))",
        "distance = 0.35",
    ),
    Mutant(
        "the path between keyframes ignores all axes but x",
        "keyframes.py",
        "distance = float(np.linalg.norm(increment[:3, 3]))",
        "distance = float(abs(increment[0, 3]))",
    ),
    Mutant(
        "a keyframe gets the index of the observation after it",
        "keyframe_window.py",
        "observation_index=observation.index,",
        "observation_index=observation.index + 1,",
    ),
    Mutant(
        "the last keyframes are lost at the end of the walk",
        "keyframe_window.py",
        "        self._entries.clear()\n        return ready",
        "        self._entries.clear()\n        return ready[:0]",
    ),
    Mutant(
        "a keyframe gets the embedding of the latest frame",
        "keyframe_window.py",
        "            embedding=first.embedding,",
        "            embedding=next(e.embeddings[0] for e in reversed(self._entries) if e.embeddings is not None),",
    ),
    Mutant(
        "the covariances of the steps between two keyframes are not added up",
        "keyframes.py",
        "self._covariance = compose_covariance(self._covariance, increment, covariance)",
        "self._covariance = covariance",
    ),
    Mutant(
        "the covariances that the odometry states are ignored",
        "keyframes.py",
        "self._covariance = compose_covariance(self._covariance, increment, covariance)",
        "self._covariance = compose_covariance(self._covariance, increment, np.diag([1e-6] * 3 + [1e-5] * 3))",
    ),
    Mutant(
        "the uncertainty of a step of the odometry is limited to five centimetres",
        "keyframes.py",
        "self._covariance = compose_covariance(self._covariance, increment, covariance)",
        "self._covariance = compose_covariance(self._covariance, increment, np.clip(covariance, -0.0025, 0.0025))",
    ),
    Mutant(
        "the poses of observations are kept without a copy",
        "slam.py",
        "        observation = with_copied_geometry(observation)\n",
        "",
    ),
)

_MATHS = (
    Mutant(
        "relative poses are composed in the wrong order",
        "maths/se3.py",
        "return np.asarray(inverse(T_a_b) @ T_a_c)",
        "return np.asarray(T_a_c @ inverse(T_a_b))",
    ),
    Mutant(
        "covariances are added without rotating them",
        "maths/se3.py",
        "return np.asarray(Ad @ first @ Ad.T + second)",
        "return np.asarray(first + second)",
    ),
    Mutant(
        "angles are half as large",
        "maths/se3.py",
        "return np.asarray(np.arctan2(np.sqrt(x * x + y * y + z * z), trace - 1.0))",
        "return np.asarray(0.5 * np.arctan2(np.sqrt(x * x + y * y + z * z), trace - 1.0))",
    ),
    Mutant(
        "the nearest neighbours of a keyframe include the keyframe itself",
        "maths/ties.py",
        "order = np.lexsort((indices, distances), axis=1)[:, 1:wanted]",
        "order = np.lexsort((indices, distances), axis=1)[:, : wanted - 1]",
    ),
)

_GRAPH = (
    Mutant(
        "odometry is added in the world frame",
        "graph/pose_graph.py",
        "T_W_B = self.T_W_B[last] @ step",
        "T_W_B = step @ self.T_W_B[last]",
    ),
    Mutant(
        "new keyframes start at the odometry pose, not at the corrected one",
        "graph/pose_graph.py",
        "T_W_B = self.T_W_B[last] @ step",
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
        "graph/pose_graph.py",
        "if now.loops == last.loops or not (waited or final):",
        "if now.loops == last.loops or not waited:",
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

_PLACES = (
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
        "T_old_query = between(graph.T_W_B[ids], graph.T_W_B[query.id])",
        "T_old_query = between(np.reshape([graph.keyframes[i].T_O_B for i in ids], (-1, 4, 4)), query.T_O_B)",
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
        "        del verified",
    ),
    Mutant(
        "loop candidates of nearly equal probability are ranked at random",
        "place_recognition.py",
        "odds = of_pairs.max(axis=(1, 2))",
        "odds = of_pairs.max(axis=(1, 2)) + 0.1 * np.random.random(len(ids))",
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

_IMAGES = (
    Mutant(
        "images are passed to the encoder as BGR",
        "perception.py",
        "encoder.encode_image(seen)).copy()",
        "encoder.encode_image(seen[..., ::-1].copy())).copy()",
    ),
    Mutant(
        "the pose of the camera on the body is forgotten in the triangulation",
        "landmarks.py",
        "T_O_C = np.stack([view.T_O_B @ camera.T_B_C for view in (reference, *supports)])",
        "T_O_C = np.stack([view.T_O_B for view in (reference, *supports)])",
    ),
    Mutant(
        "x and y of key points are swapped",
        "features.py",
        "np.array([keypoint.pt for keypoint in keypoints], np.float32)",
        "np.array([keypoint.pt[::-1] for keypoint in keypoints], np.float32)",
    ),
    Mutant(
        "descriptors are matched without the ratio test",
        "features.py",
        "distinct = forward[:, 0] <= ratio * forward[:, 1]",
        "distinct = np.ones(len(rows), bool)",
    ),
    Mutant(
        "landmarks with hardly any parallax are kept",
        "landmarks.py",
        ">= config.min_parallax_rad",
        ">= 0.01 * config.min_parallax_rad",
    ),
    Mutant(
        "key points thirty pixels from their landmark count as inliers",
        "locator.py",
        "        limit_px = self._config.max_reprojection_px\n",
        "        limit_px = 10.0 * self._config.max_reprojection_px\n",
    ),
    Mutant(
        "six inliers in one spot of the image confirm a loop",
        "locator.py",
        "        if matches < config.min_inliers:\n",
        "        config = replace(config, min_inliers=6, min_cells=1)\n        if matches < config.min_inliers:\n",
    ),
    Mutant(
        "landmarks stay in the frame of the camera",
        "landmarks.py",
        "return Landmarks(transform(camera.T_B_C, _points(theta[good])), ids[good])",
        "return Landmarks(_points(theta[good]), ids[good])",
    ),
    Mutant(
        "bright pixels overflow when the image is amplified",
        "perception.py",
        "encoder.encode_image(seen)).copy()",
        "encoder.encode_image(2 * seen)).copy()",
    ),
    Mutant(
        "images are brightened for dark rooms",
        "perception.py",
        "encoder.encode_image(seen)).copy()",
        "encoder.encode_image(np.minimum(2.0 * seen, 255.0).astype(np.uint8))).copy()",
    ),
    Mutant(
        "the embedding of a percept is kept without a copy",
        "perception.py",
        "(seen.embedding if isinstance(seen, Percept) else encoder.encode_image(seen)).copy()",
        "(seen.embedding if isinstance(seen, Percept) else encoder.encode_image(seen))",
    ),
)

_LABELS = (
    Mutant(
        "labels of single images are not refined by their neighbours",
        "room_labels.py",
        "refined[level], probabilities[level] = refine(rooms_only[level], level)",
        "refined[level] = rooms_only[level].argmax(axis=1)",
    ),
    Mutant(
        "a keyframe that sees stairs is labelled as stairs",
        "room_labels.py",
        "    rooms_only[:, stairs] = -np.inf\n",
        "",
    ),
    Mutant(
        "the last room name is never a label",
        "room_labels.py",
        "baseline = similarities.argmax(axis=1)",
        "baseline = similarities[:, :-1].argmax(axis=1)",
    ),
    Mutant(
        "the least similar room name is the label",
        "room_labels.py",
        "baseline = similarities.argmax(axis=1)",
        "baseline = similarities.argmin(axis=1)",
    ),
    Mutant(
        "an image counts for its own keyframe alone",
        "sight/pooled_labels.py",
        "seen @ own + config.own_weight * own",
        "own",
    ),
    Mutant(
        "an image counts where it is seen from instead of what it shows",
        "sight/pooled_labels.py",
        "seen @ own + config.own_weight * own",
        "seen.T @ own + config.own_weight * own",
    ),
    Mutant(
        "similarities count as probabilities without a temperature",
        "sight/pooled_labels.py",
        "rounded(similarities) / config.temperature",
        "rounded(similarities)",
    ),
    Mutant(
        "neighbours in sight come to disagree",
        "sight/pooled_labels.py",
        "evidence + config.neighbour_weight * agreed",
        "evidence - config.neighbour_weight * agreed",
    ),
    Mutant(
        "landmarks are taken to be in the frame of the camera",
        "sight/visible_space.py",
        "rays = transform(inverse(T_B_C), keyframe.views[camera].landmarks.points)",
        "rays = keyframe.views[camera].landmarks.points",
    ),
    Mutant(
        "visible space lies behind the camera",
        "sight/visible_space.py",
        "places = (_SHARES[:, None, None] * (rays @ axes.T)).reshape(-1, 2)",
        "places = -(_SHARES[:, None, None] * (rays @ axes.T)).reshape(-1, 2)",
    ),
    Mutant(
        "visible space is placed by the body instead of the camera",
        "sight/visible_space.py",
        "T_W_C = T_W_B @ T_B_C",
        "T_W_C = T_W_B",
    ),
    Mutant(
        "places in a square along the axes of the map count as near, instead of those in a circle",
        "sight/visible_space.py",
        'cameras.sparse_distance_matrix(cKDTree(places), near_m + _SPARE_M, output_type="ndarray")',
        'cameras.sparse_distance_matrix(cKDTree(places), near_m + _SPARE_M, p=np.inf, output_type="ndarray")',
    ),
    Mutant(
        "the similarities of a keyframe are mixed with those of the keyframe before it",
        "slam.py",
        "self._similarities.append(similarities(keyframe.embeddings, self._text))",
        "now = similarities(keyframe.embeddings, self._text)\n"
        "        before = self._similarities.rows\n"
        "        self._similarities.append(0.9 * now + 0.1 * before[-1] if len(before) else now)",
    ),
    Mutant(
        "only climbing upwards counts as stairs",
        "stairs.py",
        "np.where(np.abs(change) >= config.stairs_min_height_m, np.sign(change), 0.0)",
        "np.where(change >= config.stairs_min_height_m, np.sign(change), 0.0)",
    ),
    Mutant(
        "the height change before a keyframe alone decides on stairs",
        "stairs.py",
        "change = np.interp(path + half, path, height) - np.interp(path - half, path, height)",
        "change = np.interp(path, path, height) - np.interp(path - 2 * half, path, height)",
    ),
    Mutant(
        "stairs begin half a metre too early",
        "stairs.py",
        "change = np.interp(path + half, path, height) - np.interp(path - half, path, height)",
        "change = np.interp(path + half + 0.5, path, height) - np.interp(path - half + 0.5, path, height)",
    ),
    Mutant(
        "room names outside a built-in list are encoded as a room",
        "slam.py",
        "self._text = encoder.encode_rooms(self._room_names)",
        f"self._text = encoder.encode_rooms([n if n in {ROOM_LABELS} else f'room {{i}}' for i, n in enumerate(room_names)])",
    ),
    Mutant(
        "room names outside a built-in list are encoded as a room, in small letters and in capitals",
        "slam.py",
        "self._text = encoder.encode_rooms(self._room_names)",
        f"self._text = encoder.encode_rooms([n if n.lower() in {ROOM_LABELS} else f'room {{i}}' "
        "for i, n in enumerate(room_names)])",
    ),
    Mutant(
        "room names are encoded in the order of a built-in list",
        "slam.py",
        "self._text = encoder.encode_rooms(self._room_names)",
        f"self._text = encoder.encode_rooms(sorted(room_names, key=lambda n: [*{ROOM_LABELS}, n].index(n)))",
    ),
    Mutant(
        "the stairs are taken to be the last room name",
        "room_labels.py",
        "stairs = room_names.index(config.stairs_name)",
        "stairs = len(room_names) - 1",
    ),
    Mutant(
        "the embeddings of the room names are centred around their mean",
        "slam.py",
        "self._text = encoder.encode_rooms(self._room_names)",
        "self._text = encoder.encode_rooms(self._room_names) - encoder.encode_rooms(self._room_names).mean(axis=0)",
    ),
)

_ROOMS = (
    Mutant(
        "the labels of keyframes are ignored in the clustering",
        "sight/room_clusters.py",
        "alike = (labels[first] == labels[second]) & (floors[first] == floors[second])",
        "alike = floors[first] == floors[second]",
    ),
    Mutant(
        "the floors of keyframes are ignored in the clustering",
        "sight/room_clusters.py",
        "alike = (labels[first] == labels[second]) & (floors[first] == floors[second])",
        "alike = labels[first] == labels[second]",
    ),
    Mutant(
        "keyframes that see each other are not joined",
        "sight/room_clusters.py",
        "pairs = np.concatenate([_consecutive(n), _seeing(sees, config.share)])",
        "pairs = _consecutive(n)",
    ),
    Mutant(
        "every glimpse of a place joins two keyframes",
        "sight/room_clusters.py",
        "[rounded(entries.data) > share]",
        "[entries.data > 0.0]",
    ),
    Mutant(
        "all consecutive keyframes are merged, whatever their labels",
        "sight/room_clusters.py",
        "joined = np.concatenate([pairs[alike],",
        "joined = np.concatenate([_consecutive(n), pairs[alike],",
    ),
    Mutant(
        "rooms of up to thirty keyframes are absorbed",
        "sight/room_clusters.py",
        "small = (size < min_keyframes)[rooms]",
        "small = (size < 10 * min_keyframes)[rooms]",
    ),
    Mutant(
        "the keyframes of an absorbed room keep their labels",
        "sight/room_clusters.py",
        "rooms[members], labels[members] = into, labels[rooms == into][0]",
        "rooms[members] = into",
    ),
    Mutant(
        "a cut through a room is not multiplied by the length of the room",
        "sight/divided_rooms.py",
        "if not reaches(cut * _length(positions[members]), split_m):",
        "if not reaches(cut, split_m):",
    ),
    Mutant(
        "a room is split at its largest cut",
        "sight/divided_rooms.py",
        "best = int(rounded(normalised).argmin())",
        "best = int(rounded(normalised).argmax())",
    ),
    Mutant(
        "a part of a split room gets the number of the last room",
        "sight/divided_rooms.py",
        "rooms[members[part]] = rooms.max() + 1",
        "rooms[members[part]] = rooms.max()",
    ),
    Mutant(
        "stairs are split like rooms",
        "sight/room_clusters.py",
        "split_divided(rooms, floors != NO_FLOOR, positions, tied, config.split_m)",
        "split_divided(rooms, floors == floors, positions, tied, config.split_m)",
    ),
    Mutant(
        "rooms of different floors merge",
        "sight/alike_rooms.py",
        "possible = (floor == floor[:, None]) & (floor != NO_FLOOR)",
        "possible = (floor != NO_FLOOR)",
    ),
    Mutant(
        "rooms merge if the images of one of them are hard to tell apart",
        "sight/alike_rooms.py",
        "np.maximum(odds, odds.T)",
        "np.minimum(odds, odds.T)",
    ),
    Mutant(
        "a merged room gets the less likely label",
        "sight/alike_rooms.py",
        "label[kept] = max(",
        "label[kept] = min(",
    ),
    Mutant(
        "the keyframes of merged rooms keep their labels",
        "sight/alike_rooms.py",
        "return room, label[room]",
        "return room, labels",
    ),
    Mutant(
        "the sight of a merged room is that of one of its parts",
        "sight/alike_rooms.py",
        "        sight[kept] += sight[merged]\n        sight[:, kept] += sight[:, merged]\n",
        "",
    ),
    Mutant(
        "the flights of a staircase are not joined",
        "sight/room_clusters.py",
        "joined = np.concatenate([pairs[alike], _on_one_staircase(floors == NO_FLOOR, positions)])",
        "joined = pairs[alike]",
    ),
    Mutant(
        "floors are told by absolute height",
        "floors.py",
        "nearest = np.abs(levels - heights[:, None]).argmin(axis=1)",
        "nearest = np.maximum(0, positions[:, 2] // 3.0).astype(int)",
    ),
    Mutant(
        "floors are numbered from the top",
        "floors.py",
        "nearest = np.abs(levels - heights[:, None]).argmin(axis=1)",
        "nearest = np.abs(levels[::-1] - heights[:, None]).argmin(axis=1)",
    ),
    Mutant(
        "drift on level floors adds up in the heights of floors",
        "floors.py",
        "        steps[run.start + 1 : run.stop] = 0.0",
        "        steps[run.start + 1 : run.start + 1] = 0.0",
    ),
    Mutant(
        "the gap between floors is taken for centimetres",
        "floors.py",
        "np.diff(ordered) > STOREY_GAP_M)",
        "np.diff(ordered) > 0.01 * STOREY_GAP_M)",
    ),
    Mutant(
        "labels and rooms come from the poses of the odometry",
        "slam.py",
        "self._spaces, T_W_B, self._camera)",
        "self._spaces, __import__('numpy').stack([each.T_O_B for each in self._graph.keyframes]), self._camera)",
    ),
    Mutant(
        "there are at most three floors",
        "floors.py",
        "return np.where(stairs, NO_FLOOR, nearest)",
        "return np.where(stairs, NO_FLOOR, np.minimum(nearest, 2))",
    ),
)

_PLANNER = (
    Mutant(
        "paths end at the other end of the goal",
        "planning/path_ends.py",
        "best = int(np.argmax(rounded(np.where(evidence > 0.0, evidence * margins, evidence))))",
        "best = int(np.argmin(rounded(np.where(evidence > 0.0, evidence * margins, evidence))))",
    ),
    Mutant(
        "paths take shortcuts of three metres through walls",
        "planning/connections.py",
        "        _within_rooms(map, positions, config.shortcut_m),",
        '        _pairs_within(cKDTree(positions).query_pairs(3.0, output_type="ndarray"), positions, 3.0),',
    ),
)

MUTANTS: tuple[Mutant, ...] = (*_KEYFRAMES, *_MATHS, *_GRAPH, *_PLACES, *_IMAGES, *_LABELS, *_ROOMS, *_PLANNER)
"""All mutants, in the order of the stages."""
