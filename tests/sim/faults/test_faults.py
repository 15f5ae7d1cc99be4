"""Faults of the stream: each changes what its name says, and the truth records it."""

from dataclasses import fields, replace

import cv2
import numpy as np
import pytest
from helpers.blind_encoder import BlindEncoder
from helpers.unchecked import unchecked, untyped

from lexis.errors import ObservationError
from lexis.maths.se3 import between, compose_covariance, exp, is_rigid
from lexis.slam import Slam
from lexis.types import Features, Observation, Percept
from sim.errors import SimError
from sim.faults import FAULTS, StreamFault, corrupted, fault_rng, parse_fault, written
from sim.faults.catalogue import usage
from sim.faults.delivery import Dropped, Duplicated, Frozen, Late, OutOfOrder
from sim.faults.images import Blur, Exposure, LightsOff, Noise, Smear
from sim.faults.poses import Kidnap, OdometryFreeze, OdometryJump, OdometryNaN
from sim.faults.stamps import StampJitter, StampJump, StampOffset
from sim.faults.world import MovedFurniture
from sim.render.camera import wide_camera
from sim.truth import Truth

FRAMES = 300
FRAME_S = 0.1
REORDERING = (Duplicated(0.2), Late(0.1, frames=3), OutOfOrder(0.5, group=4))
CHANGING = (
    *(Dropped(0.2), Frozen(0.2, burst=5), StampOffset(2), StampOffset(-3)),
    *(StampJitter(0.05, at_s=5.0, for_s=9.0), StampJump(2.0, at_s=12.0)),
    *(Blur(5), Exposure(-2.0, for_s=7.0), Noise(9.0, at_s=20.0), Smear(0.3), LightsOff(at_s=10.0, for_s=5.0)),
    *(OdometryJump(9.0), OdometryFreeze(at_s=9.0, for_s=2.0), OdometryNaN(0.1), Kidnap(9.0, 7.0)),
)


def ids(faults):
    return [written(fault) for fault in faults]


def images(n, size=(24, 32)):
    """Smooth, textured images, no two of which are alike."""
    rng = np.random.default_rng(1)
    blobs = [cv2.GaussianBlur(rng.random((*size, 3), dtype=np.float32), (0, 0), 1.5) for _ in range(n)]
    return [np.clip(255 * (0.5 + 4.0 * (blob - 0.5)), 1, 254).astype(np.uint8) for blob in blobs]


@pytest.fixture(scope="module")
def clean():
    rng = np.random.default_rng(0)
    pairs, T = [], np.eye(4)
    covariance = np.diag([1e-6, 1e-6, 1e-5, 1e-4, 1e-4, 1e-4])
    for i, image in enumerate(images(FRAMES)):
        pairs.append((Observation(i, FRAME_S * i, image, T, covariance), Truth(i, FRAME_S * i, T, 0, "office", 0)))
        T = T @ exp(np.array([0.0, 0.0, 0.03, 0.07, 0.0, 0.0]) + 1e-3 * rng.standard_normal(6))
    return pairs


def run(clean, *faults, seed=3):
    return list(corrupted(iter(clean), faults, seed))


def same(a, b):
    return all(np.array_equal(getattr(a, each.name), getattr(b, each.name), equal_nan=False) for each in fields(a))


def poses(pairs):
    return np.array([observation.T_O_B for observation, _ in pairs])


def stamps(pairs):
    return np.array([observation.stamp for observation, _ in pairs])


def indices(pairs):
    return np.array([observation.index for observation, _ in pairs])


def marked(pairs, name):
    return np.array([name in truth.faults for _, truth in pairs])


def test_every_fault_of_the_stream_is_tested():
    kinds = {type(fault) for fault in (*REORDERING, *CHANGING)}
    assert kinds == {kind for kind in FAULTS.values() if issubclass(kind, StreamFault)}


def test_no_faults_no_change(clean):
    assert all(a is c and b is d for (a, b), (c, d) in zip(run(clean), clean, strict=True))


