"""The vision-language model: images and room names become unit vectors in one space (paper, Sec. III-A).

`open_clip_encoder` is the encoder; `options` holds its settings, such as device and batch size. `model_source` and `hub`
find the weights, `model_loading` loads them, `preprocessing` prepares images, `prompts` turns room names into sentences, and
`image_cache` keeps embeddings on disk.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
