"""Files of the Hugging Face hub: from the local cache where they are, else fetched whole or not at all."""

from collections.abc import Sequence
from pathlib import Path

from huggingface_hub import constants, get_hf_file_metadata, hf_hub_download, hf_hub_url, try_to_load_from_cache
from huggingface_hub.errors import EntryNotFoundError, HfHubHTTPError

from lexis.errors import EncoderError


def fetch(repo: str, names: Sequence[str]) -> Path:
    """The first of these files that the repository has; what is cached is taken without asking the network.

    Raises EncoderError, at once where nothing answers: the hub's own client retries for the better part of a minute.
    """
    for name in names:
        if isinstance(cached := try_to_load_from_cache(repo, name), str):
            return Path(cached)
    for name in names:
        try:
            get_hf_file_metadata(hf_hub_url(repo, name), timeout=constants.HF_HUB_ETAG_TIMEOUT)
            return Path(hf_hub_download(repo, name))
        except EntryNotFoundError:
            continue
        except HfHubHTTPError as error:
            raise EncoderError(f"{constants.ENDPOINT} refuses {repo}/{name}: {first_line(error)}") from None
        except Exception as error:  # of the client's HTTP library, which has changed with its versions
            raise EncoderError(
                f"{repo}/{name} is not in the local cache and {constants.ENDPOINT} gives none of it: {first_line(error)}; "
                "valid: mini, which needs no network; MODEL:PATH with a checkpoint; HF_ENDPOINT=URL of a mirror"
            ) from None
    raise EncoderError(f"{constants.ENDPOINT}/{repo} has none of {', '.join(names)}; valid: a repository of open_clip")


def first_line(error: Exception) -> str:
    """What an error says, on one line, shortened."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return " ".join(lines[:2])[:300] if lines else type(error).__name__
