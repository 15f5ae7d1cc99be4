"""The entry point through which Hypothesis learns that `st.from_type(HouseSpec)` draws `houses()`.

Hypothesis calls `register` while it is being imported itself. If a program imports `worlds.strategies` first, that module
imports Hypothesis and is therefore only partly loaded when `register` is called. So this module imports neither of the two
until it needs them.
"""

from typing import TYPE_CHECKING

from worlds.spec import HouseSpec

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy


def register() -> None:
    """Tell Hypothesis which strategy draws a `HouseSpec`."""
    from hypothesis.strategies import register_type_strategy

    register_type_strategy(HouseSpec, _houses)


def _houses(_: type[HouseSpec]) -> "SearchStrategy[HouseSpec]":
    from worlds.strategies import houses

    return houses()