@pytest.mark.parametrize("fault", CHANGING, ids=ids(CHANGING))
def test_what_is_recorded_is_what_differs(clean, fault):
    touched = 0
    for observation, truth in run(clean, fault):
        assert truth.index == observation.index
        assert truth.faults == (() if same(observation, clean[observation.index][0]) else (fault.name,))
        touched += bool(truth.faults)
    assert touched > 0


@pytest.mark.parametrize("fault", REORDERING, ids=ids(REORDERING))
def test_reordered_observations_are_untouched(clean, fault):
    pairs = run(clean, fault)
    assert all(same(observation, clean[observation.index][0]) for observation, _ in pairs)
    assert set(indices(pairs)) == set(range(FRAMES)) and marked(pairs, fault.name).any()
    in_order = [observation.index for observation, truth in pairs if not truth.faults]
    assert in_order == sorted(in_order)


@pytest.mark.parametrize("fault", (*REORDERING, *CHANGING), ids=ids((*REORDERING, *CHANGING)))
def test_the_same_seed_gives_the_same_faults(clean, fault):
    first, again = run(clean, fault), run(clean, fault)
    assert len(first) == len(again)
    for (a, x), (b, y) in zip(first, again, strict=True):
        assert x.faults == y.faults and np.array_equal(a.T_O_B, b.T_O_B, equal_nan=True)
        assert all(same(replace(each, T_O_B=np.eye(4)), replace(other, T_O_B=np.eye(4))) for each, other in [(a, b)])


def test_another_seed_gives_others(clean):
    assert not np.array_equal(indices(run(clean, Dropped(0.2))), indices(run(clean, Dropped(0.2), seed=4)))


def test_faults_apply_in_the_order_given_each_with_its_own_draws(clean):
    first, second = Dropped(0.2), Frozen(0.2)
    by_hand = list(second.apply(first.apply(iter(clean), fault_rng(3, 0)), fault_rng(3, 1)))
    both = run(clean, first, second)
    assert [truth.faults for _, truth in both] == [truth.faults for _, truth in by_hand]
    assert ("dropped", "frozen") in {truth.faults for _, truth in both}
    np.testing.assert_array_equal(indices(both), indices(run(clean, first)))
    assert not np.array_equal(indices(run(clean, second, first)), indices(both))


def test_dropped_frames_leave_gaps_that_the_covariance_covers(clean):
    pairs = run(clean, Dropped(0.3, burst=4))
    left = np.mean([len(run(clean, Dropped(0.3, burst=4), seed=seed)) for seed in range(20)])
    assert 1.0 - left / FRAMES == pytest.approx(0.3, abs=0.04)
    gaps = np.diff(indices(pairs)) > 1
    assert (np.diff(indices(pairs))[gaps] >= 5).mean() > 0.9
    np.testing.assert_array_equal(marked(pairs, "dropped")[1:], gaps)
    k = int(np.argmax(gaps))
    expected = np.zeros((6, 6))
    for i in range(indices(pairs)[k] + 1, indices(pairs)[k + 1] + 1):
        step = between(clean[i - 1][0].T_O_B, clean[i][0].T_O_B)
        expected = compose_covariance(expected, step, clean[i][0].increment_covariance)
    np.testing.assert_allclose(pairs[k + 1][0].increment_covariance, expected)


def test_frozen_images_are_the_last_good_one(clean):
    pairs = run(clean, Frozen(0.3, burst=5))
    frozen = marked(pairs, "frozen")
    assert 0.1 < frozen.mean() < 0.5 and not frozen[0]
    for i in np.flatnonzero(frozen):
        good = i - 1 - int(np.argmin(frozen[:i][::-1]))
        assert np.array_equal(pairs[i][0].image, clean[good][0].image)


def test_duplicates_follow_their_frame(clean):
    pairs = run(clean, Duplicated(0.25))
    assert len(pairs) / FRAMES == pytest.approx(1.25, abs=0.07)
    np.testing.assert_array_equal(marked(pairs, "duplicated")[1:], np.diff(indices(pairs)) == 0)


