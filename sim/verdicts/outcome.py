"""`Outcome`: the possible answers of a statistical test."""

from typing import Literal

Outcome = Literal["holds", "fails", "undecided"]
