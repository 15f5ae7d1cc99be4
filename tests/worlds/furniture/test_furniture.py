"""Laws of the catalogue: every kind builds inside its box, of known materials, and the kinds that it names exist."""

import numpy as np
import pytest

from worlds.errors import WorldsError
from worlds.furniture.catalogue import CATALOGUE, kind_of
from worlds.furniture.kinds import Around, Kind, OnTop, OnWall, Size
from worlds.labels import ROOM_LABELS, STAIRS
from worlds.visuals.materials import PATTERNS


def _sizes(kind: Kind) -> list[Size]:
    return [Size(*(low + t * (high - low) for low, high in (kind.width, kind.depth, kind.height))) for t in (0.0, 0.37, 1.0)]


@pytest.mark.parametrize("kind", CATALOGUE.values(), ids=CATALOGUE)
def test_all_parts_lie_in_the_declared_box_and_nearly_fill_it(kind):
    for size in _sizes(kind):
        lows, highs = [], []
        for seed in range(6):
            for part in kind.build(size, np.random.default_rng(seed)):
                centre, half = np.array(part.centre), np.array(part.size) / 2
                assert np.all(half > 0), part
                assert part.yaw == 0.0
                assert np.all(centre - half >= np.array([size.left, size.back, 0.0]) - 0.02), part
                assert np.all(centre + half <= np.array([size.right, size.front, size.height]) + 0.02), part
                assert part.material in PATTERNS
                assert all(0.0 <= value <= 1.0 for value in part.colour)
                lows.append(centre - half)
                highs.append(centre + half)
        assert np.all(np.max(highs, axis=0) - np.min(lows, axis=0) >= 0.6 * np.array(size)), "the box is much too large"
        assert isinstance(kind.place, OnWall) or np.min(lows, axis=0)[2] <= 0.02, "it floats"


@pytest.mark.parametrize("kind", CATALOGUE.values(), ids=CATALOGUE)
def test_building_is_deterministic(kind):
    size = _sizes(kind)[1]
    assert kind.build(size, np.random.default_rng(3)) == kind.build(size, np.random.default_rng(3))


def test_pieces_of_most_kinds_come_in_variants():
    alike = [
        k.name for k in CATALOGUE.values() if len({k.build(_sizes(k)[1], np.random.default_rng(s)) for s in range(6)}) < 2
    ]
    assert len(alike) < 0.15 * len(CATALOGUE), alike


def test_hosts_and_neighbours_are_in_the_catalogue():
    for kind in CATALOGUE.values():
        for field in ("hosts", "above", "beside"):
            unknown = set(getattr(kind.place, field, ())) - set(CATALOGUE)
            assert not unknown, f"{kind.name} names {unknown}"


def test_what_depends_on_a_host_finds_one_in_every_room():
    for kind in CATALOGUE.values():
        if isinstance(kind.place, Around | OnTop):
            for label in kind.rooms:
                assert any(label in CATALOGUE[host].rooms for host in kind.place.hosts), (
                    f"{kind.name} has no host in {label}"
                )


@pytest.mark.parametrize("label", [label for label in ROOM_LABELS if label != STAIRS])
def test_every_room_can_be_told_by_what_it_must_have(label):
    required = {k.name for k in CATALOGUE.values() if isinstance(k.rooms.get(label), tuple) and k.rooms[label][0] >= 1}
    assert required
    for other in ROOM_LABELS:
        if other != label:
            theirs = {k.name for k in CATALOGUE.values() if isinstance(k.rooms.get(other), tuple)}
            assert required - theirs or theirs - required, f"{label} and {other} hold the same furniture"


def test_the_catalogue_is_large_and_stairs_are_bare():
    assert len(CATALOGUE) >= 80
    assert not [kind.name for kind in CATALOGUE.values() if STAIRS in kind.rooms]


def test_an_unknown_kind_is_refused():
    with pytest.raises(WorldsError, match=r"'throne'; valid: .*bookshelf"):
        kind_of("throne")


def test_the_refusal_of_an_unknown_kind_is_short_and_names_the_nearest_kinds_and_the_way_to_all():
    with pytest.raises(WorldsError) as error:
        kind_of("pianoo")
    message = str(error.value)
    for said in (" piano, ", f"{len(CATALOGUE)} kinds", "sorted(worlds.furniture.CATALOGUE)", "declared first"):
        assert said in message
    assert len(message) < 300
