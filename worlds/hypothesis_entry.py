"""The entry point through which Hypothesis learns that `st.from_type(HouseSpec)` draws `houses()`.

Hypothesis calls `register` while it is itself being imported. `worlds.strategies` imports Hypothesis, so that it would be
half imported when it is imported first and Hypothesis asks for it; this module imports neither before it is needed.
"""

from typing import TYPE_CHECKING

from worlds.spec import HouseSpec

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy


def register() -> None:
    """Register the strategy of `HouseSpec`."""
    from hypothesis.strategies import register_type_strategy

    register_type_strategy(HouseSpec, _houses)


def _houses(_: type[HouseSpec]) -> "SearchStrategy[HouseSpec]":
    from worlds.strategies import houses

    return houses()
