"""The encoder: unit vectors, explicit preprocessing, and a one-line error for every model that is not available."""

import json
import pickle

import cv2
import numpy as np
import open_clip
import pytest
import torch
from safetensors.torch import save_file

from lexis.encoder.model_source import MINI_CONFIG
from lexis.encoder.open_clip_encoder import load_encoder
from lexis.encoder.options import EncoderOptions
from lexis.encoder.preprocessing import MINI_MEAN, MINI_STD, squash
from lexis.errors import EncoderError, LexisError

TINY = {
    "embed_dim": 16,
    "vision_cfg": {"timm_model_name": "regnetx_002", "timm_model_pretrained": False, "timm_pool": "", "timm_proj": "linear"},
    "text_cfg": {"context_length": 16, "vocab_size": 49408, "width": 16, "heads": 2, "layers": 1},
}
TINY["vision_cfg"]["image_size"] = [32, 48]
PREPROCESS = {"mean": [0.1, 0.2, 0.3], "std": [0.5, 0.6, 0.7], "resize_mode": "squash", "interpolation": "bilinear"}


@pytest.fixture(scope="module")
def tiny(tmp_path_factory):
    """A folder with the architecture and weights of a random model."""
    folder = tmp_path_factory.mktemp("tiny")
    (folder / "tiny-test.json").write_text(json.dumps(TINY))
    open_clip.add_model_config(folder / "tiny-test.json")
    torch.manual_seed(0)
    model = open_clip.create_model("tiny-test")
    save_file({k: v.half().contiguous() for k, v in model.state_dict().items()}, folder / "weights.safetensors")
    (folder / "open_clip_config.json").write_text(json.dumps({"model_cfg": TINY, "preprocess_cfg": PREPROCESS}))
    return folder


@pytest.fixture(scope="module")
def encoder(tiny):
    return load_encoder(f"tiny-test:{tiny / 'weights.safetensors'}")


@pytest.fixture
def image(rng):
    return rng.integers(0, 256, (90, 120, 3), dtype=np.uint8)


def test_images_and_rooms_are_unit_vectors_of_one_space(encoder, image):
    image_vector, text = encoder.encode_image(image), encoder.encode_rooms(["kitchen", "office", "stairs"])
    assert image_vector.shape == (16,) and text.shape == (3, 16)
    assert np.linalg.norm(image_vector) == pytest.approx(1.0, abs=1e-5)
    assert np.linalg.norm(text, axis=1) == pytest.approx(1.0, abs=1e-5)
    assert abs(text[0] @ text[1]) < 0.999


def test_what_was_encoded_before_changes_nothing(encoder, image):
    first = encoder.encode_image(image)
    encoder.encode_image(255 - image)
    np.testing.assert_array_equal(encoder.encode_image(image), first)
    np.testing.assert_array_equal(encoder.encode_rooms(["office", "lobby"])[1], encoder.encode_rooms(["lobby"])[0])


def test_the_encoder_has_its_own_number_of_threads_and_the_process_keeps_its_own(tiny, image, monkeypatch):
    before, within = torch.get_num_threads(), []
    encoder, encode = load_encoder(f"local-dir:{tiny}", EncoderOptions(threads=2)), open_clip.CLIP.encode_image

    def noted(*arguments, **options):
        within.append(torch.get_num_threads())
        return encode(*arguments, **options)

    monkeypatch.setattr(open_clip.CLIP, "encode_image", noted)
    encoder.encode_image(image)
    assert within == [2] and torch.get_num_threads() == before


def test_a_folder_with_its_config_is_the_same_model(tiny, encoder, image):
    (tiny / "open_clip_model.safetensors").write_bytes((tiny / "weights.safetensors").read_bytes())
    np.testing.assert_allclose(load_encoder(f"local-dir:{tiny}").encode_image(image), encoder.encode_image(image), atol=1e-6)


def test_the_image_is_normalised_as_the_checkpoint_says(tiny, encoder, rng):
    """An image of the network's own size is not resized, so this checks the normalisation alone."""
    network = open_clip.create_model("tiny-test").eval()
    network.load_state_dict(_weights(tiny))
    image = rng.integers(0, 256, (32, 48, 3), dtype=np.uint8)
    pixels = (image / 255.0 - PREPROCESS["mean"]) / PREPROCESS["std"]
    with torch.inference_mode():
        expected = network.encode_image(torch.from_numpy(pixels.transpose(2, 0, 1)[None]).float(), normalize=True)
    np.testing.assert_allclose(encoder.encode_image(image), expected.numpy()[0], atol=1e-5)


def test_the_fingerprint_is_that_of_the_weights_not_of_the_file(tiny, encoder, tmp_path):
    weights = _weights(tiny)
    (tmp_path / "open_clip_config.json").write_bytes((tiny / "open_clip_config.json").read_bytes())
    for name, changed in (("same", 0.0), ("other", 0.5)):
        torch.save(weights | {"logit_scale": weights["logit_scale"] + changed}, tmp_path / f"{name}.pt")
    same, other = (load_encoder(f"tiny-test:{tmp_path / name}.pt").fingerprint for name in ("same", "other"))
    assert same == encoder.fingerprint != other
    assert len(same) == 64


def test_squash_averages_pixels_without_keeping_the_aspect():
    image = np.arange(4 * 8 * 3, dtype=np.uint8).reshape(4, 8, 3)
    means = image.reshape(2, 2, 2, 4, 3).mean(axis=(1, 3))
    expected = (means / 255.0 - MINI_MEAN) / MINI_STD
    rounding = 0.5 / 255.0 / MINI_STD[0] + 1e-5
    np.testing.assert_allclose(squash(image, 2, 2).numpy(), expected.transpose(2, 0, 1), atol=rounding)


