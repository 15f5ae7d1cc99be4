"""`StoreyDraft`: the rooms of one storey while its plan is being drawn up, as rectangles in whole centimetres.

The rooms of a draft have numbers instead of ids, and the spine (the corridor) runs east. `draft_storey` adds the indoor
rooms; `StoreyDraft.layout` names the rooms, mirrors and rotates the plan, and converts it to metres.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

from worlds.errors import WorldsError
from worlds.floor_plans.bays import bay_rooms
from worlds.floor_plans.programmes import Bay, BayGroup, StoreyProgramme
from worlds.floor_plans.rectangles import Corner, RectCm, SquareSymmetry, contact, metres, outline
from worlds.floor_plans.wings import Band, Shell
from worlds.labels import STAIRS
from worlds.layout import Link, StoreyLayout
from worlds.spec import OpeningKind, OpeningSpec, RoomSpec

_LEAST_HALL_M2 = {"lobby": 14.0, "entrance hall": 6.0}
"""Least area of an entrance hall or lobby at the start of the spine, by label [m²]."""
_LONGEST_HALL = 1100
"""Greatest length of an entrance hall or lobby [cm]; a longer hall would be a corridor."""
_NICHE = 60
"""Least distance between the end of the entrance hall and the stairs, if it is not 0; a smaller niche is useless [cm]."""
_LEAST_SHARED_WALL = 100
"""Least length of wall that two rooms share if a door is to connect them [cm]."""


@dataclass(frozen=True)
class PlacedBay:
    """A bay (a main room and the small rooms carved from it) with its position in a band (a row of rooms)."""

    band: Band
    bay: Bay
    start: int
    """Distance between the start of the band (the row of rooms) and the bay [cm]."""
    width: int
    """Length of the bay along the band (the row of rooms) [cm]."""
    joint: OpeningKind | None
    """Kind of the opening to the main room of the bay before this one; None: no opening."""
    wrap: int = 0
    """Length of the part that the main room has beyond the end of the spine (the corridor), if the room bends round that
    end [cm]; 0: the room does not bend."""


@dataclass(frozen=True)
class DraftRoom:
    """A room of the draft, without an id: its label and its rectangles [cm]."""

    label: str
    rects: tuple[RectCm, ...]
    seed: int | None = None


@dataclass
class StoreyDraft:
    """The rooms and links of a storey; a room's number is its index in `rooms`."""

    rooms: list[DraftRoom] = field(default_factory=list)
    links: list[tuple[int, int, OpeningKind, int | None]] = field(default_factory=list)
    """Requests for openings: the numbers of the two rooms, the kind of opening, and the seed (see `Link.seed`)."""
    gaps: list[tuple[int, int, str, tuple[Corner, Corner]]] = field(default_factory=list)
    """Openings to stairs, with positions: numbers of the two rooms (the stairs second), "up" or "down", both ends [cm]."""

    def add(self, label: str, rects: Sequence[RectCm], seed: int | None = None) -> int:
        """Add a room and return its number."""
        self.rooms.append(DraftRoom(label, tuple(rects), seed))
        return len(self.rooms) - 1

    def link(self, a: int, b: int, kind: OpeningKind = "door", seed: int | None = None) -> None:
        """Request an opening between two rooms, which are given by their numbers; `seed` is `Link.seed`."""
        self.links.append((a, b, kind, seed))

    def nearest(self, room: int, others: Sequence[int]) -> int:
        """Return the number of the room among `others` that shares the longest piece of wall with `room`.

        Raises `WorldsError` if even this piece is too short for a door.
        """
        shared = [contact(self.rooms[room].rects, self.rooms[k].rects) for k in others]
        if max(shared, default=0) < _LEAST_SHARED_WALL:
            raise WorldsError(f"no wall for the door of a {self.rooms[room].label!r}: it touches nothing that leads to it")
        return others[shared.index(max(shared))]

    def layout(self, level: int, turn: SquareSymmetry, height_m: float) -> StoreyLayout:
        """Return the storey as a layout: mirrored and rotated by `turn`, in metres, with an id for every room.

        An id consists of the label, the storey `level` and a number, such as "bedroom 1.2".
        """
        count: dict[str, int] = {}
        ids, rooms = [], []
        for room in self.rooms:
            count[room.label] = count.get(room.label, 0) + 1
            ids.append(f"{room.label} {level}.{count[room.label]}")
            polygon = tuple(metres(p) for p in outline([turn.rect(r) for r in room.rects]))
            rooms.append(RoomSpec(id=ids[-1], label=room.label, polygon_m=polygon, seed=room.seed))
        openings = []
        for a, b, leads, (start, end) in self.gaps:
            start_m, end_m = metres(turn.point(start)), metres(turn.point(end))
            openings.append(OpeningSpec(rooms=(ids[a], ids[b]), kind="open", start_m=start_m, end_m=end_m, leads=leads))  # type: ignore[arg-type]
        links = tuple(Link((ids[a], ids[b]), kind, seed) for a, b, kind, seed in self.links)
        return StoreyLayout(tuple(rooms), links, tuple(openings), height_m)


