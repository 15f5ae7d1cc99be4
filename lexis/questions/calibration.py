"""Calibration of an encoder: a model that converts similarities to probabilities, fitted where the truth is known.

    p = sigmoid((similarity - threshold) / temperature),  threshold = base + slope * familiarity

The familiarity of a text is its largest cosine similarity to the room names that were used for the calibration. The
threshold depends on it, because texts that an encoder knows well have larger similarities to all images, right or wrong.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float, Float32
from pydantic import BaseModel, Field
from scipy.special import expit

from lexis.errors import LexisError
from lexis.files.models import STRICT, RoomNames
from lexis.files.reading import FileKind, read_model
from lexis.files.replace import replaced_file
from lexis.perception import TextEncoder

MINI_CALIBRATION = Path(__file__).parents[1] / "models" / "lexis-mini.calibration.json"
_FILE = FileKind("a file of calibrate-queries", 1_000_000)


@dataclass(frozen=True)
class Calibration:
    """Converts the similarity of a text and the best views of a room to the probability that the room fits the text.

    A calibration is fitted to one encoder. The formula is in the docstring of this module.
    """

    fingerprint: str
    """Fingerprint of the encoder that was calibrated."""
    room_names: tuple[str, ...]
    """Room names that the calibration used. Every text is compared with them; see `familiarity`."""
    base: float
    slope: float
    temperature: float

    def probabilities(
        self, similarities: Float[np.ndarray, "rooms texts"], questions: Float32[np.ndarray, "texts d"], encoder: TextEncoder
    ) -> Float[np.ndarray, "rooms texts"]:
        """Return the probability that each room fits each text, on the assumption that half of all questions have an answer.

        Args:
            similarities: mean similarity of every room's best views to every text.
            questions: embeddings of the texts, with unit norm.
            encoder: the encoder that was calibrated.
        """
        thresholds = self.base + self.slope * familiarity(questions, self.room_names, encoder)
        return np.asarray(expit((similarities - thresholds) / self.temperature))


def familiarity(
    questions: Float32[np.ndarray, "texts d"], room_names: Sequence[str], encoder: TextEncoder
) -> Float[np.ndarray, "texts"]:
    """Return the familiarity of every text: its cosine similarity to the most similar room name."""
    return np.asarray((questions @ encoder.encode_texts(room_names).T).max(axis=1))


class _Calibration(BaseModel):
    model_config = STRICT

    schema_version: Literal[1] = Field(alias="schema")
    fingerprint: str
    room_names: RoomNames
    base: float
    slope: float
    temperature: float = Field(gt=0)


def save_calibration(calibration: Calibration, path: Path) -> None:
    """Write a file that `load_calibration` reads. Raises LexisError if it cannot be written."""
    data = _Calibration(schema=1, **vars(calibration)).model_dump(by_alias=True)
    with replaced_file(path) as beside:
        beside.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")


def load_calibration(path: Path) -> Calibration:
    """Read a file that was written by `save_calibration`. Raises LexisError for anything else."""
    data = read_model(path, _FILE, _Calibration)
    return Calibration(**data.model_dump(exclude={"schema_version"}))


def find_calibration(encoder: TextEncoder, path: Path | None = None) -> Calibration | None:
    """Return the calibration at `path`, or without a path the calibration that ships with `mini`.

    Without a path, the result is None if `encoder` is not `mini`. Raises LexisError if the file is unusable or was fitted to
    another encoder.
    """
    if path is None:
        shipped = load_calibration(MINI_CALIBRATION) if MINI_CALIBRATION.exists() else None
        return shipped if shipped is not None and shipped.fingerprint == encoder.fingerprint else None
    given = load_calibration(path)
    if given.fingerprint != encoder.fingerprint:
        raise LexisError(
            f"{path}: fitted to weights {given.fingerprint[:8]}, and those of {encoder.name!r} are "
            f"{encoder.fingerprint[:8]}; valid: lexis-sim calibrate-queries --encoder {encoder.name}"
        )
    return given
