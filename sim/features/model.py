"""`FeatureModel`: all that is fitted of the feature sensor, and its file. Nothing is ever unpickled."""

import zipfile
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from jaxtyping import Float32

from lexis.files import replaced_file
from lexis.perception import Encoder
from sim.errors import SimError
from sim.features.embedding import KERNELS, EmbeddingModel
from sim.features.loops import PREDICTORS, LoopModel, Measured
from sim.features.views import SIZE

MINI_FEATURES = Path(__file__).parent / "mini.npz"
"""Fitted to the encoder that ships with the package."""
MAX_BYTES = 100_000_000
_SAME = 0.999
"""Least cosine of fingerprints of one encoder: on other machines it rounds differently."""
_PROBES = ("kitchen", "bedroom", "corridor")


@dataclass(frozen=True, eq=False)
class FeatureModel:
    """What stands for images and their encoder."""

    fingerprint: Float32[np.ndarray, "probes d"]
    """`fingerprint` of the encoder that it was fitted to."""
    embedding: EmbeddingModel
    loops: LoopModel

    def check(self, encoder: Encoder, source: str) -> None:
        """Raise `SimError` unless this model, read from `source`, was fitted to that encoder."""
        own = fingerprint(encoder)
        if own.shape != self.fingerprint.shape or (own * self.fingerprint).sum(axis=1).min() < _SAME:
            raise SimError(
                f"{source} was fitted to another encoder than {encoder.name!r}, or to other weights of it; "
                f"fit it anew: lexis-sim fit-features --encoder {encoder.name} --out FILE"
            )


def fingerprint(encoder: Encoder) -> Float32[np.ndarray, "probes d"]:
    """What an encoder makes of a few texts and of one image: tells encoders apart, however their weights are kept."""
    ramp = np.linspace(0.0, 255.0, 64)
    image = np.stack(
        [np.broadcast_to(ramp, (48, 64)), np.broadcast_to(ramp[::-1], (48, 64)), np.full((48, 64), 90.0)], axis=-1
    )
    return np.concatenate([encoder.encode_rooms(_PROBES), encoder.encode_image(image.astype(np.uint8))[None]])


def save_features(model: FeatureModel, path: Path) -> None:
    """Write a model, in single precision; the weights in half. Raises `LexisError` where that cannot be."""
    arrays = _flat(model)
    arrays["embedding.weights"] = arrays["embedding.weights"].astype(np.float16)
    with replaced_file(path) as file, file.open("wb") as stream:
        np.savez_compressed(stream, allow_pickle=False, **arrays)


def load_features(path: Path) -> FeatureModel:
    """Read a model that `save_features` has written. Raises `SimError` for anything else."""
    try:
        with zipfile.ZipFile(path) as archive:
            if sum(member.file_size for member in archive.infolist()) > MAX_BYTES:
                raise SimError(f"{path}: unpacks to more than {MAX_BYTES // 1_000_000} MB; not a feature model")
        with np.load(path, allow_pickle=False) as data:
            arrays = {name: data[name] for name in data.files}
        return _checked(_built(arrays))
    except OSError as error:
        raise SimError(
            f"{path}: no feature model there: {error.strerror}; valid: a file of 'lexis-sim fit-features'"
        ) from None
    except (ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise SimError(f"{path}: no feature model: {error}; valid: a file of 'lexis-sim fit-features'") from None


def _flat(model: FeatureModel) -> dict[str, np.ndarray]:
    arrays = {"fingerprint": model.fingerprint}
    arrays |= {f"embedding.{f.name}": getattr(model.embedding, f.name) for f in fields(EmbeddingModel)}
    arrays |= {f"loops.{name}": np.asarray(getattr(model.loops, name)) for name in ("weights", "query_share", "false_rate")}
    for name in ("true_edges", "false_edges"):
        edges = getattr(model.loops, name)
        arrays |= {f"loops.{name}.{f.name}": getattr(edges, f.name) for f in fields(Measured)}
    return {name: array.astype(np.float32) if array.dtype == float else array for name, array in arrays.items()}


def _built(arrays: dict[str, np.ndarray]) -> FeatureModel:
    edges = {
        name: Measured(
            arrays[f"loops.{name}.error"].astype(float),
            arrays[f"loops.{name}.covariance"].astype(float),
            arrays[f"loops.{name}.inliers"].astype(int),
        )
        for name in ("true_edges", "false_edges")
    }
    loops = LoopModel(
        arrays["loops.weights"].astype(float), float(arrays["loops.query_share"]), float(arrays["loops.false_rate"]), **edges
    )
    embedding = EmbeddingModel(
        arrays["embedding.weights"].astype(np.float32),
        arrays["embedding.offset"].astype(np.float32),
        arrays["embedding.errors"].astype(np.float32),
        arrays["embedding.kernels"].astype(float),
    )
    return FeatureModel(arrays["fingerprint"].astype(np.float32), embedding, loops)


def _checked(model: FeatureModel) -> FeatureModel:
    """The model, if its parts fit each other and this version. Raises ValueError."""
    wanted = (SIZE, len(model.embedding.offset)), (len(KERNELS),), (len(PREDICTORS),)
    found = model.embedding.weights.shape, model.embedding.kernels.shape, model.loops.weights.shape
    if wanted != found:
        raise ValueError(f"its arrays are {found}, those of this version {wanted}; fit it anew")
    return model
