"""g2o files: what is read has the costs that GTSAM finds, and defective files are refused with the number of the line."""

import gtsam
import numpy as np
import pytest

from lexis.errors import LexisError
from lexis.files.g2o import read_g2o
from lexis.maths.se3 import log
from lexis.types import LoopEdge

INFORMATION = "20 1 0 0 0 0 30 0 0 0 2 40 0 0 0 200 5 0 300 0 400"
FILE = f"""\
VERTEX_SE3:QUAT 10 1 0 0 0 0 0 1
VERTEX_SE3:QUAT 3 0 0 0 0 0 0 1
VERTEX_SE3:QUAT 11 1 1 0 0 0 0.6 0.8
FIX 3
EDGE_SE3:QUAT 3 10 1.1 0.1 0 0 0 0 1 {INFORMATION}
EDGE_SE3:QUAT 11 10 -0.3 0.9 0.1 0.1 0 0 0.994987 {INFORMATION}
"""


def whitened(edge: LoopEdge, poses):
    error = log(np.linalg.inv(edge.T_match_query) @ np.linalg.inv(poses[edge.match]) @ poses[edge.query])
    return error @ np.linalg.solve(edge.covariance, error) / 2


def test_every_edge_has_the_cost_that_gtsam_finds_whichever_way_it_is_written(tmp_path):
    path = tmp_path / "tiny.g2o"
    path.write_text(FILE)
    graph, (factors, values) = read_g2o(path), gtsam.readG2o(str(path), True)
    assert [(edge.match, edge.query) for edge in graph.edges] == [(0, 1), (1, 2)]
    costs = [whitened(edge, graph.T_W_B) for edge in graph.edges]
    np.testing.assert_allclose(costs, [factors.at(k).error(values) for k in range(2)], rtol=1e-5)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (FILE, "", "no vertex"),
        ("QUAT 10 1", "QUAT 3 1", "an id twice"),
        ("0.6 0.8", "0.6 0.9", "line 3: the quaternion"),
        ("EDGE_SE3:QUAT 11 10", "EDGE_SE3:QUAT 11 12", "line 6: an edge needs"),
        ("EDGE_SE3:QUAT 11 10", "EDGE_SE3:QUAT 11 11", "line 6: an edge needs"),
        ("EDGE_SE3:QUAT 3 10 1.1", "EDGE_SE3:QUAT 3 10", "line 5: EDGE_SE3:QUAT with 29 words"),
        ("EDGE_SE3:QUAT 3 10 1.1", "EDGE_SE3:QUAT 3 10 inf", "line 5"),
        ("VERTEX_SE3:QUAT 10 1 0", "VERTEX_SE2 10 1 0", "line 1: VERTEX_SE2"),
        (f"1 {INFORMATION}", f"1 {INFORMATION.replace('300', '-300')}", "line 5: the information matrix"),
    ],
)
def test_defective_files_are_refused(old, new, says, tmp_path):
    path = tmp_path / "tiny.g2o"
    path.write_text(FILE.replace(old, new, 1))
    with pytest.raises(LexisError, match=says):
        read_g2o(path)
