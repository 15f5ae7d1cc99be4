"""A vocabulary tree as a text file: a reader that follows DBoW2's rules finds the same words with the same weights."""

import numpy as np
import pytest

from sim.baselines.places.dbow2_file import write_dbow2
from sim.baselines.places.word_tree import WordTree
from sim.cli import main


def loaded(path):
    """The children of each node, and each node's descriptor and weight, as DBoW2 reads them."""
    head, *rows = path.read_text().splitlines()
    children, nodes = {0: []}, {}
    for number, row in enumerate(rows, 1):
        parent, leaf, *values = row.split()
        children[int(parent)].append(number)
        if leaf == "0":
            children[number] = []
        nodes[number] = np.array(values[:-1], np.uint8), float(values[-1])
    return head, children, nodes


def test_every_descriptor_descends_to_the_word_of_the_tree(rng, tmp_path):
    images = [rng.integers(0, 256, (150, 32), np.uint8) for _ in range(4)]
    tree = WordTree.learned(images, rng, branching=4, depth=3)
    write_dbow2(tree, tmp_path / "words.txt")
    head, children, nodes = loaded(tmp_path / "words.txt")
    assert head == "4 3 0 0" and len(nodes) == 4 + 16 + 64
    assert all(len(each) == 4 for each in children.values())
    leaves = [number for number in nodes if number not in children]
    descriptors = np.concatenate(images)[::7]
    for descriptor, word in zip(descriptors, tree.words(descriptors).tolist(), strict=True):
        node = 0
        while node in children:
            bits = [int(np.bitwise_count(descriptor ^ nodes[child][0]).sum()) for child in children[node]]
            node = children[node][int(np.argmin(bits))]
        assert leaves.index(node) == word
        np.testing.assert_allclose(nodes[node][1], tree.weights[word], rtol=1e-5)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--branching", "1"], "valid: a whole number from 2 to 20"),
        (["--depth", "9"], "valid: a whole number from 1 to 6"),
        (["--branching", "20", "--depth", "6"], "20 to the power of 6 words; valid: up to 1000000"),
    ],
)
def test_vocabularies_that_cannot_be_are_refused_before_the_work(options, message, tmp_path, capsys):
    try:
        status = main(["orb-vocabulary", *options, "-o", str(tmp_path / "words.txt")])
    except SystemExit as end:
        status = end.code
    assert status == 2 and message in capsys.readouterr().err
