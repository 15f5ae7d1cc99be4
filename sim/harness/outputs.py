"""A run's folder: written beside its place and renamed, so that a half-written one is never seen."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lexis.files.replace import replaced_folder
from lexis.files.tum_trajectory import write_tum
from lexis.map.folder import save_map
from sim.harness.planning import Trial
from sim.harness.report_data import report_data
from sim.harness.runner import Run
from sim.report import write_report

MARKER = "result.json"
"""By which a folder is known to be that of a run."""


def write_run(run: Run, result: Mapping[str, Any], trials: Sequence[Trial], out: Path) -> None:
    """Write result.json, house.json, report.html, three trajectories at the keyframes and the map to the folder `out`.

    A folder of an earlier run is replaced. Raises `LexisError` where `out` holds anything else or cannot be written.
    """
    with replaced_folder(out, MARKER) as folder:
        (folder / "result.json").write_text(json.dumps(result, indent=1) + "\n")
        (folder / "house.json").write_text(run.house.spec.to_json())
        write_tum(folder / "trajectory.tum", run.stamps, run.map.T_W_B)
        write_tum(folder / "ground_truth.tum", run.stamps, run.true_poses)
        write_tum(folder / "odometry.tum", run.stamps, run.odometry_poses)
        save_map(run.map, folder / "map")
        write_report(folder / "report.html", report_data(run, result, trials))
