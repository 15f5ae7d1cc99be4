"""`CATALOGUE`: every kind of furniture by name. Importing this module imports all modules that declare kinds.

Users get `furniture` from here, so that the shipped kinds come first: a user's kind with the name of a shipped kind is then
refused at the user's declaration.
"""

from collections.abc import Mapping
from difflib import get_close_matches
from importlib import import_module
from types import MappingProxyType

from worlds.errors import WorldsError
from worlds.furniture.kinds import Kind
from worlds.furniture.registry import KINDS
from worlds.furniture.registry import furniture as furniture

_THEMES = (
    "kitchen", "dining", "living", "bedroom", "bathroom", "office",
    "hall", "utility", "outdoor", "decor", "public", "clutter",
)  # fmt: skip

for _theme in _THEMES:
    import_module(f"worlds.furniture.{_theme}")

CATALOGUE: Mapping[str, Kind] = MappingProxyType(KINDS)


def kind_of(name: str) -> Kind:
    """Return the kind called `name`. Raises `WorldsError`, which names the most similar kinds, if no kind has this name."""
    if name not in CATALOGUE:
        some = ", ".join(dict.fromkeys([*get_close_matches(name, CATALOGUE), "bookshelf"]))
        raise WorldsError(
            f"unknown furniture kind {name!r}; valid: one of {len(CATALOGUE)} kinds, such as {some}; in Python, "
            "sorted(worlds.furniture.CATALOGUE) lists them; a kind of your own has to be declared first (see "
            "Furniture of your own in worlds/README.md)"
        )
    return CATALOGUE[name]
