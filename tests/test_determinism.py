"""The same seed gives the same results bit by bit in another process, and the same house and tour on another processor.

Between processors:

- Houses are equal bit by bit, because specs are rounded and building takes little more than sums and products.
- Tours and odometry differ in the last bits only, because results of LAPACK, BLAS and trigonometry are rounded before any
  decision depends on them.
- Images and maps may differ, since rasterisers and networks may round in any way.
"""

import hashlib
import json
import os
import subprocess
import sys

import numpy as np
import pytest

from sim.harness import Scenario, evaluate, run
from sim.harness.walk import walk
from sim.render.rig import RigConfig
from worlds.presets import sample_from_rooms

GUARD_S = 120.0
"""Only a process that hangs takes that long [s]."""
OTHER_PROCESSOR = {
    "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR AVX2 FMA3 AVX512F AVX512_SKX",
    "OPENBLAS_CORETYPE": "Nehalem",
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F",
    "PYTHONWARNINGS": "ignore",
}
"""A processor of 2008, on which numpy, BLAS and libm use other code than on a current one."""
CONFIG = Scenario(
    house=sample_from_rooms(("kitchen", "bedroom"), seed=31), seed=5, length_m=13.0, rig=RigConfig("wide", 200, 150, 80.0)
)
LONG = Scenario(preset="random", seed=602)
"""A walk of 850 m, which is long enough for rounding errors to accumulate."""


def digest(*parts):
    """A fingerprint of arrays or text that depends on every bit."""
    sha = hashlib.sha256()
    for part in parts:
        sha.update(part.encode() if isinstance(part, str) else np.ascontiguousarray(part).tobytes())
    return sha.hexdigest()


def everything():
    """All results of a run: fingerprints, and result.json without times."""
    done = run(CONFIG)
    tour, odometry = done.session.tour, done.session.odometry
    result, lexis_map = evaluate(done).data(), done.slam.map
    del result["time"]
    return {
        "house": house(done),
        "trajectory": digest(tour.stamps, tour.T_W_B),
        "odometry": digest(odometry.T_O_B, odometry.increment_covariance),
        "images": digest(*(observation.image for observation, _ in done.session)),
        "map": digest(lexis_map.T_W_B, lexis_map.labels, *(keyframe.embedding for keyframe in lexis_map.keyframes)),
        "result": json.loads(json.dumps(result)),
    }


def house(walked):
    """A fingerprint of the spec and of the house built from it."""
    rooms = [np.array(room.polygon.exterior.coords) for room in walked.house.rooms]
    walls = [np.array([wall.start, wall.end]) for wall in walked.house.walls]
    furniture = [np.array([*item.position, item.yaw, *item.size]) for item in walked.house.furniture]
    return digest(walked.house.spec.to_json(), *rooms, *walls, *furniture)


def way():
    """The fingerprint of the house, and every 50th true and odometric pose of the long walk."""
    walked = walk(LONG)
    return [house(walked), walked.tour.T_W_B[::50].tolist(), walked.odometry.T_O_B[::50].tolist()]


@pytest.fixture(scope="module")
def elsewhere():
    """The results of other processes by what they are asked for; both processes work while this one does."""
    environments = {"everything": {"PYTHONHASHSEED": "12345"}, "way": OTHER_PROCESSOR}
    running = {
        name: subprocess.Popen([sys.executable, __file__, name], env=os.environ | changed, stdout=subprocess.PIPE, text=True)
        for name, changed in environments.items()
    }
    yield lambda name: json.loads(running[name].communicate(timeout=GUARD_S)[0])
    for process in running.values():
        process.kill()
        process.wait()


def test_another_process_gives_the_same_run_bit_by_bit(elsewhere):
    here = everything()
    assert here["result"]["loops"]["verified"] > 0
    assert elsewhere("everything") == here


def test_another_processor_gives_the_same_house_and_way(elsewhere):
    spec, true, odometric = way()
    spec_there, true_there, odometric_there = elsewhere("way")
    assert spec == spec_there
    np.testing.assert_allclose(true, true_there, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(odometric, odometric_there, rtol=0.0, atol=1e-9)


if __name__ == "__main__":
    print(json.dumps({"everything": everything, "way": way}[sys.argv[1]]()))
