"""Whether features predict the results of rendered runs: a smaller form of `lexis-sim bench fidelity`, marked slow."""

import numpy as np
import pytest

from lexis.encoder.open_clip_encoder import load_encoder
from sim.bench.fidelity import HOUSE_FIGURES, Agreement, HousePair, agreement, compare_fidelities, mixed_houses, summarised
from worlds.presets import PRESETS


def test_agreement_is_of_ranks():
    same = agreement([(0.1, 0.3), (0.5, 0.4), (0.9, 0.8)])
    assert (same.rho, same.houses) == (1.0, 3) and same.rendered == pytest.approx(0.5)
    assert agreement([(0.1, 0.8), (0.5, 0.4), (0.9, 0.3)]).rho == -1.0
    assert agreement([(0.1, 0.8), (0.5, 0.4)]).rho is None and agreement([(0.1, 0.5)] * 3).rho is None


def test_a_house_without_the_figure_is_left_out():
    pairs = [(0.1, 0.3), (0.5, 0.4), (0.9, 0.8)]
    assert agreement([*pairs, (None, 0.2), (0.2, None)]) == agreement(pairs)
    assert agreement([(None, 0.2)]) == Agreement(0, None, None, None, None)


def test_houses_are_mixed_and_unusual_looks_come_apart():
    mixed = mixed_houses(10, 40)
    usual = [scenario for group, scenario in mixed if group in PRESETS]
    assert len(usual) == 10 and {group for group, _ in mixed[10:]} == {"poor texture", "dim light", "evening light"}
    assert all(
        scenario.house.appearance.texture == "rich" and scenario.house.appearance.light == "day" for scenario in usual
    )
    assert len({scenario.seed for _, scenario in mixed}) == len(mixed)
    assert len({scenario.house.clutter for scenario in usual}) > 2


def test_the_summary_is_of_usual_looks_first_then_by_group():
    pairs = [HousePair("home", "a", *[(0.1, 0.2)] * 3), HousePair("dim light", "b", *[(0.2, 0.9)] * 3)]
    rows = list(summarised(pairs))
    assert [row[:2] for row in rows] == [
        *(("usual looks", name) for name in HOUSE_FIGURES), ("home", "accuracy"), ("dim light", "accuracy"),
    ]  # fmt: skip
    assert rows[0][2].houses == 1 and rows[-1][2].features == 0.9


@pytest.mark.slow
def test_features_predict_the_label_accuracy_of_renders():
    pairs = list(compare_fidelities(mixed_houses(14, 200)[:14], load_encoder("mini")))
    found = agreement([pair.accuracy for pair in pairs])
    assert found.rho >= 0.5  # with 30 houses it is 0.7; with 14 the coefficient itself is uncertain by 0.2
    assert abs(found.rendered - found.features) < 0.1
    assert np.ptp([pair.accuracy[0] for pair in pairs]) > 0.1