def draft_storey(
    level: int,
    storeys: int,
    programme: StoreyProgramme,
    shell: Shell,
    placed: Sequence[PlacedBay],
    slot: BayGroup | None,
    cross_apart: bool,
) -> tuple[StoreyDraft, list[int]]:
    """Return a draft of all indoor rooms of a storey, and the number of every bay's host, in the order of `placed`.

    A bay is a main room, its host, with the small rooms carved from it. To link two rooms is to request an opening.

    1. The spine (corridor) comes first, because almost all other rooms get their doors there. It consists of up to three
       rooms: an entrance hall, the corridor, and the corridor of the second wing (a room of its own if `cross_apart`).
    2. The stairs follow. Their openings to the spine are at the same places on every storey, since the flights begin and
       end there.
    3. Each bay is cut into rooms. The host is linked to the spine, a small room to the host or the spine, and hosts of the
       same group of bays to each other, if the group has such openings.
    4. The room behind the stairs (`slot`), if there is one, is linked to the piece of corridor beside the stairs.
    """
    draft = StoreyDraft()
    spine = _spine(draft, programme, shell, placed, cross_apart)
    if shell.stairs is not None:
        _stairs(draft, shell, spine, level, storeys)
    hosts = _bays(draft, shell, placed, spine)
    rect = shell.slot()
    if slot is not None and rect is not None:
        room = draft.add(slot.bays[0].labels[0], [rect], slot.bays[0].seed)
        draft.link(draft.nearest(room, spine), room)
    return draft, hosts


def _spine(
    draft: StoreyDraft, programme: StoreyProgramme, shell: Shell, placed: Sequence[PlacedBay], cross_apart: bool
) -> list[int]:
    """Add the rooms of the spine (corridor); return their numbers, from west to east, the second wing's corridor last.

    The spine ends where the last room along it ends, but never before the stairs or the second wing, so that it leads to
    both.
    """
    c, x = shell.depths.spine, shell.passage_start
    reach = [shell.edge(p.band).rect(p.start, 0, p.start + p.width, 0)[2] for p in placed if p.band not in ("west", "east")]
    cross = max((p.start + p.width for p in placed if p.band in ("west", "east")), default=0)
    end = max([*reach, 0]) if not shell.at_end else shell.length
    if shell.stairs and not shell.at_end:
        end = max(end, shell.stairs_start + shell.stairs.front)
    if cross:
        end = max(end, x + shell.depths.cross)
    end = min(end, shell.length)
    arms = [shell.stairs_edge().rect(*arm) for arm in shell.stairs.arms()] if shell.stairs else []
    wing = [(x, c, x + shell.depths.cross, c + shell.depths.north + cross)] if cross else []
    split = _hall_end(programme.hall, shell, placed, end) if programme.hall else 0
    parts = []
    if programme.hall and split:
        # The floor beside the stairs belongs to the part of the spine that it touches.
        in_hall = arms if _stairs_end(shell) <= split else []
        parts.append(draft.add(programme.hall, [(0, 0, split, c), *in_hall]))
        arms = [] if in_hall else arms
    main = [(split, 0, end, c), *arms] + ([] if cross_apart else wing)
    # A short spine that cannot be divided is the hall as a whole.
    label = programme.hall if programme.hall and not split and end <= _LONGEST_HALL else programme.spine
    parts.append(draft.add(label, main, programme.seed if programme.hall is None else None))
    if split:
        draft.link(parts[0], parts[1], "open")
    if cross_apart and wing:
        parts.append(draft.add(programme.spine, wing, None if programme.seed is None else programme.seed + 1))
        draft.link(parts[-2], parts[-1], "open")
    return parts


