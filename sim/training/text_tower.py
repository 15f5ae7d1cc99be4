"""Training of the text tower of `lexis-mini` by distillation from a sentence encoder, without images.

The tower is open_clip's text transformer with CLIP's vocabulary. It learns to reproduce the teacher's embeddings (after the
map of `text_target`) of single words, random compositions and captions. So words that occur in no caption get meaningful
embeddings, too. Later the image tower is aligned with the text tower, which then stays fixed (`align`).
"""

import logging
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import open_clip.tokenizer
import torch
from jaxtyping import Float, Float32, Int
from open_clip.transformer import TextTransformer
from safetensors import SafetensorError
from safetensors.torch import load_file, save_file
from torch import Tensor, nn

from lexis.errors import one_line
from lexis.files.replace import replaced_file
from sim.errors import SimError
from sim.training.teacher import SentenceEncoder
from sim.training.text_corpus import captions, compositions, near_words, plain_words, room_scenes
from sim.training.text_target import fit_target_map, labelled_captions

EMBED_DIM = 256
TEXT_CFG: Mapping[str, int] = {"context_length": 24, "vocab_size": 49408, "width": 160, "heads": 5, "layers": 2}
"""Architecture of the text tower, as in an open_clip model configuration."""

_POOL_BATCHES = 20
"""Number of batches in a pool. Texts are sorted by length within pools, so that little padding is needed."""
_INIT_DEVIATION = 0.3
"""Standard deviation of the initial token embeddings of words."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class DistilConfig:
    """Settings of training the text tower: amount of text, length of training and parameters of the optimiser."""

    compositions: int = 250_000
    scenes: int = 15_000
    near: int = 2_500
    """Number of words of the vocabulary that count as related to houses, because they are most similar to captions of rooms
    according to the teacher. Most words of the random compositions are drawn from these words and the words of captions."""
    epochs: int = 3
    batch: int = 512
    learning_rate: float = 2e-3
    weight_decay: float = 0.01
    seed: int = 0


@dataclass(frozen=True)
class DistilProgress:
    """The progress of training the text tower, as it is reported after an epoch."""

    epoch: int
    cosine: float
    """Cosine similarity between the tower's outputs and their targets, averaged over the epoch."""


@dataclass(frozen=True, eq=False)
class Lesson:
    """Training data of the text tower: tokenised texts and the target embedding of each text."""

    tokens: Int[Tensor, "n t"]
    targets: Float[Tensor, "n e"]
    words: Int[np.ndarray, "w"]
    """Indices of the texts that are single words."""


