"""The feature sensor: predicts the percepts that LEXIS would extract from images, without rendering the images.

A percept contains mainly the embedding of an image, and is made in steps. `surroundings` describes a house as blocks.
`ray_origins` and `crossings` prepare the rays that `rays` casts from a pose. `visible_shares` sums up how much of the image
each thing fills, and `embedding` draws an embedding from a model of the encoder. `true_view` tells what two views share;
with it, `covisibility_verifier` replaces geometric verification of loops. `oracle` is an encoder without error.
`sensed_camera` puts this together for one camera, and `sensor` for all cameras of a rig. `model` holds all fitted
parameters, which `sim.feature_fitting` fits to a real encoder.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