def _stairs_end(shell: Shell) -> int:
    """Return the position along the spine (corridor) where stairs on its north side end [cm]; 10 km if there are none."""
    return shell.stairs_start + shell.stairs.front if shell.stairs and not shell.at_end else 10**6


def _hall_end(hall: str, shell: Shell, placed: Sequence[PlacedBay], end: int) -> int:
    """Return the position along the spine (corridor) where the entrance hall ends and the corridor begins [cm].

    Every end of a bay (a main room with its small rooms) is a candidate. The westernmost candidate is chosen that meets all
    of these conditions; the result is 0 if no candidate does:

    - The hall has at least its least area, and the corridor has a useful length.
    - There is no narrow niche between the end of the hall and the stairs.
    - If a bay on the other side of the spine lies along both hall and corridor, its main room has the bay's whole front, and
      at least 3 m of this front lie along one of the two, for the door.
    """
    fronts = []
    for p in placed:
        if p.band not in ("west", "east"):
            r = shell.edge(p.band).rect(p.start, 0, p.start + p.width, 0)
            fronts.append((r[0], r[2], p.bay.form in ("plain", "inner")))
    limit = min(end - 400, _LONGEST_HALL, shell.passage_start if shell.depths.cross else end)
    least = max(250.0, 1e4 * _LEAST_HALL_M2.get(hall, 0.0) / shell.depths.spine)
    beside = (shell.stairs_start, _stairs_end(shell)) if shell.stairs and not shell.at_end else (0, 0)
    for cut in sorted({hi for _, hi, _ in fronts}):
        in_pieces = [(max(cut - lo, hi - cut), whole) for lo, hi, whole in fronts if lo < cut < hi]
        if not all(longer >= 300 and whole for longer, whole in in_pieces):
            continue
        clear = cut in beside or not beside[0] - _NICHE < cut < beside[1] + _NICHE
        if least <= cut <= limit and clear:
            return cut
    return 0


def _stairs(draft: StoreyDraft, shell: Shell, spine: Sequence[int], level: int, storeys: int) -> None:
    """Add the room of the stairs, and its openings to the spine (corridor) for the flights up and down from this storey."""
    stairs, edge = shell.stairs, shell.stairs_edge()
    if stairs is None:
        return
    room = draft.add(STAIRS, [edge.rect(*stairs.cell())])
    up, down = ((edge.point(*gap[:2]), edge.point(*gap[2:])) for gap in stairs.gaps())
    front = max(spine, key=lambda k: contact(draft.rooms[k].rects, [edge.rect(*stairs.gaps()[0])]))
    if level + 1 < storeys:
        draft.gaps.append((front, room, "up", up))
    if level > 0:
        draft.gaps.append((front, room, "down", down))


def _bays(draft: StoreyDraft, shell: Shell, placed: Sequence[PlacedBay], spine: Sequence[int]) -> list[int]:
    """Add the rooms of all bays and request their openings; return the number of every bay's main room (host)."""
    hosts: list[int] = []
    for p in placed:
        bay, depth = p.bay, shell.depths.of(p.band)
        rects = bay_rooms(bay, shell.edge(p.band), p.start, p.width, depth)
        if p.wrap:
            # The host continues past the spine's end, over the depth of the band and of the spine.
            end = p.start + p.width
            rects[0] += (shell.edge(p.band).rect(end, -shell.depths.spine, end + p.wrap, depth),)
        numbers = [
            draft.add(label, r, None if bay.seed is None else bay.seed + i)
            for i, (label, r) in enumerate(zip(bay.labels, rects, strict=True))
        ]
        host = numbers[0]
        draft.link(draft.nearest(host, spine), host, bay.entry, bay.seed)
        for label, small in zip(bay.labels[1:], numbers[1:], strict=True):
            # An "inner" room does not touch the spine, and a pantry belongs to its kitchen.
            way_in = host if bay.form == "inner" or label == "pantry" else draft.nearest(small, spine)
            draft.link(way_in, small, "door", bay.seed)
        if p.joint is not None:
            draft.link(hosts[-1], host, p.joint)
        hosts.append(host)
    return hosts