def distil(
    teacher: SentenceEncoder,
    config: DistilConfig,
    report: Callable[[DistilProgress], None],
    text_cfg: Mapping[str, int] = TEXT_CFG,
    embed_dim: int = EMBED_DIM,
) -> TextTransformer:
    """Train a text tower to imitate `teacher`. With one torch thread, every run gives the same weights."""
    lesson = prepare(teacher, config, text_cfg["context_length"], embed_dim)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(config.seed)
        tower = TextTransformer(output_dim=embed_dim, **text_cfg)
    _begin_with_words(tower, lesson)
    optimiser = torch.optim.AdamW(_groups(tower, config.weight_decay), config.learning_rate, betas=(0.9, 0.99), fused=True)
    steps = config.epochs * (len(lesson.tokens) // config.batch)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, config.learning_rate, total_steps=max(steps, 1), pct_start=0.1)
    for epoch in range(config.epochs):
        cosines = []
        for chosen in _batches(lesson.tokens, config.batch, np.random.default_rng([config.seed, 1, epoch])):
            said = nn.functional.normalize(encode(tower, lesson.tokens[chosen]), dim=-1)
            cosine = (said * lesson.targets[chosen]).sum(dim=-1).mean()
            optimiser.zero_grad()
            (1.0 - cosine).backward()  # type: ignore[no-untyped-call]
            optimiser.step()
            schedule.step()
            cosines.append(cosine.item())
        report(DistilProgress(epoch + 1, float(np.mean(cosines))))
    return tower.eval()


def prepare(teacher: SentenceEncoder, config: DistilConfig, context_length: int, embed_dim: int) -> Lesson:
    """Draw the training texts, and compute their targets from the teacher's embeddings."""
    rng = np.random.default_rng([config.seed, 0])
    words = plain_words(teacher.words)
    vectors = _ask(teacher, words)
    labelled = labelled_captions()
    rooms = _ask(teacher, labelled.texts)
    near = near_words(words, vectors, _centres(rooms, labelled.rooms), config.near)
    rest = (*captions(), *room_scenes(config.scenes, rng), *compositions(words, near, config.compositions, rng))
    everything = np.concatenate([vectors, _ask(teacher, rest)])
    target = fit_target_map(rooms, labelled, everything, embed_dim)
    tokens = tokenizer(context_length)([*words, *rest])
    return Lesson(tokens, torch.from_numpy(target(everything)), np.arange(len(words)))


@cache
def tokenizer(context_length: int) -> open_clip.tokenizer.SimpleTokenizer:
    """Return CLIP's tokenizer. It is cached, since reading its vocabulary takes a third of a second."""
    return open_clip.tokenizer.SimpleTokenizer(context_length=context_length)


def encode(tower: TextTransformer, tokens: Int[Tensor, "n t"]) -> Float[Tensor, "n e"]:
    """Compute `tower(tokens)` faster, without the padding. Padding has no influence, since attention is causal."""
    length = int((tokens != 0).sum(dim=1).max())
    tokens = tokens[:, :length]
    x = tower.token_embedding(tokens) + tower.positional_embedding[:length]
    x = tower.ln_final(tower.transformer(x, attn_mask=tower.attn_mask[:length, :length]))
    return x[torch.arange(len(tokens)), tokens.argmax(dim=-1)] @ tower.text_projection  # type: ignore[no-any-return]


def encode_texts(tower: TextTransformer, texts: Sequence[str]) -> Float32[np.ndarray, "n e"]:
    """Return the embeddings of texts by the text tower, scaled to unit norm."""
    tokens = tokenizer(tower.context_length)(list(texts))
    with torch.inference_mode():
        parts = [nn.functional.normalize(encode(tower, part), dim=-1) for part in tokens.split(512)]
    return torch.cat(parts).numpy()


def save_text_tower(tower: TextTransformer, path: Path) -> None:
    """Write a text tower to a safetensors file, in half precision. Parameters are named as in an open_clip model."""
    with replaced_file(path) as beside:
        save_file({name: value.half().contiguous() for name, value in tower.state_dict().items()}, beside)


def load_text_tower(path: Path) -> TextTransformer:
    """Load a text tower that `save_text_tower` wrote. Raises `SimError` for a damaged file or another architecture."""
    tower = TextTransformer(output_dim=EMBED_DIM, **TEXT_CFG).eval()
    try:
        tower.load_state_dict({name: value.float() for name, value in load_file(path).items()})
    except (OSError, RuntimeError, SafetensorError) as error:
        raise SimError(
            f"{path}: no text tower of the present shape: {one_line(error)}; delete it to train it again"
        ) from None
    return tower


def _begin_with_words(tower: TextTransformer, lesson: Lesson) -> None:
    """Initialise the token embedding of every word with the first entries of the word's target embedding.

    The target embedding is the embedding that the text tower has to learn for the word. Training then starts from a
    bag-of-words model, instead of from noise.
    """
    width = tower.token_embedding.embedding_dim
    single = lesson.words[((lesson.tokens[lesson.words] != 0).sum(dim=1) == 3).numpy()]  # tokens: start, word, end
    targets = lesson.targets[single][:, :width]
    kept = targets.shape[1]
    with torch.no_grad():
        tower.token_embedding.weight[lesson.tokens[single, 1], :kept] = targets * (_INIT_DEVIATION / targets.std())
        tower.token_embedding.weight[:] = tower.token_embedding.weight[_whole_word_of()]
        tower.text_projection[:kept, :kept] += 0.5 * torch.eye(kept)


def _whole_word_of() -> Int[Tensor, "vocabulary"]:
    """Map the token of each word piece ("bath" in "bathtub") to the token of the whole word ("bath"), or else to itself."""
    index = open_clip.tokenizer.SimpleTokenizer().encoder
    return torch.tensor([index.get(token + "</w>", own) for token, own in index.items()])


def _ask(teacher: SentenceEncoder, texts: Sequence[str]) -> Float32[np.ndarray, "n d"]:
    started = time.perf_counter()
    embeddings = teacher.encode(texts)
    _log.info("asked the teacher for %d texts in %.0f s", len(texts), time.perf_counter() - started)
    return embeddings


def _centres(rows: Float32[np.ndarray, "n d"], groups: Int[np.ndarray, "n"]) -> Float32[np.ndarray, "g d"]:
    means = np.stack([rows[groups == group].mean(axis=0) for group in np.unique(groups)])
    return np.asarray(means / np.linalg.norm(means, axis=1, keepdims=True), np.float32)


def _groups(tower: nn.Module, weight_decay: float) -> list[dict[str, object]]:
    """Return the optimiser's parameter groups: matrices have weight decay; biases, norms and embeddings have none.

    Most tokens occur rarely, and with weight decay their embeddings would shrink between two occurrences.
    """
    named = list(tower.named_parameters())
    decayed = [p for name, p in named if p.ndim > 1 and "embedding" not in name]
    free = [p for name, p in named if p.ndim < 2 or "embedding" in name]
    return [{"params": decayed, "weight_decay": weight_decay}, {"params": free, "weight_decay": 0.0}]


def _batches(tokens: Int[Tensor, "n t"], size: int, rng: np.random.Generator) -> Iterator[Int[np.ndarray, "b"]]:
    lengths = (tokens != 0).sum(dim=1).numpy()
    order = rng.permutation(len(tokens))
    pools = (order[i : i + size * _POOL_BATCHES] for i in range(0, len(order), size * _POOL_BATCHES))
    sorted_pools = (pool[np.argsort(lengths[pool], kind="stable")] for pool in pools)
    batches = [pool[i : i + size] for pool in sorted_pools for i in range(0, len(pool) - size + 1, size)]
    yield from (batches[i] for i in rng.permutation(len(batches)))
