"""Worker processes use one thread each for linear algebra, whatever the settings of the parent process are."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from threadpoolctl import threadpool_info

from sim.processes import process_pool

started = []


def begin(word):
    started.append(word)


def threads():
    import numpy as np

    np.ones((4, 4)) @ np.ones((4, 4))
    return {library["num_threads"] for library in threadpool_info()}, os.environ["OMP_NUM_THREADS"], started


def test_workers_use_one_thread_and_call_the_given_function_first(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "3")
    with process_pool(1, begin, ("ready",)) as pool:
        assert pool.submit(threads).result() == ({1}, "1", ["ready"])


def noted(path):
    path.touch()
    time.sleep(0.2)


def test_a_block_that_ends_early_drops_the_calls_that_wait(tmp_path):
    def interrupted():
        with process_pool(1) as pool:
            for call in [pool.submit(noted, tmp_path / str(k)) for k in range(40)]:
                call.result()
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert 1 <= len(list(tmp_path.iterdir())) < 20
    with process_pool(1) as pool:
        pool.submit(noted, tmp_path / "last")
    assert (tmp_path / "last").exists()


INTERRUPTED = """
import os, signal, sys, time
from pathlib import Path

from sim.processes import process_pool

started = Path(sys.argv[1])
if __name__ == "__mp_main__":  # in a worker, which imports this file before it handles calls
    started.touch()
    time.sleep(0.5)


def begin():
    started.touch()
    time.sleep(60.0)


if __name__ == "__main__":
    try:
        with process_pool(2, *{"import": (), "start": (begin,)}[sys.argv[2]]) as pool:
            pool.submit(os.getpid)
            while not started.exists():
                time.sleep(0.01)
            if sys.argv[2] == "start":
                time.sleep(1.0)  # the workers have imported this file, and sleep in `begin`
            os.kill(0, signal.SIGINT)  # as Ctrl-C does, to all processes of the group
            time.sleep(60.0)
    except KeyboardInterrupt:
        print("interrupted")
"""


@pytest.mark.parametrize("place", ["import", "start"])
def test_workers_that_are_still_starting_end_without_a_traceback_on_ctrl_c(tmp_path, place):
    script = tmp_path / "interrupted.py"
    script.write_text(INTERRUPTED)
    command = [sys.executable, script, tmp_path / "started", place]
    done = subprocess.run(command, capture_output=True, text=True, start_new_session=True, timeout=50)
    assert (done.stdout, done.stderr) == ("interrupted\n", "")


TERMINATED = """
import os, signal, sys, time
from pathlib import Path

from lexis.command_line import Parser, run_command
from sim.processes import process_pool

folder = Path(sys.argv[1])


def work(number):
    (folder / f"began-{number}").touch()
    try:
        time.sleep(60.0)
    except KeyboardInterrupt:
        (folder / f"interrupted-{number}").touch()
        raise


def begin(arguments):
    with process_pool(2) as pool:
        for number in range(2):
            pool.submit(work, number)
        while len(list(folder.glob("began-*"))) < 2:
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGTERM)  # to this process alone, as CI systems do
        time.sleep(60.0)


if __name__ == "__main__":
    parser = Parser()
    parser.set_defaults(command=begin)
    sys.exit(run_command(parser, [], ()))
"""


def test_sigterm_interrupts_the_work_of_all_processes(tmp_path):
    """Ctrl-C comes to all processes of a terminal, and SIGTERM to one: the others have to be told."""
    script = tmp_path / "terminated.py"
    script.write_text(TERMINATED)
    command = [sys.executable, script, tmp_path]
    done = subprocess.run(command, capture_output=True, text=True, start_new_session=True, timeout=50)
    assert done.returncode == 130 and len(list(tmp_path.glob("interrupted-*"))) == 2


KILLED = """
import os, time
from sim.processes import process_pool

if __name__ == "__main__":
    pool = process_pool(1)
    print(pool.submit(os.getpid).result(), flush=True)
    time.sleep(600.0)
"""


def test_workers_end_with_a_process_that_is_killed(tmp_path):
    script = tmp_path / "killed.py"
    script.write_text(KILLED)
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True) as process:
        worker = int(process.stdout.readline())
        os.kill(worker, 0)  # it lives
        process.kill()
    for _ in range(600):
        stat = Path(f"/proc/{worker}/stat")
        try:
            if stat.read_text(encoding="utf-8").rpartition(")")[2].split()[0] == "Z":  # it has ended, and nobody asks how
                return
        except FileNotFoundError:
            return
        time.sleep(0.1)
    os.kill(worker, 9)
    pytest.fail("the worker still lives")