def test_late_frames_are_overtaken(clean):
    pairs = run(clean, Late(0.05, frames=3))
    order, late = indices(pairs), marked(pairs, "late")
    for place in np.flatnonzero(late):
        overtaking = order[:place] > order[place]
        assert overtaking.sum() <= 3 and (overtaking.sum() == 3 or late[np.flatnonzero(order > order[place])].any())
    assert late.sum() == pytest.approx(0.05 * FRAMES, abs=8)


def test_groups_out_of_order_stay_together(clean):
    order = indices(run(clean, OutOfOrder(1.0, group=5)))
    np.testing.assert_array_equal(np.sort(order.reshape(-1, 5), axis=1), np.arange(FRAMES).reshape(-1, 5))
    assert (np.diff(order) < 0).sum() > FRAMES / 5


@pytest.mark.parametrize("frames", [2, -3])
def test_offset_images_have_another_frames_stamp_and_pose(clean, frames):
    pairs = run(clean, StampOffset(frames))
    assert len(pairs) == FRAMES - abs(frames)
    for observation, truth in pairs:
        dated = clean[observation.index + frames][0]
        assert observation.stamp == dated.stamp and np.array_equal(observation.T_O_B, dated.T_O_B)
        assert np.array_equal(observation.image, clean[truth.index][0].image) and truth.stamp == FRAME_S * truth.index


def test_stamps_jitter_and_jump(clean):
    error = stamps(run(clean, StampJitter(0.05))) - stamps(clean)
    assert np.std(error) == pytest.approx(0.05, rel=0.15) and abs(np.mean(error)) < 0.01
    error = stamps(run(clean, StampJump(2.0, at_s=10.0))) - stamps(clean)
    np.testing.assert_allclose(error, np.where(np.arange(FRAMES) < 100, 0.0, -2.0))


def edited(clean, fault, k=0):
    return run(clean[k : k + 1], fault)[0][0].image.astype(float), clean[k][0].image.astype(float)


def test_blur_averages_along_rows_alone(clean):
    blurred, sharp = edited(clean, Blur(5))
    np.testing.assert_allclose(blurred[:, 2:-2], np.mean([sharp[:, k : k + 28] for k in range(5)], axis=0), atol=0.51)


@pytest.mark.parametrize("stops", [-3.0, 1.0])
def test_exposure_multiplies_light(clean, stops):
    after, before = edited(clean, Exposure(stops))
    light = (before / 255) ** 2.2 * 2**stops
    np.testing.assert_allclose(after, 255 * np.minimum(light, 1.0) ** (1 / 2.2), atol=0.51)


def test_noise_is_white_and_of_the_size_said(clean):
    grey = replace(clean[0][0], image=np.full((200, 200, 3), 128, np.uint8))
    error = run([(grey, clean[0][1])], Noise(9.0))[0][0].image - 128.0
    assert error.std() == pytest.approx(9.0, rel=0.02) and abs(error.mean()) < 0.1
    assert abs((error[:, 1:] * error[:, :-1]).mean()) < 1.0 > abs((error[..., 0] * error[..., 1]).mean())


def test_smear_stays_where_it_is_and_hides_detail():
    stream = [
        (Observation(i, FRAME_S * i, image, np.eye(4), np.eye(6)), Truth(i, FRAME_S * i, np.eye(4), 0, "office", 0))
        for i, image in enumerate(images(30, (120, 160)))
    ]
    changed = [
        np.abs(a.image.astype(int) - b.image).max(axis=-1) > 3
        for (a, _), (b, _) in zip(run(stream, Smear(0.3)), stream, strict=True)
    ]
    often = np.mean(changed, axis=0)
    assert (often < 0.02).mean() == pytest.approx(0.6, abs=0.12)
    assert (often > 0.9).mean() == pytest.approx(0.3, abs=0.08)


