"""A small suite about a flat of two rooms, and SLAMs that break it in several ways."""

from dataclasses import replace

import numpy as np
from helpers.open_flat import OPEN_FLAT

from sim.harness import Lexis, Scenario
from sim.harness.adapters import OdometryOnly
from sim.suites.checks import CheckFinding, SameEstimates
from sim.suites.examination import Examination
from sim.suites.frame_changes import MovedOrigin
from sim.suites.report import CheckVerdict
from sim.suites.suite import Suite, SuitePart, claims


def flat(rng: np.random.Generator, number: int) -> Scenario:
    """A walk with the oracle through a flat of two rooms."""
    return replace(OPEN_FLAT, seed=int(rng.integers(1000)))


ORIGIN = SameEstimates("origin", "The estimates do not depend on the origin.", MovedOrigin())
PART = SuitePart(
    "flat", "A flat.", flat, (*claims(0.95, "labels.accuracy >= 0.8"), *claims(0.95, "floors.accuracy >= 0.9"), ORIGIN), n=2
)
FLAT = Suite("flat", "A flat.", (PART,))


class Oracle(Lexis):
    """LEXIS with the encoder that is told the truth."""

    def __init__(self):
        super().__init__("oracle")


class WrongLabels(Oracle):
    """LEXIS that claims the first label everywhere."""

    def finish(self):
        claims = super().finish()
        return replace(claims, labels=np.zeros_like(claims.labels))


class FloorsByHeight(OdometryOnly):
    """Claims floors by the absolute height in the odometry frame."""

    def finish(self):
        claims = super().finish()
        return replace(claims, floors=np.floor(claims.T_W_B[:, 2, 3] / 3.0).astype(int).clip(0))


class NoLabels(OdometryOnly):
    """Claims a label that no room name has."""

    def finish(self):
        claims = super().finish()
        return replace(claims, labels=np.full(len(claims.frames), 999))


class Broken(OdometryOnly):
    """Raises an exception at the 20th observation."""

    def process(self, observation):
        if observation.index == 20:
            raise RuntimeError("lost")
        super().process(observation)


class BrokenNow(OdometryOnly):
    """Raises an exception when it is made."""

    def __init__(self):
        raise RuntimeError("not today")


def outcomes(report):
    """The outcome of every check, by its name."""
    return {verdict.check: verdict.outcome for verdict in report.verdicts}


def verdict_on(*held, rate=0.9, group=1, n=20):
    """The verdict about a check that holds in these scenarios, or that found something there."""
    part = replace(PART, n=n, group=group)
    findings = (each if isinstance(each, CheckFinding) else CheckFinding(each, "") for each in held)
    found = tuple(Examination("flat", k, OPEN_FLAT, None, {"check": finding}) for k, finding in enumerate(findings))
    return CheckVerdict(part, "check", "", rate, found)
