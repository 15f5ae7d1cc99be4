"""The houses of a benchmark: those of a preset, one for each seed, and the same houses with more or fewer inner walls."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from sim.harness import RunConfig
from sim.harness.parts import house_spec
from worlds.variant import variant


def configs(config: RunConfig, seeds: Sequence[int], openness: float | None = None) -> Iterator[RunConfig]:
    """One configuration for each seed, all else as in `config`.

    With `openness`, in [0, 1], inner walls of every house open or close until it is reached. Raises `WorldsError` for
    another value.
    """
    for seed in seeds:
        own = replace(config, seed=seed)
        yield own if openness is None else replace(own, house=variant(house_spec(own), openness=openness))
