"""`lexis-sim bench encoders`: how well an encoder labels keyframes of test houses, finds revisits and answers questions.

It also measures how well the encoder's probabilities are calibrated. All figures are computed from the embeddings alone,
without any refinement by LEXIS.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float32, Int, UInt8
from scipy.special import softmax

from lexis.evaluation import calibration_error
from sim.baselines.places.bag_of_words import l1_scores
from sim.baselines.places.descriptors import strongest_orb
from sim.baselines.places.word_tree import WordTree
from sim.bench.encoders.ceiling import Ceiling, own_room, own_room_prevails
from sim.bench.encoders.questions import HELD_OUT_WORDS, TOPICS, TRAINED, AnsweredQuestion, ask, share_right
from sim.bench.encoders.retrieval import found_at_1, share
from sim.bench.encoders.runs import EncoderRun
from sim.bench.encoders.texts import EmbeddedTexts, ImageTextEncoder
from sim.bench.row_files import mean_and_std
from sim.training.phrases import HELD_OUT_NAMES, ROOM_NAMES, Table
from worlds.labels import ROOM_LABELS

_NAME_SETS = 12


@dataclass(frozen=True)
class EncoderRow:
    """Figures of one encoder on one house, in [0, 1]. A figure is None if the questions or revisits for it are missing."""

    accuracy: float
    """Zero-shot label accuracy among the labels of the house."""
    ceiling: float | None
    """Label accuracy of a reference classifier that knows the true content of every image: the attainable accuracy.

    None if there are no training frames for the classifier.
    """
    trained_names: float
    """Mean label accuracy if rooms are given random names that were used in training."""
    held_out_names: float
    """Mean label accuracy if rooms are given random names that were never used in training."""
    things: float | None
    """Share of right answers to questions for a thing that stands in rooms of one label only. An answer is right if the room
    that is ranked first has this label."""
    typical_things: float | None
    """Share of right answers to questions for things typical of a room label: the room ranked first has this label."""
    activities: float | None
    """Share of right answers to questions for activities typical of a room label: the room ranked first has this label."""
    held_out_questions: float | None
    """Mean of the shares for `things`, `typical_things` and `activities` if the questions are asked in words that were never
    used in training."""
    trained_looks: float
    """Label accuracy in houses with a texture and a lighting that occur together in training."""
    held_out_looks: float
    """Label accuracy with the same textures and lightings, but in pairs that never occur together in training."""
    trained_variants: float
    """Label accuracy with furniture only in colours that occur in training."""
    held_out_variants: float
    """Label accuracy with furniture in colours that never occur in training."""
    recall: float | None
    """Recall@1 of revisits, by the cosine similarity of embeddings."""
    recall_in_room: float | None
    """Recall@1 of revisits if only keyframes with the query's predicted label are searched."""
    recall_orb: float | None
    """Recall@1 of revisits by ORB bag-of-words."""
    calibration_error: float
    """Expected calibration error of probabilities at the model's own temperature. The few frames of one house inflate it."""


@dataclass(frozen=True, eq=False)
class EncoderFigures:
    """The figures of one encoder on one house, with the results for every frame, revisit and question."""

    seed: int
    row: EncoderRow
    confidence: Float[np.ndarray, "n"]
    """Probability of the label that was predicted for each frame."""
    right: Bool[np.ndarray, "n"]
    """For each frame, whether the predicted label is right."""
    ceiling_right: Bool[np.ndarray, "n"] | None
    """For each frame, whether the reference classifier of `EncoderRow.ceiling` predicts the right label; None if there is no
    classifier."""
    found: Mapping[str, Bool[np.ndarray, "revisits"]]
    """For each revisit, whether it was found; the keys are the names of the recalls in `EncoderRow`."""
    own_room: Float[np.ndarray, "n"]
    """For each frame, the share of the image that shows rooms with the label of the camera's room."""
    prevails: Bool[np.ndarray, "n"]
    """For each frame, whether the room label with the largest share of the image is that of the camera's room."""
    asked: Sequence[AnsweredQuestion]
    held_out_losses: Mapping[tuple[str, str], float]
    """Loss of label accuracy if the rooms of one label get a name that was never used in training, and all other rooms keep
    their names. The keys are (label, new name)."""


@dataclass(frozen=True, eq=False)
class References:
    """The methods that encoders are compared with."""

    ceiling: Ceiling | None = None
    orb: WordTree | None = None
    """The vocabulary of the ORB bag-of-words."""

    def of(self, run: EncoderRun) -> "ReferenceAnswers":
        """Return the answers of the reference methods on one run. These answers do not depend on the encoder."""
        right = None if self.ceiling is None else self.ceiling(run.frames) == run.frames.rooms
        if self.orb is None:
            return ReferenceAnswers(right, {})
        earlier = l1_scores(self.orb.histograms([strongest_orb(image) for image in run.frames.images]))
        return ReferenceAnswers(right, {"recall_orb": found_at_1(earlier + earlier.T, run.T_W_B, run.stamps)})


class ReferenceAnswers(NamedTuple):
    """Answers of the reference methods (the ceiling classifier and ORB bag-of-words) on one run."""

    ceiling_right: Bool[np.ndarray, "n"] | None
    found: Mapping[str, Bool[np.ndarray, "revisits"]]


