"""What moves in a house while it is looked at: drawn into each image, never a part of the compiled model."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

from jaxtyping import Float64
from numpy import ndarray

from worlds.visuals.meshes import Solid


class Actor(ABC):
    """Something that moves."""

    @abstractmethod
    def solids_at(self, stamp: float, T_W_B: Float64[ndarray, "4 4"]) -> Sequence[Solid]:
        """What it looks like and where, at a time [s] when the camera's body is at a pose."""
