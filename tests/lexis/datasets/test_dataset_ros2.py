"""ROS 2 bags: the static transforms between the body and the camera are checked, and no others."""

import numpy as np
import pytest
from helpers.small_inputs import CAMERA, write_bag_run

from lexis.datasets.dataset import open_dataset
from lexis.errors import DatasetError
from sim.record.messages import Messages


def bag_with(link, quaternion, folder, monkeypatch):
    """Write a bag in which one static transform has the given quaternion x y z w."""
    written = Messages.static_transforms

    def spoilt(self, stamp_ns, cameras):
        message = written(self, stamp_ns, cameras)
        rotation = next(t for t in message.transforms if t.child_frame_id == link).transform.rotation
        rotation.x, rotation.y, rotation.z, rotation.w = quaternion
        return message

    monkeypatch.setattr(Messages, "static_transforms", spoilt)
    write_bag_run(folder)
    return folder


@pytest.mark.parametrize("quaternion", [(0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 7.0), (np.nan, 0.0, 0.0, 1.0)])
def test_a_link_to_the_camera_needs_a_unit_quaternion_and_other_links_need_not(tmp_path, monkeypatch, quaternion):
    aside = bag_with("imu0", quaternion, tmp_path / "aside", monkeypatch)
    np.testing.assert_allclose(open_dataset(aside).camera.T_B_C, CAMERA.T_B_C, atol=1e-12)
    monkeypatch.undo()
    with pytest.raises(DatasetError, match=r"/tf_static: the link to 'cam0' has no finite position .*; valid: ") as error:
        open_dataset(bag_with("cam0", quaternion, tmp_path / "used", monkeypatch))
    assert "\n" not in str(error.value)
