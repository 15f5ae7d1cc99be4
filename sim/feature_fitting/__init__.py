"""Fits the model of the feature sensor to a real encoder. The sensor predicts what LEXIS would extract from images.

`fit` runs all steps. `fit_samples` renders views of a few houses and encodes them, `fit_embedding` fits the model of
embeddings to these views, and `fit_loops` fits the model of loop verification to runs of LEXIS on rendered images.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
