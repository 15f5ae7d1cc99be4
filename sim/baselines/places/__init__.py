"""Methods of place recognition that LEXIS is compared with, on rendered walks.

Read `place_method` first: it is the interface of all methods, with the evidence that they are given. `by_embedding` compares
embeddings of single images or of sequences. `bag_of_words` follows DBoW2, with the vocabulary of a `word_tree`, and `vlad`
aggregates local descriptors. `descriptors` computes ORB descriptors and describes the training images, `patches` computes
features of the encoder for parts of an image, and `dbow2_file` writes a vocabulary for ORB-SLAM. `lexis_places` wraps the
methods of LEXIS.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