def test_no_share_of_grease_leaves_the_image_as_it_is(clean):
    np.testing.assert_array_equal(*edited(clean, Smear(0.0)))


def test_lights_off_leaves_almost_nothing(clean):
    dark, lit = edited(clean, LightsOff())
    assert dark.mean() < 0.1 * lit.mean() and dark.std() > 1.0


def test_odometry_jumps_once(clean):
    jumped = poses(run(clean, OdometryJump(10.0, distance_m=1.0, turn_rad=0.2)))
    steps, true_steps = between(jumped[:-1], jumped[1:]), between(poses(clean)[:-1], poses(clean)[1:])
    off = np.flatnonzero(np.abs(steps - true_steps).max(axis=(1, 2)) > 1e-9)
    np.testing.assert_array_equal(off, [99])
    jump = np.linalg.inv(true_steps[99]) @ steps[99]
    assert np.hypot(*jump[:2, 3]) == pytest.approx(1.0) and abs(np.arctan2(jump[1, 0], jump[0, 0])) == pytest.approx(0.2)


def test_frozen_odometry_goes_on_without_what_it_missed(clean):
    frozen = poses(run(clean, OdometryFreeze(at_s=10.0, for_s=2.0)))
    steps, true_steps = between(frozen[:-1], frozen[1:]), between(poses(clean)[:-1], poses(clean)[1:])
    still = np.arange(FRAMES - 1)
    still = (still >= 99) & (still < 119)
    np.testing.assert_allclose(steps[still], np.tile(np.eye(4), (20, 1, 1)), atol=1e-12)
    np.testing.assert_allclose(steps[~still], true_steps[~still], atol=1e-9)


def test_nan_for_single_frames(clean):
    T = poses(run(clean, OdometryNaN(0.1)))
    lost = np.isnan(T).all(axis=(1, 2))
    assert lost.mean() == pytest.approx(0.1, abs=0.06) and is_rigid(T[~lost]).all()


@pytest.mark.parametrize("fault", CHANGING + REORDERING, ids=ids(CHANGING + REORDERING))
def test_poses_that_are_nan_stay_single_under_any_other_fault(clean, fault):
    lost, found = ([o for o, _ in run(clean, OdometryNaN(0.2), *more)] for more in ((), (fault,)))
    frames = [{o.index for o in each if np.isnan(o.T_O_B).any()} for each in (lost, found)]
    assert len(frames[0]) > 20 and (len(frames[1]) <= len(frames[0]) or isinstance(fault, OdometryNaN))
    assert all(np.isfinite(o.increment_covariance).all() and np.isfinite(o.stamp) for o in found)


@pytest.mark.parametrize("fault", [Frozen(0.2, burst=5), Duplicated(0.2)], ids=["frozen", "duplicated"])
def test_repeated_images_are_copies_that_the_slam_cannot_have_changed(clean, fault):
    untouched = [o.image.copy() for o, _ in run(clean, fault)]
    given = ((replace(o, image=o.image.copy()), truth) for o, truth in clean)
    for (observation, _), before in zip(corrupted(given, (fault,), 3), untouched, strict=True):
        assert np.array_equal(observation.image, before)
        observation.image[:] = 0


@pytest.mark.parametrize("fault", [Frozen(0.2, burst=5), Duplicated(0.2)], ids=["frozen", "duplicated"])
def test_repeated_percepts_are_copies_that_the_slam_cannot_have_changed(clean, fault):
    def percept(k):
        features = Features(np.full((3, 2), k, np.float32), np.full((3, 61), k, np.uint8))
        return Percept(np.full(8, k, np.float32), features, np.full((5, 3), float(k)))

    given = ((replace(o, image=percept(o.index % 250), others=(percept(o.index % 250),)), truth) for o, truth in clean)
    for observation, _ in corrupted(given, (fault,), 3):
        for seen in observation.images:
            arrays = seen.embedding, seen.points, seen.features.keypoints, seen.features.descriptors
            assert all((array == array.flat[0]).all() and array.flat[0] != 251 for array in arrays)
            for array in arrays:
                array[...] = 251


