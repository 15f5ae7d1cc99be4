"""Encoder options change the cost of embeddings but not their values; texts and images are encoded only once."""

import json

import numpy as np
import open_clip
import pytest
import torch
from helpers.unchecked import unchecked

from lexis.encoder.open_clip_encoder import OpenClipEncoder, load_encoder
from lexis.encoder.options import EncoderOptions
from lexis.encoder.preprocessing import squashing
from lexis.encoder.prompts import with_article
from lexis.errors import EncoderError

SIZE = (32, 48)
ARCHITECTURE = {
    "embed_dim": 16,
    "vision_cfg": {"image_size": SIZE, "layers": 2, "width": 64, "head_width": 32, "patch_size": 8},
    "text_cfg": {"context_length": 16, "vocab_size": 49408, "width": 16, "heads": 2, "layers": 1},
}


class Counting(open_clip.CLIP):
    """A network that counts the images and texts that it encodes, and notes how many images come at a time."""

    images = texts = 0
    batches: tuple[int, ...] = ()

    def encode_image(self, image, normalize=False):
        self.images += len(image)
        self.batches += (len(image),)
        return super().encode_image(image, normalize)

    def encode_text(self, text, normalize=False):
        self.texts += len(text)
        return super().encode_text(text, normalize)


@pytest.fixture(scope="module")
def weights():
    torch.manual_seed(0)
    return open_clip.CLIP(**ARCHITECTURE).state_dict()


@pytest.fixture
def images(rng):
    return rng.integers(0, 256, (7, 45, 60, 3), dtype=np.uint8)


@pytest.fixture
def networks():
    """The networks of the encoders that `make` has made, in that order."""
    return []


@pytest.fixture
def make(weights, networks):
    """A function that makes an encoder of equal weights with the given options."""

    def made(network=Counting, **options):
        model = network(**json.loads(json.dumps(ARCHITECTURE)))
        model.load_state_dict(weights)
        networks.append(model)
        tokenizer = open_clip.tokenizer.SimpleTokenizer(context_length=16)
        return OpenClipEncoder("tiny", model, tokenizer, squashing(*SIZE), EncoderOptions(**options))

    return made


