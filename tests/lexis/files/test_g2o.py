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
        (FILE, "", "tiny.g2o: cannot be used: holds no vertex; valid: a line 'VERTEX_SE3:QUAT id x y z qx qy qz qw'"),
        ("QUAT 10 1", "QUAT 3 1", "line 2: vertex 3 is given twice, first in line 1; valid: each id once"),
        ("QUAT 11 1 1", "QUAT 10.0 1 1", "line 3: vertex 10.0 is given twice, first in line 1"),
        ("0.6 0.8", "0.6 0.9", "line 3: the quaternion has norm 1.08; valid: a unit quaternion"),
        ("0.6 0.8", "0 0", "line 3: the quaternion has norm 0; valid: a unit quaternion"),
        ("EDGE_SE3:QUAT 11 10", "EDGE_SE3:QUAT 11 12", "line 6: an edge needs .*, and not 11 and 12; valid: "),
        ("EDGE_SE3:QUAT 11 10", "EDGE_SE3:QUAT 11 11", "line 6: an edge needs .*, and not 11 and 11; valid: "),
        ("EDGE_SE3:QUAT 3 10 1.1", "EDGE_SE3:QUAT 3 10", "line 5: EDGE_SE3:QUAT with 29 words; valid: 30 "),
        ("VERTEX_SE3:QUAT 10 1 0", "VERTEX_SE3:QUAT 10 1", "line 1: VERTEX_SE3:QUAT with 7 words; valid: 8 "),
        ("EDGE_SE3:QUAT 3 10 1.1", "EDGE_SE3:QUAT 3 10 inf", "line 5: 'inf' is not a finite number; valid: "),
        ("VERTEX_SE3:QUAT 10 1 0", "VERTEX_SE3:QUAT 10 x 0", "line 1: 'x' is not a finite number; valid: "),
        ("EDGE_SE3:QUAT 3 10 1.1", "EDGE_SE3:QUAT 3 10 nan", "line 5: 'nan' is not a finite number; valid: "),
        ("VERTEX_SE3:QUAT 10 1 0", "VERTEX_SE2 10 1 0", "line 1: 'VERTEX_SE2' is not known; valid: VERTEX_SE3:QUAT, EDGE_"),
        (f"1 {INFORMATION}", f"1 {INFORMATION.replace('300', '-300')}", "line 5: the information matrix"),
        (f"1 {INFORMATION}", f"1 {INFORMATION.replace('300', '-300')}", "is not positive definite; valid: the upper"),
    ],
)
def test_defective_files_are_refused(old, new, says, tmp_path):
    path = tmp_path / "tiny.g2o"
    path.write_text(FILE.replace(old, new, 1))
    with pytest.raises(LexisError, match=says):
        read_g2o(path)
