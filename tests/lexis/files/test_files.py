"""Files and folders are replaced completely or not at all, whatever process is killed, interferes or writes meanwhile."""

import errno
import os
import random
import shutil
import signal
import sys
import threading
import time
from itertools import count

import pytest
from helpers.map_builder import corridor_with_offices

from lexis.errors import LexisError
from lexis.files import replace as files
from lexis.files import swap, temporary_folder
from lexis.files.replace import CONTENTS, check_replaceable, replaced_file, replaced_folder, write_contents
from lexis.map.folder import load_map, save_map

MARKER = "marker"
WAYS = ("exchange", "renames")


@pytest.fixture(params=WAYS)
def way(request, monkeypatch):
    """Whether the system can exchange two names atomically; the tests have to pass either way."""
    if request.param == "renames":
        monkeypatch.setattr(swap, "exchange", lambda a, b: False)
    return request.param


def write(folder, content):
    """Write a folder that holds two files, each in a folder of its own."""
    with replaced_folder(folder, MARKER) as new:
        for name in (MARKER, "inner/more"):
            (new / name).parent.mkdir(exist_ok=True)
            (new / name).write_text(content)


def content_of(folder):
    """The content of the folder; the test fails if it is missing or incomplete."""
    first, second = ((folder / name).read_text() for name in (MARKER, "inner/more"))
    assert first == second and sorted(path.name for path in folder.iterdir()) == [CONTENTS, "inner", MARKER]
    return first


def in_child(act):
    """Run `act` in a separate process; return the number of the signal that ended it, or 0."""
    pid = os.fork()
    if pid == 0:
        try:
            act()
        finally:
            os._exit(0)
    return os.WTERMSIG(os.waitpid(pid, 0)[1])


def kill_at(step):
    """Arrange that this process is killed before its `step`-th access to the file system."""
    left = count(step, -1)

    def hook(event, args):
        if event.split(".")[0] in ("open", "os", "shutil", "fcntl", "tempfile") and next(left) == 0:
            os.kill(os.getpid(), signal.SIGKILL)

    sys.addaudithook(hook)


def killed_at_every_step(act):
    """Run `act` in a process repeatedly, killed one file-system access later each time, until it completes."""
    for step in count():

        def act_until(step=step):
            kill_at(step)
            act()

        killed = in_child(act_until)
        yield step
        if not killed:
            return


def test_a_kill_at_any_step_leaves_a_whole_folder_and_a_rerun_works(tmp_path, way):
    """Only where names cannot be exchanged may the name be missing, until the folder is next accessed."""
    folder, found, gone = tmp_path / "map", [], 0
    write(folder, "old")
    for _ in killed_at_every_step(lambda: write(folder, "new")):
        gone += not folder.exists()
        temporary_folder.recover(folder)
        found.append(content_of(folder))
        shutil.rmtree(folder)
        temporary_folder.recover(folder)
        assert not folder.exists() or content_of(folder)
        write(folder, "old")
        assert content_of(folder) == "old" and os.listdir(tmp_path) == ["map"]
    swapped = found.index("new")
    assert set(found[:swapped]) == {"old"} and set(found[swapped:]) == {"new"}
    assert swapped > 20 and len(found) - swapped > 5 and gone == {"exchange": 0, "renames": 1}[way]


