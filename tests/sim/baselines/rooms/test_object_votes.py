"""Rooms of the true map get the label that the objects in them vote for."""

from dataclasses import dataclass, replace

import numpy as np

from sim.baselines.rooms import HydraPlaces, MapRooms, ObjectVotes, Voronoi
from sim.baselines.rooms.object_scores import Counted, count_rooms
from sim.harness import Scenario, evaluate, run
from sim.harness.run_settings import house_spec
from worlds.variant import variant

USUAL = Scenario(preset="home", seed=101, fidelity="features", frame_rate_hz=2.0)
CLOSED = replace(USUAL, house=variant(house_spec(USUAL), openness=0.0))
TOLD = Counted(count_rooms("home", range(101, 102)))
"""Numbers of rooms of the house itself that have objects of a category."""


@dataclass(frozen=True)
class Fixed:
    """Scores that prefer one room name, whatever the objects."""

    name: str

    def scores(self, pieces, names):
        return np.tile([float(name == self.name) for name in names], (len(pieces), 1))


def test_objects_name_nearly_all_rooms_behind_doors():
    result = evaluate(run(CLOSED, ObjectVotes.of(CLOSED, Voronoi(), TOLD)))
    assert result.labels.accuracy > 0.9


def test_rooms_floors_and_keyframes_are_those_of_the_segmentation():
    labelled = run(CLOSED, ObjectVotes.of(CLOSED, HydraPlaces(), TOLD)).estimate
    plain = run(CLOSED, MapRooms.of(CLOSED, HydraPlaces())).estimate
    for name in ("frames", "rooms", "floors"):
        assert (getattr(labelled, name) == getattr(plain, name)).all()
    assert all(len(np.unique(labelled.labels[labelled.rooms == room])) == 1 for room in np.unique(labelled.rooms))


def test_every_room_takes_the_preferred_name_and_stairs_alone_are_stairs():
    for name in ("kitchen", "stairs"):
        finished = run(CLOSED, ObjectVotes.of(CLOSED, Voronoi(), Fixed(name)))
        stairs = finished.room_names.index("stairs")
        assert ((finished.estimate.labels == stairs) == finished.on_stairs).all() and finished.on_stairs.any()
    kitchen = run(CLOSED, ObjectVotes.of(CLOSED, Voronoi(), Fixed("kitchen")))
    assert {kitchen.room_names[label] for label in np.unique(kitchen.estimate.labels)} == {"kitchen", "stairs"}


def test_rooms_without_objects_stay_without_a_label():
    spec = house_spec(CLOSED)
    below, above = spec.storeys
    bare = replace(CLOSED, house=spec.model_copy(update={"storeys": (below, above.model_copy(update={"furniture": ()}))}))
    finished = run(bare, ObjectVotes.of(bare, Voronoi(), TOLD))
    labelled = finished.estimate.labels >= 0
    assert (labelled == (finished.on_stairs | (finished.true_storeys == 0))).all() and not labelled.all()


def test_a_house_without_objects_gets_no_label_but_stairs():
    empty = replace(CLOSED, house=variant(house_spec(CLOSED), clutter=0.0))
    finished = run(empty, ObjectVotes.of(empty, Voronoi(), TOLD))
    assert ((finished.estimate.labels >= 0) == finished.on_stairs).all()
