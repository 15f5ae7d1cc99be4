"""Houses per second: both kinds of tests handle the same house, and only one of them runs LEXIS."""

from sim.bench.throughput import check_layout, run_on_features


def test_both_kinds_of_tests_handle_the_house_that_the_page_describes():
    layout, features = check_layout(100), run_on_features(100)
    assert layout.rooms == features.rooms == 10 and layout.frames == 0 and 200 < features.frames < 300
    assert 0.0 < layout.processor_s < features.processor_s