def measure(
    encoders: Sequence[ImageTextEncoder], runs: Iterable[EncoderRun], references: References
) -> Iterator[list[EncoderFigures]]:
    """Yield for every run the figures of all encoders, in the order of `encoders`."""
    texts = [EmbeddedTexts(encoder) for encoder in encoders]
    for run in runs:
        beside = references.of(run)
        yield [_measured(run, encoder, known, beside) for encoder, known in zip(encoders, texts, strict=True)]


def _measured(run: EncoderRun, encoder: ImageTextEncoder, texts: EmbeddedTexts, beside: ReferenceAnswers) -> EncoderFigures:
    frames, images = run.frames, encoder.encode_images(run.frames.images)
    present, own = np.unique(frames.rooms, return_inverse=True)
    names = [ROOM_LABELS[i] for i in present]
    rooms = texts.rooms(names)
    similarities = images @ rooms.T
    said = similarities.argmax(axis=1)
    right = said == own
    confidence = softmax(similarities / encoder.temperature, axis=1).max(axis=1)
    asked = ask(run, images, texts)
    found = {
        "recall": found_at_1(images @ images.T, run.T_W_B, run.stamps),
        "recall_in_room": found_at_1(images @ images.T, run.T_W_B, run.stamps, said),
        **beside.found,
    }
    trained_names, held_out_names = (
        _renamed(images, texts, names, own, table, run.draw.seed) for table in (ROOM_NAMES, HELD_OUT_NAMES)
    )
    things, typical_things, activities = (share_right(asked, topic, TRAINED)[0] for topic in TOPICS)
    row = EncoderRow(
        accuracy=float(right.mean()),
        ceiling=None if beside.ceiling_right is None else float(beside.ceiling_right.mean()),
        trained_names=trained_names,
        held_out_names=held_out_names,
        things=things,
        typical_things=typical_things,
        activities=activities,
        held_out_questions=mean_and_std(share_right(asked, topic, HELD_OUT_WORDS)[0] for topic in TOPICS)[0],
        trained_looks=_in_looks(encoder, run.trained_looks, rooms, own[run.looked_at]),
        held_out_looks=_in_looks(encoder, run.held_out_looks, rooms, own[run.looked_at]),
        trained_variants=_in_looks(encoder, run.trained_variants, rooms, own[run.looked_at]),
        held_out_variants=_in_looks(encoder, run.held_out_variants, rooms, own[run.looked_at]),
        recall=share(found["recall"]),
        recall_in_room=share(found["recall_in_room"]),
        recall_orb=share(found["recall_orb"]) if "recall_orb" in found else None,
        calibration_error=calibration_error(confidence, right),
    )
    seen = own_room(frames), own_room_prevails(frames)
    losses = _held_out_losses(images, texts, names, own, similarities)
    return EncoderFigures(run.draw.seed, row, confidence, right, beside.ceiling_right, found, *seen, asked, losses)


def overall_calibration_error(houses: Sequence[EncoderFigures]) -> float:
    """Return the expected calibration error over the frames of all houses."""
    confidence = np.concatenate([house.confidence for house in houses])
    return calibration_error(confidence, np.concatenate([house.right for house in houses]))


def _in_looks(
    encoder: ImageTextEncoder,
    looks: UInt8[np.ndarray, "looks k h w 3"],
    rooms: Float32[np.ndarray, "rooms d"],
    own: Int[np.ndarray, "k"],
) -> float:
    return float(np.mean([(encoder.encode_images(images) @ rooms.T).argmax(axis=1) == own for images in looks]))


def _renamed(
    images: Float32[np.ndarray, "n d"],
    texts: EmbeddedTexts,
    names: Sequence[str],
    own: Int[np.ndarray, "n"],
    table: Table,
    seed: int,
) -> float:
    """Return the mean label accuracy over several lists of names, in which every label has a random name from the table."""
    rng = np.random.default_rng(seed)
    lists = [[table[name][int(rng.integers(len(table[name])))] for name in names] for _ in range(_NAME_SETS)]
    return float(np.mean([((images @ texts.rooms(chosen).T).argmax(axis=1) == own).mean() for chosen in lists]))


def _held_out_losses(
    images: Float32[np.ndarray, "n d"],
    texts: EmbeddedTexts,
    names: Sequence[str],
    own: Int[np.ndarray, "n"],
    similarities: Float32[np.ndarray, "n rooms"],
) -> dict[tuple[str, str], float]:
    """Compute `EncoderFigures.held_out_losses`. `similarities` compares the images with all labels of the house."""
    before = (similarities.argmax(axis=1) == own).mean()
    losses = {}
    for room, label in enumerate(names):
        for name, embedding in zip(HELD_OUT_NAMES[label], texts.rooms(HELD_OUT_NAMES[label]), strict=True):
            renamed = similarities.copy()
            renamed[:, room] = images @ embedding
            losses[label, name] = float(before - (renamed.argmax(axis=1) == own).mean())
    return losses


def worst_names(houses: Sequence[EncoderFigures]) -> list[tuple[str, str, float]]:
    """Return (label, held-out name, mean loss) for all held-out names that reduce label accuracy, worst first.

    The mean is over the houses that have rooms of the label.
    """
    losses: dict[tuple[str, str], list[float]] = defaultdict(list)
    for house in houses:
        for key, loss in house.held_out_losses.items():
            losses[key].append(loss)
    means = ((label, name, float(np.mean(each))) for (label, name), each in losses.items())
    return sorted((row for row in means if row[2] > 0.0), key=lambda row: -row[2])
