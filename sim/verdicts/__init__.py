"""Verdicts about a SLAM on many houses, with their confidence: it is good in enough houses, or it has become worse.

    from sim import assert_rate, check

    results = (check(scenario, MySlam()) for scenario in scenarios)
    assert_rate(results, "rooms.pq >= 0.6", p=0.9, confidence=0.95)

Read `rate` first: it tests whether a claim holds in a wanted share of houses, and stops as soon as the answer is known.
`mean` tests whether a claim holds on average, which shows small differences sooner. `comparison` compares two SLAMs on the
same scenarios, figure by figure. `stored_results` reads and writes the results that `lexis-sim compare` compares. `items`
refuses arguments that do not hold results, scenarios or claims, and `outcome` lists the answers of a test.

Glossary:

- verdict: the answer of a statistical test, with the data behind it. Without enough data, the answer is "undecided".
- confidence: 1 minus the largest probability that a definite answer is wrong.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
