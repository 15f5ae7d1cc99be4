"""Mistakes in rooms, in floors, and in the plans from room to room."""

from sim.bench.mutation.planting import Mutant

ROOM_MUTANTS = (
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
        "pairs = np.concatenate([walked, _seeing(seen_by, config.share)])",
        "pairs = walked",
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
        "joined = np.concatenate([walked, pairs[alike],",
    ),
    Mutant(
        "rooms of up to thirty keyframes are absorbed",
        "sight/room_clusters.py",
        "small = (size < min_keyframes)[rooms]",
        "small = (size < 10 * min_keyframes)[rooms]",
    ),
    Mutant(
        "the keyframes of absorbed and merged rooms keep their labels",
        "sight/room_clusters.py",
        "    rooms, labels = _absorbed(rooms, labels, floors, seen_by, config.min_keyframes)\n"
        "    return merge_alike(rooms, labels, floors, probabilities, tied, open_steps, config)",
        "    rooms, absorbed = _absorbed(rooms, labels, floors, seen_by, config.min_keyframes)\n"
        "    return merge_alike(rooms, absorbed, floors, probabilities, tied, open_steps, config)[0], labels",
    ),
    Mutant(
        "a cut through a room is not multiplied by the length of the room",
        "sight/divided_rooms.py",
        "narrow = not reaches(cut * _length(positions[members]), config.split_m)",
        "narrow = not reaches(cut, config.split_m)",
    ),
    Mutant(
        "a room is split at its largest cut",
        "sight/divided_rooms.py",
        "best = int(rounded(normalised).argmin())",
        "best = int(rounded(normalised).argmax())",
    ),
    Mutant(
        "stairs are split like rooms",
        "sight/room_clusters.py",
        "split_divided(rooms, floors != NO_FLOOR, positions, tied, past_passages, config)",
        "split_divided(rooms, floors == floors, positions, tied, past_passages, config)",
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
        "(unclear & unclear.T)",
        "(unclear | unclear.T)",
    ),
    Mutant(
        "a merged room gets the less likely label",
        "sight/alike_rooms.py",
        "label[kept] = max(",
        "label[kept] = min(",
    ),
    Mutant(
        "the sight of a merged room is that of one of its parts",
        "sight/alike_rooms.py",
        "            between[kept] += between[merged]\n            between[:, kept] += between[:, merged]\n",
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
        "self._spaces, T_W_B, self._camera,",
        "self._spaces, __import__('numpy').stack([each.T_O_B for each in self._graph.keyframes]), self._camera,",
    ),
    Mutant(
        "there are at most three floors",
        "floors.py",
        "return np.where(stairs, NO_FLOOR, nearest)",
        "return np.where(stairs, NO_FLOOR, np.minimum(nearest, 2))",
    ),
    Mutant(
        "paths end at the other end of the goal",
        "planning/path_ends.py",
        "best = int(np.argmax(rounded(np.where(evidence > 0.0, evidence * margins, evidence))))",
        "best = int(np.argmin(rounded(np.where(evidence > 0.0, evidence * margins, evidence))))",
    ),
    Mutant(
        "paths take shortcuts of three metres through walls",
        "planning/connections.py",
        "        _within_rooms(map, config.shortcut_m),",
        "        close_pairs(map, np.ones(len(positions), bool), 3.0),",
    ),
)
