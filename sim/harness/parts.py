"""The parts of a run, built from its settings: house, tour, odometry, random streams, and the settings of LEXIS."""

from dataclasses import replace

import numpy as np

from lexis.config import Config
from sim.harness.config import RunConfig
from sim.odometry.config import ODOMETRY_PRESETS, OdometryConfig
from sim.tours.config import TourConfig
from worlds.presets import sample_house
from worlds.spec import HouseSpec

TOUR_LENGTH_M = {"home": 140.0}
"""Usual lengths of tours through houses of a preset, where the kind of tour alone would make them longer [m]."""


def house_spec(config: RunConfig) -> HouseSpec:
    """The given house, or the house of preset and seed. Raises `worlds.errors.WorldsError`."""
    return config.house or sample_house(config.preset, config.seed)


def tour_config(config: RunConfig) -> TourConfig:
    """The settings of the tour, with the usual length for the preset where none is requested."""
    usual = TOUR_LENGTH_M.get(config.preset) if config.house is None and config.tour_kind == "rooms" else None
    length_m = config.length_m if config.length_m is not None else usual
    return TourConfig(
        config.tour_kind,
        length_m,
        frame_rate_hz=config.frame_rate_hz,
        sway=config.sway,
        start_manoeuvre=config.start_manoeuvre,
    )


def odometry_config(config: RunConfig) -> OdometryConfig:
    """The settings of the odometry: its preset with the run's overconfidence."""
    return replace(ODOMETRY_PRESETS[config.odometry], overconfidence=config.overconfidence)


def random_streams(config: RunConfig) -> dict[str, np.random.Generator]:
    """One generator for each stage, so that a change to one stage leaves the draws of the others alone."""
    tour, odometry = np.random.SeedSequence(config.seed).spawn(2)
    return {"tour": np.random.default_rng(tour), "odometry": np.random.default_rng(odometry)}


def slam_config(config: RunConfig) -> Config:
    """The settings of LEXIS, with loop closure and refinement switched off where the run says so."""
    settings = config.lexis
    if not config.loops:
        settings = replace(settings, place_recognition=replace(settings.place_recognition, candidates=0))
    if not config.refine:
        settings = replace(settings, labels=replace(settings.labels, refine=False))
    return settings