def test_a_kill_at_any_step_leaves_a_whole_file(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")

    def replace():
        with replaced_file(path) as beside:
            beside.write_text("new")

    found = [path.read_text() for _ in killed_at_every_step(replace)]
    assert found.index("new") > 5 and set(found[found.index("new") :]) == {"new"}
    replace()
    assert os.listdir(tmp_path) == ["a.txt"]


@pytest.mark.slow
def test_200_of_200_kills_inside_the_swap_leave_a_whole_map(tmp_path, rng, way):
    """The process saves maps continuously and is killed at a random time; most of its time goes into writing and swaps."""
    old, new = corridor_with_offices(rng), corridor_with_offices(rng, loops=[(25, 3)], weights=[1.0])
    path, times = tmp_path / "map", random.Random(7)
    save_map(old, path)

    def save_on_end():
        while True:
            save_map(new, path)
            save_map(old, path)

    for _ in range(200):
        pid = os.fork()
        if pid == 0:
            save_on_end()
        time.sleep(times.uniform(0.005, 0.06))
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
        assert way == "renames" or path.is_dir()
        assert len(load_map(path).loops) in (0, 1)
    save_map(new, path)
    assert len(load_map(path).loops) == 1 and os.listdir(tmp_path) == ["map"]


def test_what_a_living_process_is_making_is_left_alone(tmp_path, way):
    with replaced_folder(tmp_path / "slow", MARKER) as new:
        (new / MARKER).write_text("slow")
        assert in_child(lambda: write(tmp_path / "fast", "fast")) == 0
        assert (new / MARKER).is_file()
    assert sorted(os.listdir(tmp_path)) == ["fast", "slow"]


def test_the_number_of_a_dead_process_that_lives_again_protects_nothing(tmp_path):
    left = tmp_path / f".lexis-{os.getpid()}-abcdefgh"
    (left / "new").mkdir(parents=True)
    (left / "lock").touch()
    write(tmp_path / "map", "new")
    assert os.listdir(tmp_path) == ["map"]


@pytest.mark.parametrize("name", [".lexis-1", ".lexis-x-abcdefgh", ".map-1-abcdefgh", "lexis-99999999-abcdefgh"])
def test_folders_of_others_are_left_alone(tmp_path, name):
    (tmp_path / name).mkdir()
    write(tmp_path / "map", "new")
    assert (tmp_path / name).is_dir()


def test_a_link_to_a_folder_is_not_taken_for_a_leftover(tmp_path):
    (tmp_path / "precious" / "old" / "map").mkdir(parents=True)
    (tmp_path / ".lexis-99999999-abcdefgh").symlink_to(tmp_path / "precious")
    write(tmp_path / "map", "new")
    assert (tmp_path / "precious" / "old" / "map").is_dir()


@pytest.mark.parametrize("earlier", [True, False])
def test_a_symbolic_link_is_followed_and_stays(tmp_path, way, earlier):
    (tmp_path / "disk").mkdir()
    if earlier:
        write(tmp_path / "disk" / "map", "old")
    (tmp_path / "link").symlink_to(tmp_path / "disk" / "map")
    (tmp_path / "file").symlink_to("disk/file.txt")
    write(tmp_path / "link", "new")
    with replaced_file(tmp_path / "file") as beside:
        beside.write_text("text")
    assert (tmp_path / "link").is_symlink() and content_of(tmp_path / "disk" / "map") == "new"
    assert (tmp_path / "file").is_symlink() and (tmp_path / "disk" / "file.txt").read_text() == "text"
    assert sorted(os.listdir(tmp_path)) == ["disk", "file", "link"]
    assert sorted(os.listdir(tmp_path / "disk")) == ["file.txt", "map"]


def test_a_loop_of_links_is_one_clear_error(tmp_path):
    (tmp_path / "a").symlink_to(tmp_path / "b")
    (tmp_path / "b").symlink_to(tmp_path / "a")
    with pytest.raises(LexisError, match="a: cannot be accessed: Too many levels of symbolic links"):
        write(tmp_path / "a", "new")
    with pytest.raises(LexisError, match="a: cannot be written: Too many levels"), replaced_file(tmp_path / "a"):
        pass
    assert sorted(os.listdir(tmp_path)) == ["a", "b"]


def test_writers_of_one_folder_replace_each_other(tmp_path, way):
    errors = []

    def write_often(content):
        try:
            for _ in range(10):
                write(tmp_path / "map", content)
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=write_often, args=(content,)) for content in "abc"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not errors and content_of(tmp_path / "map") in "abc" and os.listdir(tmp_path) == ["map"]


