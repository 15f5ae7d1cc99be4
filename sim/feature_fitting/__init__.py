"""Fits the model of the feature sensor to a real encoder, from renders of a few houses.

`fit` orders the steps: `fit_samples` renders views of houses and encodes them, `fit_embedding` fits the model of embeddings
to these views, and `fit_loops` fits the model of loop verification to runs of LEXIS on renders.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
