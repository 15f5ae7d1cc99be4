"""`write_replay_folder`: writes the folder of a scenario in which a check of a suite fails."""

from collections.abc import Sequence
from pathlib import Path

from lexis.files.replace import replaced_folder
from sim.harness.failures.why_page import WHY
from sim.harness.scenario import Scenario
from sim.harness.world_tests import SCENARIO, TEST_REPLAY


def write_replay_folder(
    folder: Path, scenario: Scenario, paragraphs: Sequence[str], replay: str, markers: Sequence[str] = (SCENARIO,)
) -> None:
    """Write scenario.json, why.md with these paragraphs, and test_replay.py, which replays the failure.

    An earlier folder is replaced if it holds one of the files `markers`; see `lexis.files.replace.replaced_folder`. Raises
    `LexisError` if the folder cannot be written.
    """
    with replaced_folder(folder, *markers) as beside:
        scenario.save(beside / SCENARIO)
        (beside / WHY).write_text("\n\n".join(paragraphs) + "\n", encoding="utf-8")
        (beside / TEST_REPLAY).write_text(replay, encoding="utf-8")
