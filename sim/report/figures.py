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

SECTIONS: dict[str, dict[str, Definition]] = {
    "labels": {
        "accuracy": Definition("label accuracy", _SHARE, "keyframes labelled as the true room that contains the camera"),
        "accuracy_baseline": Definition("… before refinement", _SHARE, "the same, for the best prompt of each image alone"),
        "accuracy_graded": Definition(
            "… graded", _SHARE, "the same, but in the ambiguity band of an open boundary either side's label counts"
        ),
    },
    "rooms": {
        "pq": Definition("panoptic quality", _SCORE, "over keyframes; one-to-one matching of instances at IoU > 0.5"),
        "precision": Definition("precision", _SHARE, "predicted instances that have a match"),
        "recall": Definition("recall", _SHARE, "true instances that have a match"),
        "hydra_precision": Definition("Hydra's precision", _SHARE, "max-overlap, not one-to-one; splits do not lower it"),
        "hydra_recall": Definition("Hydra's recall", _SHARE, "max-overlap; for comparison with published work"),
        "ari": Definition("adjusted Rand index", _SCORE, "agreement of the groupings of keyframes; 0 by chance, 1 if equal"),
        "v_measure": Definition("V-measure", _SCORE, "harmonic mean of homogeneity and completeness"),
        "splits": Definition("splits", _COUNT, "predicted rooms beyond the first that lie mostly (> half) in one true room"),
        "merges": Definition("merges", _COUNT, "true rooms beyond the first that lie mostly (> half) in one predicted room"),
        "count_error": Definition("count error", _SIGNED, "predicted minus true number of rooms"),
    },
    "floors": {
        "accuracy": Definition("floor accuracy", _SHARE, "keyframes on the right floor"),
        "count_error": Definition("count error", _SIGNED, "predicted minus true number of floors"),
    },
    "loops": {
        "proposed": Definition("proposed", _COUNT, "candidate pairs handed to geometric verification"),
        "verified": Definition("verified", _COUNT, "pairs that became loop edges"),
        "true": Definition("true", _COUNT, "edges whose relative pose is within 0.5 m and 0.2 rad of the truth"),
        "false": Definition("false", _COUNT, "all other edges"),
        "precision": Definition("precision", _SHARE, "true edges among the edges"),
        "recall": Definition(
            "recall", _SHARE, "true revisits (within 1 m and 0.5 rad, 10 s apart or more) that got at least one true edge"
        ),
    },
    "trajectory": {
        "ate_odometry_m": Definition("ATE, odometry", _METRES, "RMSE of positions after SE(3) alignment, no scale"),
        "ate_m": Definition("ATE, optimised", _METRES, "the same, after loop closing; as `evo_ape tum -a` prints it"),
        "rpe_8m_odometry_m": Definition("RPE 8 m, odometry", _METRES, "error of the translation over stretches of 8 m"),
        "rpe_8m_m": Definition("RPE 8 m, optimised", _METRES),
        "rpe_24m_odometry_m": Definition("RPE 24 m, odometry", _METRES, "error of the translation over stretches of 24 m"),
        "rpe_24m_m": Definition("RPE 24 m, optimised", _METRES),
    },
    "planning": {
        "queries": Definition("queries", _COUNT, "room-to-room plans asked for"),
        "success": Definition("success", _SHARE, "the robot stood in the right room and had touched nothing"),
        "spl": Definition("SPL", _SCORE, "success weighted by path length"),
        "collisions": Definition("collisions", _COUNT, "times the robot touched something"),
    },
    "run": {
        "path_m": Definition("path", "{:.1f} m", "length of the walk"),
        "duration_s": Definition("duration", "{:.0f} s", "simulated"),
        "frames": Definition("frames", _COUNT, "images seen"),
        "keyframes": Definition("keyframes", _COUNT, "nodes of the pose graph"),
    },
    "house": {
        "rooms": Definition("rooms", _COUNT),
        "floors": Definition("floors", _COUNT),
        "area_m2": Definition("area", "{:.1f} m²"),
        "openness": Definition("openness", "{:.2f}", "open share of the boundary between rooms; 1: no walls"),
    },
    "time": {
        "house_s": Definition("house", _SECONDS, "generate, furnish, prove, and plan the tour"),
        "scene_s": Definition("scene", _SECONDS, "build the MuJoCo model"),
        "render_s": Definition("rendering", _SECONDS),
        "slam_s": Definition("LEXIS", _SECONDS, "all stages"),
        "realtime_factor": Definition("real-time factor", "{:.2f} ×", "simulated duration over LEXIS's time"),
    },
}
"""By the sections and keys of result.json, in the order of reading."""


def figures(result: Mapping[str, Any], section: str) -> list[Figure]:
    """The numbers of a section; ones without a definition are shown by their key, absent ones left out."""
    known, values = SECTIONS[section], result.get(section) or {}
    keys = [*(key for key in known if key in values), *(key for key in values if key not in known)]
    rows = ((known.get(key, Definition(key.replace("_", " "), "{}")), values[key]) for key in keys)
    return [
        Figure(definition.name, shown(value, definition.form), definition.meaning)
        for definition, value in rows
        if not isinstance(value, Mapping | list | tuple | str)
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
