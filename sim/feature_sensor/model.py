"""`FeatureModel`: all fitted parameters of the feature sensor, and their file format, which contains no pickled objects."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from jaxtyping import Float16, Float32, Float64

from lexis.files.arrays import Layout, read_arrays
from lexis.files.reading import FileKind
from lexis.files.replace import replaced_file
from lexis.inputs import usable_covariances
from lexis.perception import Encoder
from sim.errors import SimError
from sim.feature_sensor.covisibility_verifier import PREDICTORS, LoopModel, MeasuredEdges
from sim.feature_sensor.embedding import KERNELS, EmbeddingModel
from sim.feature_sensor.surroundings import KINDS
from sim.feature_sensor.visible_shares import SIZE
from worlds.truth import NOWHERE

MINI_FEATURES = Path(__file__).parent / "mini.npz"
"""File of the feature model for the encoder that is included in the package."""
_FILE = FileKind(
    "a file of 'lexis-sim fit-features'",
    100_000_000,
    SimError,
    missing="no feature model there",
    unusable="no feature model",
)


def _edges(name: str) -> Layout:
    return {
        f"loops.{name}.error": ("f4", (name, 6)),
        f"loops.{name}.covariance": ("f4", (name, 6, 6)),
        f"loops.{name}.inliers": ("i8", (name,)),
        f"loops.{name}.cells": ("i8", (name,)),
    }


_LAYOUT: Layout = {
    "kinds": ("u1", ("bytes",)),
    "fingerprint": ("f4", ("probes", "d")),
    "embedding.weights": ("f2", ("size", "d")),
    "embedding.offset": ("f4", ("d",)),
    "embedding.errors": ("f4", ("k", "d")),
    "embedding.kernels": ("f4", ("kernels",)),
    "loops.weights": ("f4", ("predictors",)),
    "loops.query_share": ("f4", ()),
    "loops.false_rate": ("f4", ()),
    **_edges("true_edges"),
    **_edges("false_edges"),
}
_MOST = 1e6
"""Largest valid parameter of embeddings and errors. Real models have parameters below 100."""
_SAME = 0.999
"""Two fingerprints count as those of the same encoder if the cosine of each pair of embeddings is at least this. The limit
is below 1, because rounding differs between machines."""
_PROBES = ("kitchen", "bedroom", "corridor")
"""Texts that are encoded for the fingerprint."""
_LATEST: list[tuple[Encoder, Float32[np.ndarray, "probes d"]]] = []
"""The encoder whose fingerprint was computed last in this process, and that fingerprint."""


@dataclass(frozen=True, eq=False)
class FeatureModel:
    """A fitted model of one encoder and of loop verification. With such a model, LEXIS runs without images."""

    fingerprint: Float32[np.ndarray, "probes d"]
    """Result of the function `fingerprint` for the encoder to which the model was fitted."""
    embedding: EmbeddingModel
    loops: LoopModel

    def check(self, encoder: Encoder, source: str) -> None:
        """Raise `SimError` unless this model, which was read from `source`, was fitted to `encoder`."""
        own = fingerprint(encoder)
        if own.shape != self.fingerprint.shape or (own * self.fingerprint).sum(axis=1).min() < _SAME:
            raise SimError(
                f"{source}: was fitted to another encoder than {encoder.name!r}, or to other weights of it; "
                f"valid: a model of these weights, from lexis-sim fit-features --encoder {encoder.name} --out FILE"
            )


def fingerprint(encoder: Encoder) -> Float32[np.ndarray, "probes d"]:
    """Embed a few texts and one image. The embeddings identify the encoder, however its weights are stored.

    Embedding the image takes longer than any other preparation of a run on features, so the result is stored for the next
    call with the same encoder.
    """
    if not _LATEST or _LATEST[0][0] is not encoder:
        _LATEST[:] = [(encoder, _fingerprint(encoder))]
    return _LATEST[0][1]


def _fingerprint(encoder: Encoder) -> Float32[np.ndarray, "probes d"]:
    ramp = np.linspace(0.0, 255.0, 64)
    image = np.stack(
        [np.broadcast_to(ramp, (48, 64)), np.broadcast_to(ramp[::-1], (48, 64)), np.full((48, 64), 90.0)], axis=-1
    )
    embeddings = np.concatenate([encoder.encode_rooms(_PROBES), encoder.encode_image(image.astype(np.uint8))[None]])
    embeddings.flags.writeable = False
    return embeddings


def save_features(model: FeatureModel, path: Path) -> None:
    """Write a feature model: the embedding weights in half precision, everything else in single precision.

    Raises `LexisError` if the file cannot be written.
    """
    arrays = _flat(model)
    arrays["embedding.weights"] = arrays["embedding.weights"].astype(np.float16)
    arrays["kinds"] = np.frombuffer("\n".join(KINDS).encode(), np.uint8)
    with replaced_file(path) as file, file.open("wb") as stream:
        np.savez_compressed(stream, allow_pickle=False, **arrays)


def load_features(path: Path) -> FeatureModel:
    """Read a model that `save_features` wrote. Its arrays cannot be written to.

    Things of a kind that the file does not know, because the kind is newer than the model, do not show in embeddings; they
    only hide what is behind them. Raises `SimError` if the file is missing or holds no valid model.
    """
    arrays = read_arrays(path, _FILE, _LAYOUT, packed=True)
    if not all(np.isfinite(array).all() for array in arrays.values()):
        raise _FILE.refusal(path, "it has values that are not finite")
    fitted = arrays.pop("kinds").tobytes().decode(errors="replace").split("\n")
    weights, wanted = arrays["embedding.weights"], SIZE + 2 * (len(fitted) - len(KINDS))
    if len(weights) != wanted:
        raise _FILE.refusal(path, f"it has {len(weights)} weights, those of this version are {wanted}; fit the model again")
    model = _built(arrays | {"embedding.weights": _of_present_kinds(weights, fitted)})
    if problem := _problem(model):
        raise _FILE.refusal(path, problem)
    return model


def _of_present_kinds(weights: Float16[np.ndarray, "_ d"], fitted: Sequence[str]) -> Float16[np.ndarray, "size d"]:
    """Return the weights in the order of `KINDS`, from those for the kinds to which a model was fitted; 0 for other kinds.

    A description of a view begins with two entries for each kind; see `VisibleShares.described`.
    """
    n, row_of = len(fitted), {kind: row for row, kind in enumerate(fitted)}
    rows = np.array([row_of.get(kind, NOWHERE) for kind in KINDS])
    present = [np.where(rows[:, None] == NOWHERE, np.float16(0.0), part[rows]) for part in (weights[:n], weights[n : 2 * n])]
    return np.concatenate([*present, weights[2 * n :]])


def _flat(model: FeatureModel) -> dict[str, np.ndarray]:
    arrays = {"fingerprint": model.fingerprint}
    arrays |= {f"embedding.{f.name}": getattr(model.embedding, f.name) for f in fields(EmbeddingModel)}
    arrays |= {f"loops.{name}": np.asarray(getattr(model.loops, name)) for name in ("weights", "query_share", "false_rate")}
    for name in ("true_edges", "false_edges"):
        edges = getattr(model.loops, name)
        arrays |= {f"loops.{name}.{f.name}": getattr(edges, f.name) for f in fields(MeasuredEdges)}
    return {name: array.astype(np.float32) if array.dtype == float else array for name, array in arrays.items()}


def _built(arrays: dict[str, np.ndarray]) -> FeatureModel:
    edges = {
        name: MeasuredEdges(
            _fixed(arrays[f"loops.{name}.error"], float),
            _fixed(arrays[f"loops.{name}.covariance"], float),
            _fixed(arrays[f"loops.{name}.inliers"], int),
            _fixed(arrays[f"loops.{name}.cells"], int),
        )
        for name in ("true_edges", "false_edges")
    }
    query_share, false_rate = (float(arrays[f"loops.{name}"]) for name in ("query_share", "false_rate"))
    loops = LoopModel(_fixed(arrays["loops.weights"], float), query_share, false_rate, **edges)
    embedding = EmbeddingModel(
        _fixed(arrays["embedding.weights"], np.float32),
        _fixed(arrays["embedding.offset"], np.float32),
        _fixed(arrays["embedding.errors"], np.float32),
        _fixed(arrays["embedding.kernels"], float),
    )
    return FeatureModel(_fixed(arrays["fingerprint"], np.float32), embedding, loops)


def _fixed(array: np.ndarray, dtype: type) -> np.ndarray:
    """Return a copy that cannot be written to, because runs may share a model."""
    values: np.ndarray = array.astype(dtype)
    values.flags.writeable = False
    return values


def _problem(model: FeatureModel) -> str | None:
    """Return why a model is inconsistent or does not fit this version; None if it is valid."""
    wanted = (SIZE, len(model.embedding.offset)), (len(KERNELS),), (len(PREDICTORS),)
    found = model.embedding.weights.shape, model.embedding.kernels.shape, model.loops.weights.shape
    if wanted != found:
        return f"its arrays are {found}, those of this version {wanted}; fit the model again"
    loops = model.loops
    if not (0.0 <= loops.query_share < 1.0 and 0.0 <= loops.false_rate <= 1.0 and (model.embedding.kernels >= 0.0).all()):
        return "its shares and rates are not all between 0 and 1"
    if not len(loops.true_edges.inliers) or (loops.false_rate > 0.0 and not len(loops.false_edges.inliers)):
        return "it has no edges to draw from"
    edges = np.concatenate([loops.true_edges.covariance, loops.false_edges.covariance])
    if not (usable_covariances(edges).all() and np.abs(_drawn_from(model)).max() <= _MOST):
        return "its edges have no covariances, or its values are too large"
    return None


def _drawn_from(model: FeatureModel) -> Float64[np.ndarray, "n"]:
    """Return the parameters of the embeddings and of the loop edges' errors as one vector."""
    embedding, loops = model.embedding, model.loops
    parts = (
        embedding.weights,
        embedding.offset,
        embedding.errors,
        loops.weights,
        loops.true_edges.error,
        loops.false_edges.error,
    )
    return np.concatenate([np.ravel(part).astype(float) for part in parts])
