"""Parts that the models of several JSON files share: what every model forbids, room names, and the encoder."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from lexis.inputs import MAX_NAME_LENGTH, MAX_ROOM_NAMES

STRICT = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, populate_by_name=True)
"""Configuration of models for files of LEXIS's own: unknown fields and numbers that are not finite are refused."""
RoomName = Annotated[str, Field(min_length=1, max_length=MAX_NAME_LENGTH)]
RoomNames = Annotated[tuple[RoomName, ...], Field(min_length=1, max_length=MAX_ROOM_NAMES)]
_EncoderName = Annotated[str, Field(max_length=10_000)]
"""The name of an encoder. The limit on its length is high, because the name may contain the path of a checkpoint."""


class EncoderData(BaseModel):
    """Name and fingerprint of the encoder that made the embeddings of a map."""

    model_config = STRICT

    name: _EncoderName
    fingerprint: _EncoderName
