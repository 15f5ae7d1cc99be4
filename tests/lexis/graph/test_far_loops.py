"""Far loops on a circular path whose poses are known exactly."""

import numpy as np

from lexis.graph.far_loops import FarLoops
from lexis.maths import se3
from lexis.types import LoopEdge

STEP = se3.exp(np.array([0.0, 0.0, 2 * np.pi / 40, 0.501, 0.0, 0.0]))
UP = se3.exp(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 3.0]))
T_W_B = np.stack([np.linalg.matrix_power(STEP, i) for i in range(30)])


def far_loop(query, match, T_match_query=STEP):
    return LoopEdge(query, match, T_match_query, 1e-4 * np.eye(6), 50)


def far_loops(count=30, loops=()):
    far = FarLoops()
    for _ in range(count):
        far.add_step()
    far.add(28, [], loops, T_W_B)
    return far


def test_a_far_loop_leads_to_the_pose_at_which_it_sees_the_robot():
    loop = far_loop(28, 3)
    estimate, displaced = far_loops(loops=[loop]).poses_of(29, T_W_B)
    np.testing.assert_array_equal(estimate, T_W_B[29])
    np.testing.assert_allclose(displaced, T_W_B[3] @ STEP @ STEP, atol=1e-12)


def test_without_far_loops_a_keyframe_has_its_estimated_pose_alone():
    np.testing.assert_array_equal(far_loops().poses_of(29, T_W_B), T_W_B[29:])


def test_far_loops_that_agree_lead_to_one_pose():
    agreeing = [far_loop(28, 3), far_loop(27, 2), far_loop(26, 1)]
    assert len(far_loops(loops=agreeing).poses_of(29, T_W_B)) == 2
    assert len(far_loops(loops=[*agreeing, far_loop(28, 14)]).poses_of(29, T_W_B)) == 3


def test_far_loops_to_another_storey_lead_nowhere():
    assert len(far_loops(loops=[far_loop(28, 3, STEP @ UP)]).poses_of(29, T_W_B)) == 1


def test_a_far_loop_is_false_if_other_loops_bridge_all_of_its_steps():
    far = far_loops(loops=[far_loop(28, 3)])
    far.bridge([far_loop(15, 2)])
    far.bridge([far_loop(29, 16)])
    assert len(far.poses_of(29, T_W_B)) == 2  # no loop bridges the step to keyframe 16
    far.bridge([far_loop(16, 15)])
    assert len(far.poses_of(29, T_W_B)) == 1
    far.add(29, [], [far_loop(29, 4)], T_W_B)
    assert len(far.poses_of(29, T_W_B)) == 1


def test_a_new_session_begins_without_displaced_poses():
    far = far_loops(loops=[far_loop(28, 3)])
    far.begin_session()
    assert len(far.poses_of(29, T_W_B)) == 1


def compared(far, query, candidates, loops=()):
    """The keyframe is compared with candidates; return whether the robot is still searched at a displaced pose."""
    far.add(query, candidates, loops, T_W_B)
    return len(far.poses_of(query, T_W_B)) > 1


def test_the_search_ends_when_keyframes_were_compared_several_times_in_vain():
    far = far_loops(loops=[far_loop(20, 1)])  # keyframe 21 is then beside keyframe 3, and so on
    elsewhere = [compared(far, query, [15]) for query in range(21, 25)]
    in_vain = [compared(far, query, [15, query - 18]) for query in range(21, 26)]
    assert elsewhere == [True] * 4
    assert in_vain == [True] * 4 + [False]
    assert len(far.kept) == 1


def test_the_search_goes_on_when_a_far_loop_confirms_the_displacement():
    far = far_loops(loops=[far_loop(20, 1)])
    for query in range(21, 25):
        assert compared(far, query, [query - 18])
    assert compared(far, 25, [7], [far_loop(25, 6)])
    assert [compared(far, query, [query - 18]) for query in range(26, 30)] == [True] * 4
