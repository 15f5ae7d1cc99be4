"""`EncoderOptions`: how an encoder computes. The model is an argument of `load_encoder`. This module imports no torch."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, get_args

from annotated_types import Ge

from lexis.encoder.prompts import TEMPLATES, check_template
from lexis.errors import EncoderError
from lexis.settings import Settings

Precision = Literal["fp32", "bf16", "fp16"]
PRECISIONS: tuple[Precision, ...] = get_args(Precision)
_DEVICES = re.compile(r"cpu|cuda(:\d+)?")


@dataclass(frozen=True)
class EncoderOptions(Settings, place="encoder", error=EncoderError):
    """Options of an encoder's computation: device, precision, batches, prompt templates and cache.

    The same options, images and texts give the same embeddings, up to rounding that depends on the size of batches.
    """

    device: str = "cpu"
    """Device on which torch computes: cpu, cuda or cuda:N."""
    precision: Precision = "fp32"
    """Precision of the arithmetic; the weights stay as they are. fp16 needs a GPU."""
    compiled: bool = False
    """Whether torch compiles the network first. Compilation takes half a minute or more, so it is worthwhile in long runs
    only."""
    threads: Annotated[int, Ge(1)] = 1
    """Number of CPU threads that torch uses while it encodes; the process's own setting is restored afterwards."""
    batch: Annotated[int, Ge(1)] = 32
    """Largest number of images or texts that are encoded at once."""
    templates: tuple[str, ...] = TEMPLATES
    """Captions for a room name, whose embeddings are averaged. Each has one {} in place of the name with its article."""
    cache: Path | None = None
    """Folder in which embeddings of images are kept from run to run. None: no cache."""

    def __post_init__(self) -> None:
        """Raise EncoderError for a setting that is not valid. Only `load_encoder` checks whether the device exists."""
        super().__post_init__()
        if not _DEVICES.fullmatch(self.device):
            self.refuse("device", "cpu, cuda, cuda:N")
        if self.precision == "fp16" and self.device == "cpu":
            self.refuse("precision", "fp32 or bf16 on cpu; fp16 with device cuda")
        if not self.templates:
            self.refuse("templates", "at least one")
        for template in self.templates:
            check_template(template)
