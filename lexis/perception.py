"""What LEXIS makes of one observation: an embedding and key points, its own or those that came instead of the image."""

import numpy as np
from jaxtyping import Float32

from lexis.encoder import Encoder
from lexis.features import FeatureExtractor
from lexis.types import Features, Observation, Percept


def embedding_of(observation: Observation, encoder: Encoder) -> Float32[np.ndarray, "d"]:
    """f_CLIP of an observation."""
    seen = observation.image
    return seen.embedding if isinstance(seen, Percept) else encoder.encode_image(seen)


def features_of(observation: Observation, extractor: FeatureExtractor) -> Features:
    """f_AKAZE of an observation."""
    seen = observation.image
    return seen.features if isinstance(seen, Percept) else extractor.extract(seen)
