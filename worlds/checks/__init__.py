"""The checks behind `worlds.validation`: each module lists what is wrong with one aspect of a house, and where.

`plan_checks` looks at rooms and stairs, `opening_checks` at openings and windows, `furniture_checks` (with `collisions`) at
furniture and door leaves, and `reachability` (with `barriers`, which names what blocks the path) at paths on foot.
`plan_grid` cuts the plan into cells so that the answers are exact. `essentials` finds rooms that lack an essential piece,
which is no fault of a house, but should be rare.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
