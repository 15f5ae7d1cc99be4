"""Every figure of result.json: its name, how it is written, what it means."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

MISSING = "–"


@dataclass(frozen=True)
class Definition:
    """How one figure is shown."""

    name: str
    form: str
    """A format of `str.format`."""
    meaning: str = ""


@dataclass(frozen=True)
class Figure:
    """A figure as it is shown."""

    name: str
    value: str
    meaning: str


_SHARE, _COUNT, _METRES, _SECONDS, _SCORE = "{:.1%}", "{:,}", "{:.3f} m", "{:.2f} s", "{:.3f}"
_SIGNED = "{:+d}"
PLACES = "place_recognition"
"""The section whose figures are by N and not by name."""

SECTIONS: dict[str, dict[str, Definition]] = {
    "coverage": {
        "rooms_with_keyframe": Definition("rooms in the map", _COUNT, "rooms of the walk that have a keyframe"),
        "rooms_walked": Definition("rooms on the walk", _COUNT, "rooms that the walk went through"),
        "path_covered": Definition(
            "share of the walk",
            _SHARE,
            "between the first and the last keyframe, without gaps over 3 m; no other figure is about the rest",
        ),
    },
    "labels": {
        "accuracy": Definition("label accuracy", _SHARE, "keyframes labelled as the true room that contains the camera"),
        "accuracy_baseline": Definition("… before refinement", _SHARE, "the same, for the label of each image alone"),
        "accuracy_graded": Definition(
            "… graded", _SHARE, "the same, but within 0.75 m of an open boundary the label of either side is right"
        ),
    },
    "rooms": {
        "pq": Definition(
            "panoptic quality",
            _SCORE,
            "of predicted and true rooms, matched one to one at IoU > 0.5 of their keyframes: "
            "the IoU of the matches, lowered by rooms without a match; 1 is perfect",
        ),
        "precision": Definition("precision", _SHARE, "predicted rooms that have a match"),
        "recall": Definition("recall", _SHARE, "true rooms that have a match"),
        "hydra_precision": Definition(
            "Hydra's precision", _SHARE, "mean share of a predicted room that one true room covers; splits do not lower it"
        ),
        "hydra_recall": Definition(
            "Hydra's recall", _SHARE, "mean share of a true room that one predicted room covers; merges do not lower it"
        ),
        "ari": Definition("adjusted Rand index", _SCORE, "agreement on which keyframes share a room; 0 by chance, 1: equal"),
        "v_measure": Definition("V-measure", _SCORE, "harmonic mean of homogeneity and completeness of predicted rooms"),
        "splits": Definition("splits", _COUNT, "predicted rooms beyond the first that lie mostly (> half) in one true room"),
        "merges": Definition("merges", _COUNT, "true rooms beyond the first that lie mostly (> half) in one predicted room"),
        "count_error": Definition("count error", _SIGNED, "predicted minus true number of rooms that have a keyframe"),
    },
    "floors": {
        "accuracy": Definition("floor accuracy", _SHARE, "keyframes off the stairs that are on the right floor"),
        "count_error": Definition("count error", _SIGNED, "predicted minus true number of floors that have a keyframe"),
    },
    "loops": {
        "proposed": Definition("proposed pairs", _COUNT, "candidate pairs handed to geometric verification"),
        "verified": Definition("loop edges", _COUNT, "pairs that verification accepted"),
        "true": Definition("true edges", _COUNT, "edges whose relative pose is within 0.5 m and 0.2 rad of the truth"),
        "false": Definition("false edges", _COUNT, "all other edges"),
        "precision": Definition("precision", _SHARE, "true edges among the edges"),
        "recall": Definition(
            "recall", _SHARE, "true revisits (within 1 m and 0.5 rad, 10 s apart or more) that got at least one true edge"
        ),
    },
    PLACES: {},
    "trajectory": {
        "ate_odometry_m": Definition("ATE, odometry", _METRES, "RMSE of positions after SE(3) alignment, no scale"),
        "ate_m": Definition("ATE, optimised", _METRES, "the same, after loop closing; as `evo_ape tum -a` prints it"),
        "rpe_8m_odometry_m": Definition("RPE 8 m, odometry", _METRES, "RMSE of the translation over stretches of 8 m"),
        "rpe_8m_m": Definition("RPE 8 m, optimised", _METRES, "the same, after loop closing"),
        "rpe_24m_odometry_m": Definition("RPE 24 m, odometry", _METRES, "RMSE of the translation over stretches of 24 m"),
        "rpe_24m_m": Definition("RPE 24 m, optimised", _METRES, "the same, after loop closing"),
    },
    "planning": {
        "queries": Definition("queries", _COUNT, "room-to-room plans that were asked for and driven by a simulated robot"),
        "success": Definition("success", _SHARE, "the robot ended in a room of the goal's name and had touched nothing"),
        "spl": Definition("SPL", _SCORE, "success weighted by path length: shortest way over driven way, 0 for failures"),
        "collisions": Definition("collisions", _COUNT, "drives that ended because the robot touched something"),
    },
    "run": {
        "path_m": Definition("path", "{:.1f} m", "length of the walk"),
        "duration_s": Definition("duration", "{:.0f} s", "simulated"),
        "frames": Definition("frames", _COUNT, "camera frames along the walk"),
        "keyframes": Definition("keyframes", _COUNT, "nodes of the pose graph"),
    },
    "house": {
        "rooms": Definition("rooms", _COUNT, "of the house, stairs and gardens among them"),
        "floors": Definition("floors", _COUNT, "of the house"),
        "area_m2": Definition("area", "{:.1f} m²", "indoors"),
        "openness": Definition("openness", "{:.2f}", "open share of the walls between rooms; 0: all doors, 1: no walls"),
    },
    "time": {
        "house_s": Definition("house", _SECONDS, "generate, furnish and check the house, and plan the walk"),
        "scene_s": Definition("scene", _SECONDS, "build the MuJoCo model"),
        "render_s": Definition("rendering", _SECONDS, "images, or features in their place"),
        "slam_s": Definition("LEXIS", _SECONDS, "all stages of the SLAM"),
        "realtime_factor": Definition("real-time factor", "{:.2f} ×", "simulated duration over LEXIS's time"),
    },
}
"""By the sections and keys of result.json, in the order of reading."""


def figures(result: Mapping[str, Any], section: str) -> list[Figure]:
    """The numbers of a section; ones without a definition are shown by their key, absent ones left out."""
    if section == PLACES:
        return _places(result)
    known, values = SECTIONS[section], result.get(section) or {}
    keys = [*(key for key in known if key in values), *(key for key in values if key not in known)]
    rows = ((known.get(key, Definition(key.replace("_", " "), "{}")), values[key]) for key in keys)
    return [
        Figure(definition.name, shown(value, definition.form), definition.meaning)
        for definition, value in rows
        if not isinstance(value, Mapping | list | tuple | str)
    ]


def _places(result: Mapping[str, Any]) -> list[Figure]:
    """Place recognition as rows: per N, the queries that succeeded among those that could."""
    return [
        Figure(
            f"found, N = {n}",
            f"{shown(counts.get('tp'), _COUNT)} of {shown(counts.get('possible'), _COUNT)}",
            f"queries with {n} or more right proposals, of those with so many earlier keyframes within 1 m and 0.5 rad",
        )
        for n, counts in (result.get(PLACES) or {}).items()
    ]


def figure(result: Mapping[str, Any], section: str, key: str) -> str:
    """One figure as it is shown."""
    return shown((result.get(section) or {}).get(key), SECTIONS[section][key].form)


def shown(value: object, form: str) -> str:
    """A value in its form; a dash for a figure that the run cannot have."""
    if value is None:
        return MISSING
    if value == 0 and form == _SIGNED:
        return "0"
    if form == "{}" and isinstance(value, float):
        form = "{:.4g}"
    return form.format(value)
