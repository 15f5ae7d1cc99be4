"""Probabilities of answers: fitted to an encoder where the truth is known, kept beside its weights.

    p = sigmoid((similarity - threshold) / temperature),  threshold = base + slope * familiarity

The familiarity of a text is its greatest cosine similarity with the names of rooms that the encoder was calibrated with:
what an encoder knows well, it resembles more where it is and where it is not.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from jaxtyping import Float, Float32
from pydantic import BaseModel, ConfigDict, Field
from scipy.special import expit

from lexis.errors import LexisError
from lexis.files.reading import FileKind, read_model
from lexis.files.replace import replaced_file
from lexis.inputs import MAX_NAME_LENGTH, MAX_ROOM_NAMES
from lexis.perception import TextEncoder

MINI_CALIBRATION = Path(__file__).parents[1] / "models" / "lexis-mini.calibration.json"
_FILE = FileKind("a file of calibrate-queries", 1_000_000)


@dataclass(frozen=True)
class Calibration:
    """Of one encoder's similarities between a text and the best views of a room."""

    fingerprint: str
    """Of the encoder's weights."""
    room_names: tuple[str, ...]
    """That familiarity is measured by."""
    base: float
    slope: float
    temperature: float

    def probabilities(
        self, similarities: Float[np.ndarray, "rooms texts"], questions: Float32[np.ndarray, "texts d"], encoder: TextEncoder
    ) -> Float[np.ndarray, "rooms texts"]:
        """Probabilities that rooms are, or show, the thing that texts ask for, if every second question has an answer.

        Args:
            similarities: of every room's best views with every text.
            questions: embeddings of the texts, unit norm.
            encoder: the one that is calibrated.
        """
        thresholds = self.base + self.slope * familiarity(questions, self.room_names, encoder)
        return np.asarray(expit((similarities - thresholds) / self.temperature))


def familiarity(
    questions: Float32[np.ndarray, "texts d"], room_names: Sequence[str], encoder: TextEncoder
) -> Float[np.ndarray, "texts"]:
    """How near every text, by its embedding, comes to the name of a room: cosine similarity with the nearest."""
    return np.asarray((questions @ encoder.encode_texts(room_names).T).max(axis=1))


class _Calibration(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, populate_by_name=True)

    schema_version: Literal[1] = Field(alias="schema")
    fingerprint: str
    room_names: tuple[Annotated[str, Field(min_length=1, max_length=MAX_NAME_LENGTH)], ...] = Field(
        min_length=1, max_length=MAX_ROOM_NAMES
    )
    base: float
    slope: float
    temperature: float = Field(gt=0)


def save_calibration(calibration: Calibration, path: Path) -> None:
    """Write a file that `load_calibration` reads. Raises LexisError where it cannot be written."""
    data = _Calibration(schema=1, **vars(calibration)).model_dump(by_alias=True)
    with replaced_file(path) as beside:
        beside.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")


def load_calibration(path: Path) -> Calibration:
    """Read what `save_calibration` wrote. Raises LexisError for anything else."""
    data = read_model(path, _FILE, _Calibration)
    return Calibration(**data.model_dump(exclude={"schema_version"}))


def calibration_of(encoder: TextEncoder, path: Path | None = None) -> Calibration | None:
    """The calibration at `path`, else the one that ships with `mini` if it is this encoder's; None where there is none.

    Raises LexisError for a file that cannot be used, or was fitted to other weights.
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
