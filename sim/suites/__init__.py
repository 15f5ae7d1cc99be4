"""Suites: ready-made checks of any SLAM, by claims about its figures and by laws, most of which relate two runs.

    from sim import check_slam

    report = check_slam(MySlam, suite="open-plan")
    assert report.ok, str(report)

Read `catalogue` first: it lists the suites, with the scenarios of each. A `suite` consists of parts, and a part of scenarios
with their `checks`. `laws` lists the laws that relate two runs, and `consistency` the laws about a single run, of which
`staircases` and `plans` hold some. Some laws change the SLAM's input: `stream_changes`, `frame_changes` and `false_loops`
define the changes, `changed_stream` applies them, and `agreement` tells whether the SLAM's outputs in two runs agree.
`image_evidence` holds laws about images. `examination` runs the scenarios in processes. `report` gives the verdicts, and
`suite_means` those about means over the whole suite. `smallest` finds the smallest scenario in which a check fails, and
`replay_folder` writes the folder of a failure. `expected_failures` lists checks that are known to fail, `figure_table` shows
medians of figures, `openness_chart` draws room quality against openness, and `pytest_items` makes a test for pytest, whose
failures leave the folders of `failed_items`.

Glossary:

- claim: a statement about a figure of one run, such as "rooms.pq >= 0.5".
- estimate: what the SLAM returns, which is poses, labels, rooms, floors and loops.
- law: a statement about two runs, such as "in the rotated house the estimate is the same", or about one run, such as "all
  frames of a room have one label". A law needs no threshold for how good a SLAM is.
- check: a claim or a law, and the share of the scenarios in which it has to hold.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