@pytest.mark.parametrize("then", ["gone", "another"])
def test_a_folder_that_is_replaced_while_it_is_checked_holds_no_files_of_others(tmp_path, monkeypatch, then):
    """A listing of the folder is of no use then: `inner` looks like a file once it has been moved away."""
    place = tmp_path / "map"
    write(place, "old")

    def listed_while_it_is_replaced(folder):
        folder.rename(tmp_path / "old")
        if then == "another":
            shutil.copytree(tmp_path / "old", folder)
        return ["inner"]

    monkeypatch.setattr(files, "_files", listed_while_it_is_replaced)
    check_replaceable(place, MARKER)
    assert (tmp_path / "old").exists()


@pytest.mark.parametrize("intruder", ["thesis", "a file"])
def test_a_writer_whose_place_is_taken_keeps_its_work_beside_it(tmp_path, way, intruder):
    place = tmp_path / "map"
    with (
        pytest.raises(LexisError, match=r"map: (exists and holds no|is a file).* is kept as .*map-1$"),
        replaced_folder(place, MARKER) as new,
    ):
        (new / MARKER).write_text("hours of work")
        if intruder == "thesis":
            place.mkdir()
            (place / "chapter1.tex").write_text("years of work")
        else:
            place.write_text("years of work")
    assert (tmp_path / "map-1" / MARKER).read_text() == "hours of work"
    assert (place / "chapter1.tex" if place.is_dir() else place).read_text() == "years of work"
    assert sorted(os.listdir(tmp_path)) == ["map", "map-1"]


def test_a_folder_that_turns_foreign_during_the_swap_is_put_back(tmp_path, way, monkeypatch):
    place, plain = tmp_path / "map", files.swap
    write(place, "old")

    def swap_too_late(new, target, old):
        monkeypatch.setattr(files, "swap", plain)
        (target / MARKER).unlink()  # from here on the folder is not ours
        return plain(new, target, old)

    monkeypatch.setattr(files, "swap", swap_too_late)
    with pytest.raises(LexisError, match=r"holds no marker.* is kept as .*map-1$"):
        write(place, "new")
    assert (place / "inner" / "more").read_text() == "old" and content_of(tmp_path / "map-1") == "new"
    assert sorted(os.listdir(tmp_path)) == ["map", "map-1"]


def test_a_file_whose_place_became_a_folder_is_kept_beside(tmp_path):
    path = tmp_path / "a.txt"
    with (
        pytest.raises(LexisError, match=r"a\.txt: cannot be written.* is kept as .*a-1\.txt$"),
        replaced_file(path) as beside,
    ):
        beside.write_text("hours of work")
        path.mkdir()
    assert (tmp_path / "a-1.txt").read_text() == "hours of work"


def test_a_disk_that_fills_up_leaves_the_old(tmp_path, way, monkeypatch):
    def full(descriptor):
        raise OSError(errno.ENOSPC, "No space left on device")

    write(tmp_path / "map", "old")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(LexisError, match="No space left"):
        write(tmp_path / "map", "new")
    assert content_of(tmp_path / "map") == "old" and os.listdir(tmp_path) == ["map"]


@pytest.mark.parametrize("strange", ["thesis.tex", "inner/thesis.tex", "src/deep/thesis.tex"])
def test_a_file_that_somebody_else_put_into_a_folder_is_never_lost(tmp_path, way, strange):
    folder = tmp_path / "map"
    write(folder, "old")
    with pytest.raises(LexisError, match=rf"map: holds {strange}.* is kept as .*map-1$"), replaced_folder(folder, MARKER):
        (folder / strange).parent.mkdir(parents=True, exist_ok=True)
        (folder / strange).write_text("years of work")
    with pytest.raises(LexisError, match=f"map: holds {strange}, which was not written with this folder"):
        check_replaceable(folder, MARKER)
    assert (folder / strange).read_text() == "years of work" and (folder / MARKER).read_text() == "old"


