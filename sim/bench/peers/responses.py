"""`lexis-sim bench settings`: how the figures of LEXIS respond to each of its settings, over many houses.

Every house is walked once. LEXIS maps this walk with its default settings, and once more for each other value of one
setting, so that differences are due to the setting alone.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from concurrent.futures import as_completed
from dataclasses import astuple, dataclass, fields, replace
from functools import partial
from pathlib import Path

from lexis.config import Config
from lexis.errors import ConfigError
from sim.bench.peers.side_by_side import run_side_by_side
from sim.bench.row_files import Curve, draw_panels, is_picture, write_rows
from sim.bench.stage_costs import UNCHANGED, StageRow, figures_of, gains
from sim.errors import SimError
from sim.fidelity import Fidelity
from sim.harness import Scenario
from sim.harness.adapters import Lexis
from sim.harness.world_tests import usual_rate_hz
from sim.processes import process_pool, usable_cores
from worlds.valid_names import did_you_mean

FACTORS = (0.5, 0.7, 1.4, 2.0)
"""Factors by which each setting is multiplied. Whole numbers are rounded."""
SECTIONS = ("keyframes", "landmarks", "labels", "sight", "place_recognition", "verification", "pose_graph")
"""Sections of `Config` whose settings are varied. The others are for several sessions, for the search of paths, and for the
paper's method of finding rooms."""
UNUSED = frozenset({"labels.neighbours", "labels.every", "sight.independence", "verification.seed"})
"""Settings that are not varied: the default methods do not use them, or nothing but the ends of plans depends on them."""
_DIGITS = 3


@dataclass(frozen=True)
class SettingVariant:
    """LEXIS's default settings with another value of one setting."""

    setting: str
    """Name with section, such as "sight.range_m"."""
    ratio: float
    """Ratio of the value to the default."""
    value: float
    config: Config

    @property
    def name(self) -> str:
        """Setting and value, such as "sight.range_m = 4"."""
        return f"{self.setting} = {self.value:g}"


def check_sections(sections: Sequence[str]) -> None:
    """Raise `SimError` for a section that has no settings to vary."""
    for section in sections:
        if section not in SECTIONS:
            guess = did_you_mean(section, SECTIONS)
            raise SimError(f"--sections: unknown section {section!r:.60}{guess}; valid: {', '.join(SECTIONS)}")


def variants(sections: Sequence[str] = SECTIONS) -> tuple[SettingVariant, ...]:
    """Return all variants of the settings in these sections. Values that are not valid are left out."""
    return tuple(variant for section in sections for variant in _of_section(section))


def _of_section(section: str) -> Iterator[SettingVariant]:
    usual = getattr(Config(), section)
    for field in fields(usual):
        default, setting = getattr(usual, field.name), f"{section}.{field.name}"
        if type(default) not in (int, float) or setting in UNUSED:
            continue
        seen = {default}
        for factor in FACTORS:
            value = round(default * factor) if type(default) is int else float(f"{default * factor:.{_DIGITS}g}")
            if value in seen:
                continue
            seen.add(value)
            try:
                config = replace(Config(), **{section: replace(usual, **{field.name: value})})
            except ConfigError:
                continue
            yield SettingVariant(setting, value / default, value, config)


def measure_responses(
    presets: Sequence[str],
    seeds: Sequence[int],
    sections: Sequence[str] = SECTIONS,
    fidelity: Fidelity = "features",
) -> Iterator[list[StageRow]]:
    """Yield the rows of each house as soon as it is finished, from as many processes as there are cores."""
    measure = partial(measure_house_responses, tried=variants(sections), fidelity=fidelity)
    with process_pool(usable_cores()) as pool:
        houses = [pool.submit(measure, preset, seed) for preset in presets for seed in seeds]
        for finished in as_completed(houses):
            yield finished.result()


def measure_house_responses(
    preset: str, seed: int, tried: Sequence[SettingVariant], fidelity: Fidelity = "features"
) -> list[StageRow]:
    """Map one house with the default settings and with each variant. The rows bear the variants' names."""
    scenario = Scenario(preset=preset, seed=seed, fidelity=fidelity, frame_rate_hz=usual_rate_hz(fidelity))
    configs = {UNCHANGED: Config(), **{variant.name: variant.config for variant in tried}}
    slams = {name: Lexis(scenario.encoder, config) for name, config in configs.items()}
    runs = run_side_by_side(scenario, slams)
    return [StageRow(preset, seed, name, *astuple(figures_of(runs[name], slam))) for name, slam in slams.items()]


def write_responses(rows: Sequence[StageRow], sections: Sequence[str], path: Path) -> None:
    """Write the rows as CSV, or draw the response curves as PNG or SVG; the ending of the path decides which."""
    if is_picture(path):
        figures = ("labels", "rooms", "ate_m")
        panels = [[(section, _curves(rows, section, name)) for section in sections] for name in figures]
        draw_panels(panels, ("value / default", ("labels, change", "room PQ, change", "ATE, change [m]")), path)
    else:
        write_rows(rows, path)


def _curves(rows: Sequence[StageRow], section: str, figure: str) -> dict[str, Curve]:
    """Return the curve of each setting: ratio to the default, mean change of the figure, and its standard error."""
    changes, found = gains(rows), defaultdict[str, list[tuple[float, float, float]]](lambda: [(1.0, 0.0, 0.0)])
    for each in variants((section,)):
        gain = changes[each.name]
        point = each.ratio, getattr(gain.mean, figure), getattr(gain.error, figure)
        found[each.setting.partition(".")[2]].append(point)
    return {name: sorted(points) for name, points in found.items()}
