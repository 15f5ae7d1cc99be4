"""TUM files: reading inverts writing, and defective files are refused with the number of the line."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lexis.errors import LexisError
from lexis.files.tum_trajectory import read_tum, write_tum


def test_a_tum_file_gives_back_what_was_written(rng, tmp_path):
    stamps, poses = np.arange(50) * 0.1, np.tile(np.eye(4), (50, 1, 1))
    poses[:, :3, :3] = Rotation.random(50, rng=rng).as_matrix()
    poses[:, :3, 3] = rng.normal(0.0, 10.0, (50, 3))
    write_tum(tmp_path / "a.tum", stamps, poses)
    read_stamps, read_poses = read_tum(tmp_path / "a.tum")
    np.testing.assert_allclose(read_stamps, stamps, atol=1e-6)
    np.testing.assert_allclose(read_poses, poses, atol=1e-7)
    assert [path.name for path in tmp_path.iterdir()] == ["a.tum"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "holds no pose"),
        ("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0\n", ":2:"),
        ("0 0 0 0 0 0 0 nan\n", ":1:"),
        ("0 0 0 0 0 0 0 2\n", "quaternion qx qy qz qw has the norm 2; valid: 1"),
        ("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", "ascending"),
    ],
)
def test_a_broken_tum_file_is_refused(text, says, tmp_path):
    (tmp_path / "a.tum").write_text(text)
    with pytest.raises(LexisError, match=says):
        read_tum(tmp_path / "a.tum")
