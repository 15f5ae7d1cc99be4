"""Trains the included encoder `lexis-mini`, which has an image tower and a text tower, and calibrates its probabilities.

`command` runs all steps; an interrupted run resumes. `text_tower` trains the text tower to imitate a sentence encoder
(`teacher`); `text_corpus` makes the texts for this, and `text_target` the targets. `frames` renders training images of the
`houses` from `viewpoints`; `variants` keeps some colours of furniture out of training. The image tower is trained in two
stages, `dense` and `align`; `fit` is the training loop of both stages, over `batches` of images. At the end, `settling`
trains its last layer alone, also by `pooling` the evidence of several images, and by what the `columns` of an image show.
`export` writes weights that open_clip loads.

`lexicon` and `phrases` hold the words of captions. `places` trains embeddings to recognise places. `temperature` fits the
scale that turns similarities into probabilities. `array_cache` stores arrays that take long to make. `question_calibration`
calibrates the probabilities of answers to `random_questions`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
