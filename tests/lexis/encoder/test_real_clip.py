"""Real architectures of open_clip with random weights on disk: both towers give the same embeddings as open_clip itself.

Given the path of a checkpoint, open_clip uses its default preprocessing instead of that of the training; LEXIS must not.
"""

import json
import shutil

import numpy as np
import open_clip
import pytest
import torch
from huggingface_hub import constants
from open_clip.factory import load_state_dict
from PIL import Image as PILImage
from safetensors.torch import save_file

from lexis.encoder.model_source import parse_model
from lexis.encoder.open_clip_encoder import load_encoder
from lexis.errors import EncoderError

SMALLEST, WELL_KNOWN = "ViT-S-32-alt", ("ViT-B-32", "RN50-quickgelu")
STATED = {"mean": [0.2, 0.3, 0.4], "std": [0.3, 0.2, 0.4], "resize_mode": "squash", "interpolation": "bilinear"}
TEXTS = ["a photo of a kitchen", "somewhere to wash my hands"]


def write(architecture, path):
    """Write the weights and the configuration that states their preprocessing."""
    torch.manual_seed(0)
    save_file(open_clip.create_model(architecture).state_dict(), path / "open_clip_model.safetensors")
    config = {"model_cfg": open_clip.get_model_config(architecture), "preprocess_cfg": STATED}
    (path / "open_clip_config.json").write_text(json.dumps(config))
    return path


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    return write(SMALLEST, tmp_path_factory.mktemp(SMALLEST))


@pytest.fixture(scope="module", params=[SMALLEST, *(pytest.param(name, marks=pytest.mark.slow) for name in WELL_KNOWN)])
def folder(request, tmp_path_factory, small):
    return request.param, small if request.param == SMALLEST else write(request.param, tmp_path_factory.mktemp("well-known"))


@pytest.fixture(scope="module")
def image():
    """An image with slowly varying colours and unequal sides, for which cropping, squashing and interpolation differ."""
    rng = np.random.default_rng(0)
    return np.asarray(PILImage.fromarray(rng.integers(0, 256, (9, 16, 3), dtype=np.uint8)).resize((320, 180)))


@pytest.fixture(scope="module")
def encoder(folder):
    architecture, path = folder
    return load_encoder(f"{architecture}:{path / 'open_clip_model.safetensors'}")


def test_both_towers_are_those_of_open_clip(folder, encoder, image):
    model, preprocess = open_clip.create_model_from_pretrained(f"local-dir:{folder[1]}")
    with torch.inference_mode():
        seen = model.eval().encode_image(preprocess(PILImage.fromarray(image))[None], normalize=True)
        said = model.encode_text(open_clip.get_tokenizer(folder[0])(TEXTS), normalize=True)
    np.testing.assert_allclose(encoder.encode_image(image), seen.numpy()[0], atol=1e-5)
    np.testing.assert_allclose(encoder.encode_texts(TEXTS), said.numpy(), atol=1e-5)
    assert encoder.temperature == pytest.approx(0.07, rel=1e-3)


def test_open_clip_by_itself_would_take_the_wrong_preprocessing(folder, encoder, image):
    weights = str(folder[1] / "open_clip_model.safetensors")
    model, preprocess = open_clip.create_model_from_pretrained(folder[0], weights)
    pixels = preprocess(PILImage.fromarray(image))[None]
    with torch.inference_mode():
        wrong = model.eval().encode_image(pixels, normalize=True).numpy()[0]
    assert np.abs(wrong - encoder.encode_image(image)).max() > 1e-3


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"size": 256}, "states images of 256"),
        ({"mean": None}, "unusable preprocess_cfg"),
        ({"std": [0.2, 0.0, 0.2]}, "std positive"),
        ({"mean": [0.2, float("nan"), 0.2]}, "three numbers"),
        ({"mean": [0.2, 0.2], "std": [0.2, 0.2, 0.2, 0.2]}, "three numbers"),
        ({"resize_mode": "stretch"}, "resize_mode is 'stretch'"),
        ({"interpolation": "lanczos"}, "interpolation is 'lanczos'"),
    ],
)
def test_a_statement_that_contradicts_the_model_or_itself_is_refused(small, tmp_path, change, says):
    (tmp_path / "weights.safetensors").symlink_to(small / "open_clip_model.safetensors")
    (tmp_path / "open_clip_config.json").write_text(json.dumps({"preprocess_cfg": STATED | change}))
    with pytest.raises(EncoderError, match=says) as error:
        load_encoder(f"{SMALLEST}:{tmp_path / 'weights.safetensors'}")
    assert "\n" not in str(error.value)


def test_what_the_weights_were_trained_with_is_never_guessed(tmp_path):
    weights = tmp_path / "weights.safetensors"
    weights.touch()
    with pytest.raises(EncoderError, match="mean and deviation"):  # differs from the published weights
        parse_model(f"ViT-L-14:{weights}")
    with pytest.raises(EncoderError, match=r"two activations.*ViT-B-32-quickgelu"):
        parse_model(f"ViT-B-32:{weights}")
    with pytest.raises(EncoderError, match="cannot be read"):
        parse_model(f"local-dir:{tmp_path}")
    assert parse_model(f"RN50:{weights}").quick_gelu  # as for all published tags
    (tmp_path / "open_clip_config.json").write_text(json.dumps({"model_cfg": {}, "preprocess_cfg": STATED}))
    assert not parse_model(f"RN50:{weights}").quick_gelu
    assert parse_model(f"RN50:{weights}").preprocess == STATED


@pytest.mark.parametrize("suffix", [".safetensors", ".pth"])
@pytest.mark.parametrize("model", [f"{SMALLEST}:{{weights}}", "local-dir:{weights.parent}"])
def test_positions_of_another_image_size_are_not_silently_stretched(small, tmp_path, model, suffix):
    weights = load_state_dict(str(small / "open_clip_model.safetensors"))
    positions = weights["visual.positional_embedding"]
    larger = weights | {"visual.positional_embedding": positions[:1].repeat(65, 1)}
    (save_file if suffix == ".safetensors" else torch.save)(larger, tmp_path / f"weights{suffix}")
    (tmp_path / "open_clip_config.json").write_bytes((small / "open_clip_config.json").read_bytes())
    with pytest.raises(EncoderError, match=r"of another architecture: its visual.positional_embedding is \(65"):
        load_encoder(model.format(weights=tmp_path / f"weights{suffix}"))


def test_positions_on_the_hub_are_not_silently_stretched_either(small, tmp_path, monkeypatch):
    snapshot = tmp_path / "models--a--b" / "snapshots" / "1"
    (snapshot.parents[1] / "refs").mkdir(parents=True)
    (snapshot.parents[1] / "refs" / "main").write_text("1")
    shutil.copytree(small, snapshot)
    monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path))
    monkeypatch.setattr(constants, "HF_HUB_OFFLINE", True)
    load_encoder("hf-hub:a/b")
    weights = load_state_dict(str(small / "open_clip_model.safetensors"))
    longer = weights | {"positional_embedding": weights["positional_embedding"][:1].repeat(90, 1)}
    save_file(longer, snapshot / "open_clip_model.safetensors")
    with pytest.raises(EncoderError, match=r"of another architecture: its positional_embedding is \(90"):
        load_encoder("hf-hub:a/b")


def test_every_published_tag_says_what_its_images_look_like():
    for architecture, tag in open_clip.list_pretrained():
        source = parse_model(f"{architecture}:{tag}")
        assert len(source.preprocess["mean"]) == len(source.preprocess["std"]) == 3
        assert source.hub and source.hub[0].count("/") == 1 and len(source.hub[1]) == 2
