"""Files of the Hugging Face hub: from the local cache where they are, else fetched whole or not at all."""

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from huggingface_hub import constants, get_hf_file_metadata, hf_hub_download, hf_hub_url, try_to_load_from_cache
from huggingface_hub.errors import EntryNotFoundError, HfHubHTTPError, HFValidationError, LocalEntryNotFoundError

from lexis.errors import EncoderError, one_line


def fetch(repo: str, names: Sequence[str]) -> Path:
    """The first of these files that the repository has; what is cached is taken without asking the network.

    Raises EncoderError, at once where nothing answers: the hub's own client retries for the better part of a minute.
    """
    try:
        for name in names:
            if isinstance(cached := try_to_load_from_cache(repo, name), str):
                return Path(cached)
        return _fetched(repo, names)
    except Exception as error:  # the client lets through those of its HTTP library, which has changed with its versions
        raise EncoderError(_said(repo, names, error)) from None


def _fetched(repo: str, names: Sequence[str]) -> Path:
    """Raise what the hub's client raises; EntryNotFoundError where the repository has none."""
    *others, last = names
    for name in others:
        with suppress(EntryNotFoundError):
            return _whole(repo, name)
    return _whole(repo, last)


def _whole(repo: str, name: str) -> Path:
    get_hf_file_metadata(hf_hub_url(repo, name), timeout=constants.HF_HUB_ETAG_TIMEOUT)  # asks once, and does not try again
    return Path(hf_hub_download(repo, name))


def _said(repo: str, names: Sequence[str], error: Exception) -> str:
    line, hub = one_line(error), constants.ENDPOINT
    if isinstance(error, HFValidationError):
        return f"{repo!r} is no repository: {line}; valid: OWNER/NAME"
    if isinstance(error, EntryNotFoundError) and not isinstance(error, LocalEntryNotFoundError):
        return f"{hub}/{repo} has none of {', '.join(names)}; valid: a repository of open_clip's"
    if isinstance(error, HfHubHTTPError):
        return f"{hub} refuses {repo}: {line}; valid: a public repository, or HF_TOKEN of one who may"
    return (
        f"{repo} is not in the local cache and cannot be had from {hub}: {line}; "
        "valid: mini, which needs no network; MODEL:PATH of a checkpoint; HF_ENDPOINT=URL of a mirror"
    )