def test_a_kidnapped_body_is_elsewhere_and_the_odometry_does_not_show_it(clean):
    pairs = run(clean, Kidnap(10.0, skip_s=5.0))
    np.testing.assert_array_equal(indices(pairs), [*range(100), *range(150, FRAMES)])
    np.testing.assert_allclose(np.diff(stamps(pairs)), FRAME_S)
    np.testing.assert_allclose([truth.stamp for _, truth in pairs], stamps(pairs))
    steps = between(poses(pairs)[:-1], poses(pairs)[1:])
    clean_steps = between(poses(clean)[:-1], poses(clean)[1:])
    np.testing.assert_allclose(steps, clean_steps[indices(pairs)[1:] - 1], atol=1e-9)
    true = np.array([truth.T_W_B for _, truth in pairs])
    np.testing.assert_array_equal(true, poses(clean)[indices(pairs)])


@pytest.mark.parametrize("clock", [StampJump(2.0, at_s=12.0), StampJitter(0.05)], ids=lambda fault: fault.name)
def test_the_true_stamps_after_a_kidnapping_depend_on_no_clock(clean, clock):
    kidnap = Kidnap(10.0, skip_s=5.0)
    true, wrong = ([truth.stamp for _, truth in run(clean, *faults)] for faults in ((kidnap,), (clock, kidnap)))
    np.testing.assert_array_equal(true, wrong)


@pytest.mark.parametrize("late", [Late(0.3, frames=7), OutOfOrder(1.0, group=6)], ids=lambda fault: fault.name)
def test_frames_that_arrive_late_do_not_move_the_ends_of_the_cut(clean, late):
    """All frames after the cut are shifted by the same time, and moved by the same motion."""
    after = [(seen, truth) for seen, truth in run(clean, late, Kidnap(10.0, skip_s=5.0)) if "kidnap" in truth.faults]
    shifts = [clean[seen.index][0].stamp - seen.stamp for seen, _ in after]
    np.testing.assert_allclose(shifts, shifts[0], atol=1e-9)
    np.testing.assert_allclose([clean[seen.index][1].stamp - truth.stamp for seen, truth in after], shifts, atol=1e-9)
    moves = [seen.T_O_B @ np.linalg.inv(clean[seen.index][0].T_O_B) for seen, _ in after]
    np.testing.assert_allclose(moves, np.broadcast_to(moves[0], (len(moves), 4, 4)), atol=1e-9)


@pytest.mark.parametrize("skip_s", [0.1, 0.2, 0.3, 0.5, 1.0])
def test_all_frames_after_the_cut_are_shifted_or_none(clean, skip_s):
    """Frames of a short cut may all arrive later than the first frame after it."""
    pairs = run(clean, Late(0.9, frames=7), Kidnap(10.0, skip_s=skip_s))
    shifted = {"kidnap" in truth.faults for seen, truth in pairs if clean[seen.index][1].stamp >= 10.0 + skip_s}
    assert len(shifted) == 1


@pytest.mark.parametrize("fault", (*REORDERING, *CHANGING), ids=ids((*REORDERING, *CHANGING)))
def test_lexis_takes_an_observation_or_says_why_not(clean, fault):
    slam = Slam(wide_camera(32, 24), BlindEncoder(), ("office", "kitchen"))
    refused = 0
    for observation, truth in run(clean, fault):
        try:
            slam.process(observation)
        except ObservationError as error:
            assert truth.faults or isinstance(fault, OutOfOrder | Late | StampJitter), error
            assert "valid" in str(error)
            refused += 1
    slam_map = slam.finish()
    assert is_rigid(slam_map.T_W_B).all() and len(slam_map.keyframes) > 5
    breaks_time = isinstance(fault, Duplicated | OutOfOrder | Late | StampJitter | StampJump)
    assert (refused > 0) == (breaks_time or isinstance(fault, OdometryNaN))


