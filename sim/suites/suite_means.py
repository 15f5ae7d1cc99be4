"""`SuiteMean`: the verdict about a claim that has to hold on average over all scenarios of a suite."""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from sim.harness.claims import Claim
from sim.suites.examination import Examination
from sim.suites.suite import Suite
from sim.verdicts.mean import MeanVerdict
from sim.verdicts.outcome import Outcome

ALL_PARTS = "all parts"
"""Stands for the name of a part in a verdict about the scenarios of several parts."""


def name_of_mean(claim: Claim | str) -> str:
    """Return the name of a claim about a mean in reports, such as "all parts: mean rooms.pq >= 0.7"."""
    return f"{ALL_PARTS}: mean {claim}"


@dataclass(frozen=True, eq=False)
class SuiteMean:
    """The verdict about a claim on average over all scenarios of a suite; each group of scenarios counts as one scenario."""

    suite: Suite
    claim: Claim
    examined: tuple[Examination, ...]
    """All scenarios that were examined so far, of all parts."""
    confidence: float

    @property
    def name(self) -> str:
        """The claim, as reports name it."""
        return name_of_mean(self.claim)

    @property
    def is_complete(self) -> bool:
        """Whether all scenarios have been examined. A mean must not be judged repeatedly, so it is judged only then."""
        return len(self.examined) == sum(part.n for part in self.suite.parts)

    @cached_property
    def verdict(self) -> MeanVerdict:
        """The test of the mean over the scenarios so far."""
        return MeanVerdict(self.confidence, tuple(self._margins()))

    @property
    def outcome(self) -> Outcome | Literal["not applicable", "not examined"]:
        """The outcome of `verdict`; "not examined" until all scenarios are, "not applicable" if no run has the figure."""
        if not self.is_complete:
            return "not examined"
        return self.verdict.outcome if self.verdict.margins else "not applicable"

    def __str__(self) -> str:
        if self.outcome in ("not examined", "not applicable"):
            return f"{self.name}: {self.outcome}"
        return f"{self.name} is {self.verdict}"

    def _margins(self) -> Iterator[float]:
        """Yield the mean margin of each group of scenarios; scenarios of one group are not independent."""
        for part in self.suite.parts:
            own = sorted((each for each in self.examined if each.part == part.name), key=lambda each: each.number)
            groups = defaultdict(list)
            for each in own:
                if each.result is not None and (margin := self.claim.margin(each.result)) is not None:
                    groups[each.number // part.group].append(margin)
            yield from (float(np.mean(margins)) for margins in groups.values())
