"""Settings of a run that follow from its scenario: the house, the tour and the odometry."""

from dataclasses import replace

from sim.errors import SimError
from sim.harness.scenario import Scenario
from sim.odometry.config import ODOMETRY_PRESETS, OdometryConfig
from sim.tours.config import TourConfig
from worlds.presets import sample_house
from worlds.spec import HouseSpec
from worlds.variant import explicit

TOUR_LENGTH_M = {"home": 140.0}
"""Usual length of a tour by preset [m]; other presets have none. The length limits tours that would visit all rooms of a
large house."""


def house_spec(scenario: Scenario) -> HouseSpec:
    """Return the scenario's house; if it has none, a house sampled from its preset and seed. Raises `worlds.WorldsError`."""
    return scenario.house or sample_house(scenario.preset, scenario.seed)


def tour_config(scenario: Scenario) -> TourConfig:
    """Return the settings of the tour; if no length is requested, with the usual length for the preset."""
    usual = TOUR_LENGTH_M.get(scenario.preset) if scenario.house is None and scenario.tour_kind == "rooms" else None
    length_m = scenario.length_m if scenario.length_m is not None else usual
    return TourConfig(
        scenario.tour_kind,
        length_m,
        reverse=scenario.reverse,
        frame_rate_hz=scenario.frame_rate_hz,
        sway=scenario.sway,
        start_manoeuvre=scenario.start_manoeuvre,
    )


def in_house(scenario: Scenario, spec: HouseSpec) -> Scenario:
    """Return the scenario in another house, with the same length of the walk.

    Without an explicit length, a walk through a house of one's own would not have the usual length of the preset.
    """
    return replace(scenario, house=spec, length_m=tour_config(scenario).length_m)


def with_listed_house(scenario: Scenario) -> Scenario:
    """Return a scenario of the same run that lists all rooms, furniture and windows, and the length of the tour.

    Raises `WorldsError` for a house that cannot be built.
    """
    return in_house(scenario, explicit(house_spec(scenario)))


def listed_house(scenario: Scenario) -> HouseSpec:
    """Return the house of a scenario that lists its whole house. Raises `SimError` for other scenarios."""
    spec = scenario.house
    if spec is None or any(storey.furniture is None or storey.windows is None for storey in spec.storeys):
        raise SimError("scenario: its house does not list everything; valid: the result of with_listed_house()")
    return spec


def odometry_config(scenario: Scenario) -> OdometryConfig:
    """Return the settings of the odometry: those of its preset, with the scenario's overconfidence."""
    return replace(ODOMETRY_PRESETS[scenario.odometry], overconfidence=scenario.overconfidence)
