"""`Actor`: base class of things that move in a house during a run. They are drawn, but are not part of the model."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

from jaxtyping import Float64
from numpy import ndarray

from worlds.visuals.meshes import Solid


class Actor(ABC):
    """Something that moves in a house, such as a person or a closing door."""

    @abstractmethod
    def solids_at(self, stamp: float, T_W_B: Float64[ndarray, "4 4"]) -> Sequence[Solid]:
        """Return the actor's parts and its pose at time `stamp` [s].

        `T_W_B` is the pose of the body that carries the camera at this time.
        """
