"""How an encoder computes; which model it is, `load_encoder` is told beside them. Imports no torch."""

import re
from dataclasses import dataclass
from pathlib import Path

from lexis.encoder.prompts import TEMPLATES, check_template
from lexis.errors import EncoderError

PRECISIONS = ("fp32", "bf16", "fp16")
_DEVICES = re.compile(r"cpu|cuda(:\d+)?")


@dataclass(frozen=True)
class EncoderOptions:
    """The same options, images and texts give the same embeddings, up to rounding by the size of batches."""

    device: str = "cpu"
    """cpu, cuda or cuda:N."""
    precision: str = "fp32"
    """Of the arithmetic, one of `PRECISIONS`; weights stay as they are. fp16 needs a GPU."""
    compiled: bool = False
    """Whether torch compiles the network first: half a minute or more, which only long runs win back."""
    threads: int = 1
    """Of torch, while encoding; the process keeps its own setting."""
    batch: int = 32
    """Images or texts at once, at most."""
    templates: tuple[str, ...] = TEMPLATES
    """Captions of a room, each with one {} for its name with article; what is averaged over."""
    cache: Path | None = None
    """Folder that keeps embeddings of images from run to run; None: nothing is kept."""

    def __post_init__(self) -> None:
        """Raise EncoderError for a setting outside its range. Whether the device is there, only loading tells."""
        if not _DEVICES.fullmatch(self.device):
            raise EncoderError(f"encoder device is {self.device!r}; valid: cpu, cuda, cuda:N")
        if self.precision not in PRECISIONS:
            raise EncoderError(f"encoder precision is {self.precision!r}; valid: {', '.join(PRECISIONS)}")
        if self.precision == "fp16" and self.device == "cpu":
            raise EncoderError("encoder precision is fp16 on cpu; valid there: fp32, bf16; fp16 with device cuda")
        for name in ("threads", "batch"):
            if getattr(self, name) < 1:
                raise EncoderError(f"encoder {name} is {getattr(self, name)}; valid: >= 1")
        if not self.templates:
            raise EncoderError("encoder templates are empty; valid: at least one")
        for template in self.templates:
            check_template(template)
