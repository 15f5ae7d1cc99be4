"""Files of the Hugging Face hub: they are taken from the local cache if they are there, and downloaded otherwise."""

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from huggingface_hub import constants, get_hf_file_metadata, hf_hub_download, hf_hub_url, try_to_load_from_cache
from huggingface_hub.errors import EntryNotFoundError, HfHubHTTPError, HFValidationError, LocalEntryNotFoundError

from lexis.errors import EncoderError, one_line


def fetch(repo: str, names: Sequence[str]) -> Path:
    """Return the local path of one file of a repository: the first of `names` that is cached, else the first that exists.

    A cached file needs no network access; any other file is downloaded. Raises EncoderError if that fails. If the hub does
    not answer, the error comes at once, whereas the hub's own client would retry for most of a minute.
    """
    try:
        for name in names:
            if isinstance(cached := try_to_load_from_cache(repo, name), str):
                return Path(cached)
        return _download_first(repo, names)
    except Exception as error:  # the client passes on errors of its HTTP library, which differs between its versions
        raise EncoderError(_error_text(repo, names, error)) from None


def _download_first(repo: str, names: Sequence[str]) -> Path:
    """Download the first of `names` that exists. Raises the hub client's errors: EntryNotFoundError if none exists."""
    *others, last = names
    for name in others:
        with suppress(EntryNotFoundError):
            return _download(repo, name)
    return _download(repo, last)


def _download(repo: str, name: str) -> Path:
    get_hf_file_metadata(hf_hub_url(repo, name), timeout=constants.HF_HUB_ETAG_TIMEOUT)  # asks once, without retries
    return Path(hf_hub_download(repo, name))


def _error_text(repo: str, names: Sequence[str], error: Exception) -> str:
    line, hub = one_line(error), constants.ENDPOINT
    if isinstance(error, HFValidationError):
        return f"{repo!r} is not a repository name: {line}; valid: OWNER/NAME"
    if isinstance(error, EntryNotFoundError) and not isinstance(error, LocalEntryNotFoundError):
        return f"{hub}/{repo} has none of {', '.join(names)}; valid: a repository of an open_clip model"
    if isinstance(error, HfHubHTTPError):
        return f"{hub} refuses {repo}: {line}; valid: a public repository, or an HF_TOKEN with access to it"
    return (
        f"{repo} is not in the local cache and cannot be downloaded from {hub}: {line}; "
        "valid: mini, which needs no network; MODEL:PATH of a checkpoint; HF_ENDPOINT=URL of a mirror"
    )
