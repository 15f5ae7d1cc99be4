"""Downloads from a model hub, played by a local server: complete files or none, and fast failure when it does not answer."""

import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest
from huggingface_hub import constants

from lexis.encoder.hub import fetch
from lexis.encoder.open_clip_encoder import load_encoder
from lexis.errors import EncoderError

CONTENT = b"weights" * 1000
NAMES = ("model.safetensors", "model.bin")


class Hub(BaseHTTPRequestHandler):
    """A hub with a complete model.bin of a/whole; it breaks off half-way through that of a/broken and has no other files."""

    asked: list[str]

    def do_HEAD(self):
        self.asked.append(self.path)
        found = self.path.endswith("model.bin") and self.path.startswith(("/a/whole/", "/a/broken/"))
        self.send_response(200 if found else 404)
        self.send_header("X-Repo-Commit", "0" * 40)
        self.send_header("ETag", '"1234"')
        self.send_header("Content-Length", str(len(CONTENT)))
        if not found:
            self.send_header("X-Error-Code", "EntryNotFound" if self.path.startswith("/a/") else "RepoNotFound")
        self.end_headers()

    def do_GET(self):
        self.do_HEAD()
        self.wfile.write(CONTENT if "whole" in self.path else CONTENT[: len(CONTENT) // 2])

    def log_message(self, *_):
        """Log nothing."""


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path))
    return tmp_path


@pytest.fixture
def asked(cache, monkeypatch):
    """The requests that the hub has received."""
    monkeypatch.setattr(Hub, "asked", [], raising=False)
    with ThreadingHTTPServer(("127.0.0.1", 0), Hub) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        yield at(f"http://127.0.0.1:{server.server_port}", monkeypatch) or Hub.asked
        server.shutdown()
        thread.join()


def at(endpoint, monkeypatch):
    monkeypatch.setattr(constants, "ENDPOINT", endpoint)
    monkeypatch.setattr(constants, "HUGGINGFACE_CO_URL_TEMPLATE", endpoint + "/{repo_id}/resolve/{revision}/{filename}")


def test_a_file_is_fetched_once_and_then_needs_no_network(asked):
    path = fetch("a/whole", NAMES)
    assert path.read_bytes() == CONTENT and path.name == "model.bin"
    asked.clear()
    assert fetch("a/whole", NAMES) == path and not asked


def test_a_broken_download_leaves_nothing(asked, cache, monkeypatch):
    monkeypatch.setattr("huggingface_hub.file_download.time.sleep", lambda seconds: None)
    with pytest.raises(EncoderError, match="cannot be downloaded"):
        fetch("a/broken", NAMES)
    assert not [path for path in cache.rglob("*") if path.is_file() and CONTENT[:7] in path.read_bytes()]


@pytest.mark.parametrize(("repo", "says"), [("a/other", "has none of model"), ("b/c", "refuses"), ("a/b/c", "OWNER")])
def test_what_the_hub_does_not_have_is_said_in_one_line(asked, repo, says):
    with pytest.raises(EncoderError, match=says) as error:
        fetch(repo, NAMES)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("model", ["ViT-B-32", "ViT-L-14:laion2b_s32b_b82k", "hf-hub:laion/CLIP-ViT-B-32"])
def test_a_hub_that_cannot_be_reached_fails_at_once_and_says_what_to_do(cache, monkeypatch, model):
    at("http://127.0.0.1:9", monkeypatch)
    monkeypatch.setattr("huggingface_hub.utils._http.time.sleep", lambda seconds: pytest.fail("waits to try again"))
    with pytest.raises(EncoderError, match=r"not in the local cache.*valid: mini") as error:
        load_encoder(model)
    assert "\n" not in str(error.value) and len(str(error.value)) < 400
