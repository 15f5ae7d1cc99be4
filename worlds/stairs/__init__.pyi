from .build import Stairs as Stairs
from .build import build_stairs as build_stairs
