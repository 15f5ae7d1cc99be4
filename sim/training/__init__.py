"""Training of the shipped encoder `lexis-mini`, and calibration of the probabilities of its answers.

`command` runs all steps and resumes each. `text_tower` distils a sentence encoder (`teacher`, `text_corpus`,
`text_target`); `frames` renders training images (`houses`, `viewpoints`, `variants`), `dense` and `align` are the two
stages of the image tower that `fit` optimises over `batches`, and `export` writes weights that open_clip loads. `lexicon`
and `phrases` hold the words; `places` trains embeddings to recognise places; `temperature` fits the scale that turns
similarities into probabilities; `array_cache` stores arrays that take long to make; `query_calibration` and
`query_questions` calibrate answers.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