def test_a_marker_alone_does_not_make_a_folder_replaceable(tmp_path):
    (tmp_path / MARKER).write_text("result of another program")
    with pytest.raises(LexisError, match=f"holds {MARKER}, which was not written"):
        check_replaceable(tmp_path, MARKER)


@pytest.mark.parametrize("cache", ["__pycache__", ".pytest_cache", ".hypothesis"])
def test_caches_of_python_and_pytest_are_no_files_of_others(tmp_path, way, cache):
    write(tmp_path / "map", "old")
    (tmp_path / "map" / cache / "v").mkdir(parents=True)
    (tmp_path / "map" / cache / "v" / "cached").write_text("")
    check_replaceable(tmp_path / "map", MARKER)
    write(tmp_path / "map", "new")
    assert content_of(tmp_path / "map") == "new"


def test_an_error_inside_leaves_the_old(tmp_path, way):
    write(tmp_path / "map", "old")
    with pytest.raises(KeyboardInterrupt), replaced_folder(tmp_path / "map", MARKER):
        raise KeyboardInterrupt
    assert content_of(tmp_path / "map") == "old" and os.listdir(tmp_path) == ["map"]


def test_a_check_leaves_nothing_behind(tmp_path):
    check_replaceable(tmp_path / "a" / "b", MARKER)
    assert not os.listdir(tmp_path)


def test_a_mount_point_is_refused_before_the_work(tmp_path, monkeypatch):
    (tmp_path / "map").mkdir()
    monkeypatch.setattr(os.path, "ismount", lambda path: path == tmp_path / "map")
    with pytest.raises(LexisError, match="map: is a mount point"):
        check_replaceable(tmp_path / "map", MARKER)


def test_a_folder_with_a_file_that_the_user_has_changed_is_not_replaced(tmp_path):
    place = tmp_path / "map"
    write(place, "old")
    write(place, "new")
    more = place / "inner" / "more"
    before = more.stat()
    more.write_text("own")
    os.utime(more, ns=(before.st_atime_ns, before.st_mtime_ns))  # as if an older file had been moved there
    with pytest.raises(LexisError, match="holds inner/more, which was changed since this folder was written and would be"):
        write(place, "newer")
    assert more.read_text() == "own"


def test_a_copy_of_a_folder_can_be_replaced(tmp_path):
    place = tmp_path / "map"
    write(place, "old")
    shutil.copytree(place, tmp_path / "copy")
    write(tmp_path / "copy", "new")
    assert content_of(tmp_path / "copy") == "new"


def test_a_writer_that_takes_the_place_in_the_middle_of_a_swap_is_replaced(tmp_path, monkeypatch):
    """Where names cannot be exchanged atomically, there is a moment at which the name does not exist."""
    place = tmp_path / "map"
    write(place, "old")
    monkeypatch.setattr(swap, "exchange", lambda a, b: False)
    move, calls = swap.move_folder, count()

    def and_another_writes(folder, to):
        move(folder, to)
        if next(calls) == 0:
            folder.mkdir()
            (folder / MARKER).write_text("another")
            write_contents(folder)

    monkeypatch.setattr(swap, "move_folder", and_another_writes)
    write(place, "new")
    assert content_of(place) == "new" and os.listdir(tmp_path) == ["map"]


def test_a_folder_that_cannot_be_renamed_is_copied_aside(tmp_path, monkeypatch):
    """In a lower layer of an overlay file system, as in a container image, renaming a folder fails."""
    place = tmp_path / "map"
    write(place, "old")
    monkeypatch.setattr(swap, "exchange", lambda a, b: False)
    rename = type(place).rename

    def across_layers(self, target):
        if self == place:
            raise OSError(errno.EXDEV, "Invalid cross-device link")
        return rename(self, target)

    monkeypatch.setattr(type(place), "rename", across_layers)
    write(place, "new")
    assert content_of(place) == "new" and os.listdir(tmp_path) == ["map"]
