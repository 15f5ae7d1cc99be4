"""The houses of a benchmark: one house of a preset for each seed, as sampled or with a given openness of inner walls."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from sim.harness import Scenario
from sim.harness.run_settings import house_spec, in_house
from worlds.variant import variant


def for_seeds(scenario: Scenario, seeds: Sequence[int], openness: float | None = None) -> Iterator[Scenario]:
    """Yield one scenario for each seed; all other settings are those of `scenario`.

    If `openness` is given, inner walls of every house are opened or closed until the house has that openness; the length of
    the walk stays. Raises `WorldsError` if `openness` is outside [0, 1].
    """
    for seed in seeds:
        own = replace(scenario, seed=seed)
        yield own if openness is None else varied(own, openness=openness)


def varied(scenario: Scenario, *, openness: float | None = None, clutter: float | None = None) -> Scenario:
    """Return the scenario in its house with another openness or clutter; the length of the walk stays. See `variant`."""
    return in_house(scenario, variant(house_spec(scenario), openness=openness, clutter=clutter))
