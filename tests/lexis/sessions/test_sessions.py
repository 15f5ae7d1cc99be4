"""Sessions on generated houses, by the feature sensor: a second walk through a house is joined to the map of the first."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.same_map import assert_same

from lexis.errors import MapError
from lexis.evaluation.trajectory import ate
from lexis.map.folder import load_map, save_map
from lexis.sessions.components import component_of
from sim.bench.sessions import HomeMap, second_session
