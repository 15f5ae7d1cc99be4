"""Mistakes in labels: room names, probabilities, visible space and stairs."""

from sim.bench.mutation.planting import Mutant
from worlds.labels import ROOM_LABELS

LABEL_MUTANTS = (
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
        "places = (_SHARES[:, None, None] * ends).reshape(-1, 2)",
        "places = -(_SHARES[:, None, None] * ends).reshape(-1, 2)",
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
        'cameras.sparse_distance_matrix(cKDTree(places), near_m + MILLIONTH, output_type="ndarray")',
        'cameras.sparse_distance_matrix(cKDTree(places), near_m + MILLIONTH, p=np.inf, output_type="ndarray")',
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
        "stairs end half a metre too early",
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
        "stairs = int(is_stairs.argmax())",
        "stairs = len(room_names) - 1",
    ),
    Mutant(
        "the embeddings of the room names are centred around their mean",
        "room_labels.py",
        "images, prompts = embeddings.astype(np.float64), text.astype(np.float64)",
        "images, prompts = embeddings.astype(np.float64), (text - text.mean(axis=0)).astype(np.float64)",
    ),
)