def test_a_mini_is_of_the_architecture_written_beside_its_weights(tmp_path, image):
    for name, size in (("wide", [32, 64]), ("high", [64, 32])):
        config = TINY | {"vision_cfg": TINY["vision_cfg"] | {"image_size": size}}
        (tmp_path / f"{name}.json").write_text(json.dumps(config))
        save_file(open_clip.CLIP(**config).state_dict(), tmp_path / f"{name}.safetensors")
    wide, high, mini = (
        load_encoder(model)
        for model in (f"lexis-mini:{tmp_path}/wide.safetensors", f"lexis-mini:{tmp_path}/high.safetensors", "mini")
    )
    seen = []
    for encoder, shape in ((wide, (32, 64)), (high, (64, 32))):
        squashed = cv2.resize(image, shape[::-1], interpolation=cv2.INTER_AREA)
        seen.append(encoder.encode_image(image))
        np.testing.assert_allclose(encoder.encode_image(squashed), seen[-1], atol=1e-5)
        assert np.abs(encoder.encode_image(cv2.resize(image, shape)) - seen[-1]).max() > 1e-4
    assert mini.encode_image(image).shape != seen[0].shape == (16,)


def test_another_checkpoint_of_the_mini_needs_no_config(tmp_path, image):
    with pytest.raises(EncoderError, match="no checkpoint"):
        load_encoder(f"{MINI_CONFIG.stem}:{tmp_path / 'absent.safetensors'}")
    model = open_clip.create_model(MINI_CONFIG.stem)
    save_file(model.state_dict(), tmp_path / "fresh.safetensors")
    encoder = load_encoder(f"{MINI_CONFIG.stem}:{tmp_path / 'fresh.safetensors'}")
    expected = model.eval().encode_image(squash(image, *model.visual.image_size)[None], normalize=True).detach().numpy()[0]
    np.testing.assert_allclose(encoder.encode_image(image), expected, atol=1e-6)


@pytest.mark.parametrize(
    ("model", "says"),
    [
        ("ViT-B-33", "ViT-B-32"),
        ("RN50x16:laion9b", "openai"),
        ("ViT-L-14:/nowhere/model.safetensors", "no checkpoint at /nowhere"),
        ("tiny-test", "no weights 'openai'"),
        ("local-dir:/nowhere", "open_clip_config.json: cannot be read"),
    ],
)
def test_what_cannot_be_had_is_refused_in_one_line_that_says_what_is_valid(tiny, model, says):
    with pytest.raises(LexisError, match=says) as error:
        load_encoder(model)
    assert "\n" not in str(error.value)


class Evil:
    """Runs code when it is unpickled."""

    def __reduce__(self):
        return (pytest.fail, ("a pickle was executed",))


@pytest.mark.parametrize("damage", ["truncated", "pickle", "other shape", "other architecture"])
def test_a_damaged_or_foreign_checkpoint_is_never_loaded(tiny, tmp_path, damage):
    (tmp_path / "open_clip_config.json").write_bytes((tiny / "open_clip_config.json").read_bytes())
    path = tmp_path / ("weights.pt" if damage == "pickle" else "weights.safetensors")
    whole = (tiny / "weights.safetensors").read_bytes()
    if damage == "truncated":
        path.write_bytes(whole[: len(whole) // 2])
    elif damage == "pickle":
        path.write_bytes(pickle.dumps({"state_dict": Evil()}))
    elif damage == "other shape":
        save_file({k: v.repeat(2, *[1] * (v.ndim - 1)) for k, v in _weights(tiny).items() if v.ndim}, path)
    else:
        save_file({"nothing": torch.zeros(1)}, path)
    with pytest.raises(EncoderError, match="cannot be loaded") as error:
        load_encoder(f"tiny-test:{path}")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("prefix", ["", "text."])
def test_positions_of_longer_texts_are_refused_where_the_text_tower_is_a_module_of_its_own(tiny, tmp_path, prefix):
    config = {"model_cfg": TINY | {"custom_text": True}, "preprocess_cfg": PREPROCESS}
    (tmp_path / "open_clip_config.json").write_text(json.dumps(config))
    own = ("positional_embedding", "token_embedding", "transformer", "ln_final", "text_projection")
    named = {prefix * name.startswith(own) + name: values for name, values in _weights(tiny).items()}
    save_file(named, tmp_path / "weights.safetensors")
    load_encoder(f"local-dir:{tmp_path}")
    save_file(named | {f"{prefix}positional_embedding": torch.zeros(20, 16)}, tmp_path / "weights.safetensors")
    with pytest.raises(EncoderError, match=r"positional_embedding is \(20, 16\), the model's is \(16, 16\)"):
        load_encoder(f"local-dir:{tmp_path}")


def _weights(folder):
    from safetensors.torch import load_file

    return load_file(folder / "weights.safetensors")


def test_preprocessing_is_never_guessed(tiny, tmp_path):
    (tmp_path / "weights.safetensors").write_bytes((tiny / "weights.safetensors").read_bytes())
    with pytest.raises(EncoderError, match="mean and deviation"):
        load_encoder(f"tiny-test:{tmp_path / 'weights.safetensors'}")
    (tmp_path / "open_clip_config.json").write_text('{"preprocess_cfg": {"mean": [0, 0, 0], "std": [0, 1, 1]}}')
    with pytest.raises(EncoderError, match="std"):
        load_encoder(f"tiny-test:{tmp_path / 'weights.safetensors'}")


@pytest.mark.parametrize("names", [[], ["kitchen", " "]])
def test_blank_room_names_are_refused(encoder, names):
    with pytest.raises(EncoderError, match="room names"):
        encoder.encode_rooms(names)