@pytest.mark.parametrize("batch", [1, 3, 7, 32])
def test_a_batch_is_its_images_one_by_one(make, networks, images, batch):
    encoder = make(batch=batch)
    together = encoder.encode_images(images)
    assert max(networks[-1].batches) <= batch and len(networks[-1].batches) == -(-len(images) // batch)
    np.testing.assert_allclose(together, [encoder.encode_image(image) for image in images], atol=1e-5)
    mixed = encoder.encode_images([images[0], images[1][:30]])
    np.testing.assert_allclose(mixed[0], together[0], atol=1e-5)


def test_a_list_of_texts_is_encoded_once_and_the_result_is_a_copy(make, networks):
    encoder = make()
    (network,) = networks
    first = encoder.encode_texts(["a bathtub", "a sofa"])
    encoder.encode_rooms(["kitchen", "office"])
    before, expected = network.texts, first.copy()
    first[:] = 0
    np.testing.assert_array_equal(encoder.encode_texts(("a bathtub", "a sofa")), expected)
    encoder.encode_rooms(["office", "kitchen"])
    assert network.texts == before == 2 + 2 * 5
    encoder.encode_rooms(["office", "lobby"])
    assert network.texts == before + 5


def test_rooms_are_means_over_the_templates_that_were_asked_for(make):
    templates = ("{}", "the door to {}", "{}, seen from above")
    encoder = make(templates=templates)
    rows = encoder.encode_texts([template.replace("{}", with_article("office")) for template in templates])
    mean = rows.mean(axis=0)
    np.testing.assert_allclose(encoder.encode_rooms(["office"])[0], mean / np.linalg.norm(mean), atol=1e-6)


def test_with_a_cache_images_are_encoded_once_for_all_runs(make, networks, images, tmp_path):
    plain = make().encode_images(images)
    first = make(cache=tmp_path)
    found = first.encode_images(images[[0, 1, 0, 2]])
    np.testing.assert_allclose(found, plain[[0, 1, 0, 2]], atol=1e-5)
    assert networks[-1].images == 3
    again = make(cache=tmp_path)
    np.testing.assert_array_equal(again.encode_image(images[1]), found[1])
    np.testing.assert_allclose(again.encode_images(images), plain, atol=1e-5)
    assert networks[-1].images == len(images) - 3


def test_the_cache_is_that_of_weights_preprocessing_activation_and_precision(make, networks, images, tmp_path):
    plain, low = make(cache=tmp_path), make(cache=tmp_path, precision="bf16")
    other = make(lambda **config: Counting(**config, quick_gelu=True), cache=tmp_path)
    plain_network, low_network, other_network = networks
    small = OpenClipEncoder("tiny", plain_network, None, squashing(32, 40), EncoderOptions(cache=tmp_path))
    assert plain.fingerprint == low.fingerprint == make().fingerprint
    assert len({plain.fingerprint, other.fingerprint, small.fingerprint}) == 3
    plain.encode_image(images[0])
    low.encode_image(images[0])
    other.encode_image(images[0])
    assert low_network.images == other_network.images == 1
    assert len(list(tmp_path.glob("*.sqlite"))) == 4


def test_lower_precision_is_near_but_not_equal(make, images):
    full, low = make(), make(precision="bf16")
    np.testing.assert_allclose(low.encode_images(images), full.encode_images(images), atol=0.03)
    np.testing.assert_allclose(low.encode_rooms(["kitchen"]), full.encode_rooms(["kitchen"]), atol=0.03)
    assert not np.array_equal(low.encode_images(images), full.encode_images(images))
    assert low.encode_images(images).dtype == np.float32


@pytest.mark.skipif(not torch.cuda.is_available(), reason="needs a GPU")
@pytest.mark.parametrize(("precision", "compiled"), [("fp32", False), ("fp16", False), ("bf16", False), ("fp16", True)])
def test_a_gpu_finds_the_same(make, images, precision, compiled):
    there, here = make(open_clip.CLIP, device="cuda", precision=precision, compiled=compiled), make()
    np.testing.assert_allclose(there.encode_images(images), here.encode_images(images), atol=0.03)
    np.testing.assert_allclose(there.encode_texts(["a sofa"]), here.encode_texts(["a sofa"]), atol=0.03)
    assert there.fingerprint == here.fingerprint


@pytest.mark.slow
def test_a_compiled_network_finds_the_same(make, images):
    compiled, plain = make(open_clip.CLIP, compiled=True), make()
    for size in (1, 7, 3):
        np.testing.assert_allclose(compiled.encode_images(images[:size]), plain.encode_images(images[:size]), atol=1e-4)
    np.testing.assert_allclose(compiled.encode_texts(["a sofa"]), plain.encode_texts(["a sofa"]), atol=1e-4)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"device": "tpu"}, "cpu, cuda"),
        ({"precision": "fp8"}, "fp32, bf16, fp16"),
        ({"precision": "fp16"}, "bf16 on cpu; fp16 with device cuda"),
        ({"threads": 0}, "threads is 0"),
        ({"batch": 0}, "batch is 0"),
        ({"templates": ()}, "at least one"),
        ({"templates": ("a photo of {}", "a photo")}, "one {}"),
        ({"templates": ("{} and {}",)}, "one {}"),
        ({"templates": ("{name}",)}, "one {}"),
    ],
)
def test_options_out_of_range_are_refused(options, says):
    with pytest.raises(EncoderError, match=says):
        unchecked(EncoderOptions, **options)


def test_an_absent_gpu_is_refused_before_anything_is_loaded():
    with pytest.raises(EncoderError, match=r"cuda:63 is absent.*valid: cpu"):
        load_encoder("mini", EncoderOptions(device="cuda:63"))


def test_weights_that_give_no_numbers_are_refused(make, networks, images):
    encoder = make()
    networks[-1].visual.proj.data.fill_(np.nan)
    with pytest.raises(EncoderError, match="not finite"):
        encoder.encode_images(images)


def test_nothing_to_encode_is_refused(make):
    for encode in (make().encode_images, make().encode_texts):
        with pytest.raises(EncoderError, match="nothing to encode"):
            encode([])
