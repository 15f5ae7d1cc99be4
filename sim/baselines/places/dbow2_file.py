"""Vocabulary trees as text files of DBoW2, which ORB-SLAM2 and ORB-SLAM3 read.

The first line holds the branching, the depth, and two zeros for the L1 score and for tf-idf weights. Every other line is a
node, parents before children: the number of its parent (0 is the root, 1 the node of the first line), 1 for a leaf, the 32
bytes of the descriptor, and the weight of the word.
"""

from collections.abc import Iterator
from pathlib import Path

from lexis.files.replace import replaced_file
from sim.baselines.places.word_tree import WordTree


def write_dbow2(tree: WordTree, path: Path) -> None:
    """Write a vocabulary tree. Raises `LexisError` if the file cannot be written."""
    with replaced_file(path) as new, new.open("w", encoding="ascii", newline="\n") as file:
        file.write(f"{len(tree.levels[0])} {len(tree.levels)} 0 0\n")
        file.writelines(_nodes(tree))


def _nodes(tree: WordTree) -> Iterator[str]:
    """Yield the line of each node, level by level."""
    branching, first_parent, parents = len(tree.levels[0]), 0, 1
    for depth, level in enumerate(tree.levels, 1):
        weights = tree.weights.tolist() if depth == len(tree.levels) else [0.0] * len(level)
        is_leaf = int(depth == len(tree.levels))
        for i, (node, weight) in enumerate(zip(level.tolist(), weights, strict=True)):
            yield f"{first_parent + i // branching} {is_leaf} {' '.join(map(str, node))} {weight:.6g}\n"
        first_parent, parents = first_parent + parents, len(level)
