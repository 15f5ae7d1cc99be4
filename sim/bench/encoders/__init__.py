"""`lexis-sim bench encoders`: how well vision-language models name the rooms of test houses.

`measure` computes the figures of one encoder on the walks of `runs`: labels, `retrieval` of revisited places and answers to
`questions`. `ceiling` estimates the best accuracy that single images allow, and `times` measures inference times. `table`
writes and plots a table like Table I of the LEXIS paper. `texts` caches the embeddings of texts.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
