"""Relabelling of a map with other room names, from the stored embeddings and without encoding the images again."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lexis.config import Config
from lexis.graph.components import component_of, sessions_of
from lexis.inputs import check_room_names
from lexis.map.encoder_check import check_embedding_size, check_encoder
from lexis.perception import Encoder, check_room_embeddings
from lexis.room_labels import similarities
from lexis.semantics import Views, derive_by_component
from lexis.sight.visible_space import spaces_in_view
from lexis.types import LexisMap


def relabel(map: LexisMap, room_names: Sequence[str], encoder: Encoder, config: Config | None = None) -> LexisMap:
    """Derive labels, rooms and floors for other room names; poses, loops and candidates stay as they are.

    For a keyframe that has retired, the image of its anchor counts in place of its own.

    Args:
        map: the map to relabel; its old room names are ignored.
        room_names: the new room names.
        encoder: the encoder that made the map.
        config: settings, which should equal those that the map was made with. Only the settings of labels, segmentation and
            sight are used. None: defaults.

    Raises:
        LexisError: the room names are unusable, or the map was made with another encoder.
        EncoderError: the encoder does not give one embedding of unit norm for each room name.
    """
    check_room_names(room_names)
    check_encoder(map, encoder)
    names = tuple(room_names)
    config = config or Config()
    embeddings = np.array([keyframe.embeddings for keyframe in map.keyframes])
    spaces = [spaces_in_view(keyframe, map.camera, config.sight) for keyframe in map.keyframes if config.by_sight]
    text = encoder.encode_rooms(names)
    check_room_embeddings(text, len(names), encoder)
    check_embedding_size(map, text)
    alike = similarities(embeddings, text)
    views = Views(alike, spaces, map.T_W_B, map.camera, sessions_of(map.keyframes))
    meaning = derive_by_component(views, component_of(map), names, config)
    return replace(map, room_names=names, **vars(meaning))
