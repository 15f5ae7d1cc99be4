"""Laws of the shapes: authors of furniture get all of them from `worlds.furniture`."""

import inspect

from worlds import furniture
from worlds.furniture import shapes


def test_every_shape_is_exported():
    functions = inspect.getmembers(
        shapes, lambda member: inspect.isfunction(member) and member.__module__ == shapes.__name__
    )
    public = {name: function for name, function in functions if not name.startswith("_")}
    assert len(public) > 10
    assert {name: getattr(furniture, name, None) for name in public} == public
