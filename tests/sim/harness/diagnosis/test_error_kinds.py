"""The kinds of errors are those of the planted bugs, and a search for one kind does not end at another."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from sim.bench.planted_bugs import floors, no_bug, planted, revisits, twins
from sim.harness import Claim, FailureTest, Scenario, evaluate, reduce, run
from sim.harness.diagnosis.error_kinds import (
    IN_NO_ROOM,
    ON_NO_FLOOR,
    SPLIT,
    STRANGERS,
    STRAY,
    TOO_HIGH,
    TOO_LOW,
    TWINS,
    are_alike,
    error_kinds,
    most_frequent,
)
from sim.harness.diagnosis.first_wrong import first_wrong
from sim.harness.failures.why_page import wrong_frame_page
from sim.harness.shrinking.reductions import STEPS
from worlds.presets import sample_from_rooms

BEDROOMS = Scenario(
    house=sample_from_rooms(("bedroom", "bedroom", "kitchen", "bathroom"), seed=3),
    seed=5,
    length_m=60.0,
    frame_rate_hz=2.0,
    fidelity="features",
    encoder="oracle",
)
TALL = replace(BEDROOMS, house=sample_from_rooms(("kitchen", "bedroom"), seed=4, storeys=2), length_m=None)


def above(run):
    """A SLAM that estimates every frame to be one floor too high."""
    return replace(no_bug(run), floors=run.true_floors + 1)


def nowhere(run):
    """A SLAM that estimates neither a floor nor a room for any frame."""
    return replace(no_bug(run), floors=np.full_like(run.true_storeys, -1), rooms=np.full_like(run.true_rooms, -1))


def everything(run):
    """A SLAM that estimates one room."""
    return replace(no_bug(run), rooms=np.zeros_like(run.true_rooms))


@pytest.mark.parametrize(
    ("scenario", "bug", "figure", "kind"),
    [
        (TALL, floors, "floors.accuracy", TOO_LOW),
        (TALL, above, "floors.accuracy", TOO_HIGH),
        (TALL, nowhere, "floors.accuracy", ON_NO_FLOOR),
        (BEDROOMS, twins, "rooms.merges", TWINS),
        (BEDROOMS, everything, "rooms.pq", STRANGERS),
        (BEDROOMS, revisits, "rooms.splits", SPLIT),
        (BEDROOMS, nowhere, "rooms.pq", IN_NO_ROOM),
    ],
)
def test_each_bug_has_its_kind_of_error(scenario, bug, figure, kind):
    run = planted(bug)(scenario, None)
    kinds = error_kinds(run, figure, {})
    assert most_frequent(kinds) == kind
    assert error_kinds(run, "trajectory.ate_m", {}) == error_kinds(run, None, {}) == Counter()
    assert error_kinds(replace(run, estimate=no_bug(run)), figure, {}) == Counter()


def beyond_doorways(run):
    """A SLAM that takes the first two frames of every room for frames of the room before; no room is merged or split."""
    rooms = run.true_rooms.copy()
    enters = 1 + np.flatnonzero(np.diff(run.true_rooms))
    rooms[enters] = rooms[np.minimum(enters + 1, len(rooms) - 1)] = run.true_rooms[enters - 1]
    return replace(no_bug(run), rooms=rooms)


def test_frames_near_doorways_are_not_called_merged_where_no_room_is():
    run = planted(beyond_doorways)(BEDROOMS, None)
    result = evaluate(run)
    assert result.rooms.merges == result.rooms.splits == 0 and result.rooms.pq < 1.0
    assert set(error_kinds(run, "rooms.pq", {})) == {STRAY}


def test_rooms_have_the_labels_of_the_original_scenario():
    run = planted(twins)(BEDROOMS, None)
    other = {room.id: room.id for room in run.house.rooms}
    assert set(error_kinds(run, "rooms.pq", {})) == {TWINS} and set(error_kinds(run, "rooms.pq", other)) == {STRANGERS}


def test_kinds_are_alike_if_the_same_one_is_most_frequent():
    first, second = Counter({TWINS: 5, SPLIT: 3}), Counter({SPLIT: 1})
    assert are_alike(first, Counter({TWINS: 1})) and not are_alike(first, second)
    assert are_alike(Counter(), first) and are_alike(first, Counter())
    assert most_frequent(Counter({TWINS: 2, SPLIT: 2})) == most_frequent(Counter({SPLIT: 2, TWINS: 2}))


def small_house(run):
    """A SLAM whose rooms are all one in houses of one or two rooms: another bug, which waits at the end of a search."""
    return everything(run) if len(run.house.rooms) < 3 else no_bug(run)


def both(run):
    return twins(run) if len(run.house.rooms) >= 3 else small_house(run)


@pytest.mark.parametrize("reference", [None, planted(small_house)])
def test_a_search_does_not_end_at_another_bug(reference):
    test = FailureTest(Claim.parse("rooms.merges > 0"), planted(both), reference)
    reduction = reduce(BEDROOMS, test, deadline_s=1e9)
    kept = FailureTest(test.condition, planted(small_house))
    assert len(reduction.accepted) > 5 and kept(reduction.scenario) is None
    assert reduction.different > 0


def all_wrong(run):
    return replace(no_bug(run), labels=np.full_like(run.true_labels, -1))


class Lost:
    """A SLAM that raises an exception."""

    def start(self, camera, room_names):
        raise RuntimeError("lost")

    def process(self, observation):
        """Never called."""

    def finish(self):
        """Never called."""


def wrong_labels(run):
    """A SLAM that labels nothing in houses of one room."""
    labels = np.full_like(run.true_labels, -1) if len(run.house.rooms) < 2 else run.true_labels
    return replace(no_bug(run), labels=labels)


def wrong_bedrooms(run):
    """The same SLAM with a bug: it takes bedrooms for bathrooms."""
    labels, names = wrong_labels(run).labels.copy(), run.room_names
    if "bedroom" in names and "bathroom" in names:
        labels[labels == names.index("bedroom")] = names.index("bathroom")
    return replace(no_bug(run), labels=labels)


def test_the_reference_tells_apart_what_has_no_kinds():
    condition = Claim.parse("labels.accuracy < 0.9")
    steps = {name: STEPS[name] for name in ("drop rooms", "shorten the tour")}
    slipped = reduce(BEDROOMS, FailureTest(condition, planted(wrong_bedrooms)), deadline_s=1e9, steps=steps)
    kept = reduce(
        BEDROOMS, FailureTest(condition, planted(wrong_bedrooms), planted(wrong_labels)), deadline_s=1e9, steps=steps
    )
    mended = FailureTest(condition, planted(wrong_labels))
    assert mended(slipped.scenario) is not None and mended(kept.scenario) is None
    assert kept.of_reference > 0 and "because the reference fails there, too" in kept.note


def early(run):
    """A SLAM that labels nothing at the second frame."""
    labels = run.true_labels.copy()
    labels[1] = -1
    return replace(no_bug(run), labels=labels)


def early_and_late(run):
    labels = early(run).labels.copy()
    labels[-5:] = -1
    return replace(no_bug(run), labels=labels)


def test_frames_that_the_reference_gets_wrong_are_passed_over():
    run, reference = (planted(bug)(BEDROOMS, None) for bug in (early_and_late, early))
    frames = run.estimate.frames
    assert first_wrong(run, "labels.accuracy").frame == frames[1]
    assert first_wrong(run, "labels.accuracy", reference).frame == frames[-5]
    assert not first_wrong(run, "labels.accuracy", reference).in_reference
    alike = first_wrong(reference, "labels.accuracy", reference)  # nothing else is wrong
    assert alike.frame == frames[1] and alike.in_reference
    said = "The reference is wrong at every frame at which this run is wrong, too."
    for other, is_new in ((run, True), (reference, False)):
        lines = wrong_frame_page(other, "labels.accuracy", reference).lines
        assert (lines[0] == "## Where it first went wrong, and the reference did not") == is_new == (said not in lines)


def test_how_a_reference_fails_is_told():
    def lost(scenario, progress):
        finished = run(scenario, Lost(), progress)
        raise AssertionError(finished)

    condition = Claim.parse("labels.accuracy < 0.9")
    told = [
        FailureTest(condition, planted(early), reference).reference_fails(BEDROOMS)
        for reference in (planted(early), planted(nowhere), planted(all_wrong), lost)
    ]
    assert told[:3] == [None, None, "labels.accuracy is 0"] and told[3].startswith(
        "it raises RuntimeError, in test_error_kinds"
    )