@pytest.mark.parametrize("name", FAULTS)
def test_faults_are_read_back_as_written(name):
    fault = FAULTS[name]()
    assert parse_fault(name) == parse_fault(written(fault)) == fault
    assert f"  {name}:" in usage()


@pytest.mark.parametrize(
    "fault",
    [
        *(
            Late(1 / 3, frames=10**7),
            Kidnap(1234567.5),
            StampJump(1.8e9 + 0.25, at_s=1e-7, for_s=7),
            OdometryJump(0.1 + 0.2),
        ),
        *(StampOffset(-100), Exposure(1), MovedFurniture(0.3, at_s=123.4567)),
    ],
    ids=lambda fault: fault.name,
)
def test_no_digit_of_a_fault_is_lost_in_its_text(fault):
    assert parse_fault(written(fault)) == fault


def test_the_text_of_a_fault_is_short():
    assert written(Dropped(0.2, burst=3)) == "dropped:share=0.2,burst=3"
    assert written(StampJitter(0.02)) == "stamp-jitter:sigma_s=0.02,at_s=0,for_s=inf"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("fog", r"unknown fault 'fog'; valid: dropped, "),
        ("blur:soft", r"pixels is 'soft'; valid: a whole number"),
        ("blur:2.5", r"pixels is '2.5'; valid: a whole number"),
        ("blur:0", r"fault blur: pixels is 0; valid: 1 to 200"),
        ("dropped:0.1,speed=3", r"'speed' is no field of dropped; valid: share, burst"),
        ("dropped:0.1,4", "'4' has no field; valid: burst=4"),
        ("noise:nan", r"sigma is nan; valid: 0 to 255"),
    ],
)
def test_bad_faults_say_what_is_valid(text, message):
    with pytest.raises(SimError, match=message):
        parse_fault(text)


@pytest.mark.parametrize("value", [None, 3, Kidnap(20.0)])
def test_a_fault_that_is_no_text_is_refused(value):
    with pytest.raises(SimError, match=r"^fault is .*; valid: a text, such as 'kidnap:20'"):
        untyped(parse_fault)(value)


@pytest.mark.parametrize(("kind", "field"), [(kind, each.name) for kind in FAULTS.values() for each in fields(kind)])
@pytest.mark.parametrize("value", ["9", True, [1], 1j, 2.5, None])
def test_a_field_that_is_no_number_of_its_kind_is_refused(kind, field, value):
    declared = {each.name: each for each in fields(kind)}[field]
    if value is None and declared.default is None:
        return
    if value == 2.5 and declared.type is not int:
        return
    number = "whole number" if declared.type is int else "number"
    with pytest.raises(SimError, match=rf"^fault {kind.name}: {field} is .*; valid: a {number} from "):
        unchecked(kind, **{field: value})


@pytest.mark.parametrize("number", [9, 9.0, np.int64(9), np.float32(9.0)])
def test_every_way_to_write_a_whole_number_gives_the_same_fault(number):
    assert type(unchecked(Blur, pixels=number).pixels) is int and unchecked(Blur, pixels=number) == Blur(9)


def test_a_fault_given_as_a_bare_value_sets_its_first_field():
    assert parse_fault("dropped:0.3,burst=2") == Dropped(0.3, burst=2)
    assert parse_fault("kidnap:30") == Kidnap(30.0)
    assert parse_fault("lights-off:0.5") == LightsOff(left=0.5)
    assert parse_fault("person:12") == FAULTS["person"](at_s=12.0)


def test_faults_draw_from_a_stream_of_their_own():
    tour, odometry, faults = np.random.SeedSequence(5).spawn(3)
    drawn = [np.random.default_rng(child).random() for child in (tour, odometry, *faults.spawn(2))]
    assert [fault_rng(5, place).random() for place in (0, 1)] == drawn[2:]
    assert len(set(drawn)) == 4
