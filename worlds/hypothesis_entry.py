"""The entry point through which Hypothesis learns that `st.from_type(HouseSpec)` draws `houses()`.

Hypothesis calls `register` while Hypothesis itself is being imported. If a program imports `worlds.strategies` first, that
module imports Hypothesis, and is therefore only partly loaded when `register` is called. So this module imports Hypothesis
and `worlds.strategies` inside its functions only.
"""

from typing import TYPE_CHECKING

from worlds.spec import HouseSpec

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy


def register() -> None:
    """Tell Hypothesis that the strategy for `HouseSpec` is `houses()`."""
    from hypothesis.strategies import register_type_strategy

    register_type_strategy(HouseSpec, _houses)


def _houses(_: type[HouseSpec]) -> "SearchStrategy[HouseSpec]":
    from worlds.strategies import houses

    return houses()
