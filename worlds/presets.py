"""Families of houses over seeds, named after the paper's datasets (Sec. IV-A)."""

from collections.abc import Sequence

import numpy as np

from worlds.errors import WorldsError
from worlds.floor_plan import BandSizes, Sampler, StoreyPlan, lay_out, sample_sizes
from worlds.spec import HouseSpec

MAX_ROOMS_ASKED = 40
_OPEN_PLAN = (("kitchen", "dining room"), ("dining room", "living room"))


def sample_house(preset: str, seed: int) -> HouseSpec:
    """The house of a family that belongs to `seed`. Raises `WorldsError` for an unknown preset."""
    if preset not in PRESETS:
        raise WorldsError(f"unknown preset {preset!r}; valid: {', '.join(PRESETS)}")
    if not 0 <= seed < 2**63:
        raise WorldsError(f"house seed {seed} is not in 0 ... 2**63 - 1")
    plan_rng, layout_rng = (np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(2))
    plans, sizes = PRESETS[preset](plan_rng)
    return lay_out(f"{preset}-{seed}", seed, plans, sizes, layout_rng)


def sample_from_rooms(labels: Sequence[str], seed: int) -> HouseSpec:
    """A one-storey house with a corridor and a room for each of `labels`. Raises `WorldsError` for lists that cannot be."""
    unknown = [label for label in labels if label not in _INDOOR_POOL]
    if unknown:
        raise WorldsError(f"no room can be a {unknown[0]!r}; valid: {', '.join(_INDOOR_POOL)}")
    if not 1 <= len(labels) <= MAX_ROOMS_ASKED:
        raise WorldsError(f"{len(labels)} rooms were asked for; valid: 1 to {MAX_ROOMS_ASKED}")
    rng = np.random.default_rng(seed)
    order = _shuffled(tuple(labels), rng)
    half = (len(order) + 1) // 2
    width = max(6.0, 4.2 * half)
    return lay_out(
        f"rooms-{seed}", seed, [StoreyPlan(order[:half], order[half:])], sample_sizes(rng, (width, width + 1.0)), rng
    )


def _home(rng: np.random.Generator) -> tuple[Sequence[StoreyPlan], BandSizes]:
    living = ("kitchen", "dining room", "living room")
    ground = StoreyPlan(_either_way(living, rng), open_pairs=_OPEN_PLAN, garden="garden")
    upper = StoreyPlan(_shuffled(("bedroom", "bathroom", str(rng.choice(["children's room", "office", "bedroom"]))), rng))
    return (ground, upper), sample_sizes(rng, (10.8, 12.4))


def _ori(rng: np.random.Generator) -> tuple[Sequence[StoreyPlan], BandSizes]:
    ground = StoreyPlan(
        _shuffled(("office", "office", "kitchen", "meeting room"), rng), _shuffled(("office", "lobby", "office"), rng)
    )
    upper = StoreyPlan(_shuffled(("office", "office", "print room", "office"), rng))
    return (ground, upper), sample_sizes(rng, (14.0, 16.0))


def _uh2_apartment(rng: np.random.Generator) -> tuple[Sequence[StoreyPlan], BandSizes]:
    ground = StoreyPlan(_either_way(("dining room", "living room"), rng), open_pairs=_OPEN_PLAN)
    return (ground, StoreyPlan(("bedroom",)), StoreyPlan(("bathroom",))), sample_sizes(rng, (7.6, 8.6), (3.4, 4.0))


def _uh2_office(rng: np.random.Generator) -> tuple[Sequence[StoreyPlan], BandSizes]:
    south = _shuffled(("office", "office", "meeting room", "office", "open-plan office", "office"), rng)
    north = _shuffled(("office", "meeting room", "office", "open-plan office", "office"), rng)
    return (StoreyPlan(south, north),), sample_sizes(rng, (22.0, 26.0))


_INDOOR_POOL = (
    "kitchen", "dining room", "living room", "bedroom", "children's room", "bathroom", "toilet", "office", "meeting room",
    "open-plan office", "laundry room", "storage room", "pantry", "garage", "gym", "library", "classroom", "laboratory",
    "print room",
)  # fmt: skip


def _random(rng: np.random.Generator) -> tuple[Sequence[StoreyPlan], BandSizes]:
    def band(rooms: int) -> tuple[str, ...]:
        return tuple(str(label) for label in rng.choice(_INDOOR_POOL, rooms, replace=False))

    def storey() -> StoreyPlan:
        hall = str(rng.choice(["corridor", "corridor", "entrance hall", "lobby"]))
        return StoreyPlan(band(int(rng.integers(2, 4))), band(int(rng.integers(0, 4))), hall)

    return [storey() for _ in range(int(rng.integers(1, 3)))], sample_sizes(rng, (10.0, 13.0))


def _shuffled(labels: tuple[str, ...], rng: np.random.Generator) -> tuple[str, ...]:
    return tuple(labels[i] for i in rng.permutation(len(labels)))


def _either_way(labels: tuple[str, ...], rng: np.random.Generator) -> tuple[str, ...]:
    return labels if rng.random() < 0.5 else labels[::-1]


PRESETS: dict[str, Sampler] = {
    "home": _home,
    "ori": _ori,
    "uh2-apt": _uh2_apartment,
    "uh2-office": _uh2_office,
    "random": _random,
}
