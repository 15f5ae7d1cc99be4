"""`Actor`: something that moves in a house during a run. It is drawn into each image, outside of the compiled model."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

from jaxtyping import Float64
from numpy import ndarray

from worlds.visuals.meshes import Solid


class Actor(ABC):
    """Something that moves, such as a person or a closing door."""

    @abstractmethod
    def solids_at(self, stamp: float, T_W_B: Float64[ndarray, "4 4"]) -> Sequence[Solid]:
        """Return the actor's shape and place at time `stamp` [s], while the body that carries the camera is at `T_W_B`."""
