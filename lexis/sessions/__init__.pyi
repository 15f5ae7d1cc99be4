from .compatibility import check_continues as check_continues
from .components import component_of as component_of
from .merging import merge as merge
