"""Reading files from outside: only regular files of bounded size are read, and every refusal is one line."""

import os
from pathlib import Path

import pytest
from pydantic import BaseModel, ConfigDict

from lexis.errors import LexisError, MapError, one_line
from lexis.files.reading import FileKind, numbered_lines, read_bytes, read_json, read_model, read_text, read_yaml

KIND = FileKind("a small file", 10_000, MapError, unusable="no thing")
LARGE = FileKind("a file", 10_000_000, MapError, unusable="no thing")


class Thing(BaseModel):
    """A model with a size."""

    model_config = ConfigDict(allow_inf_nan=False)

    size: float


def lines(path, kind):
    return list(numbered_lines(path, kind))


READERS = [read_bytes, read_text, lines, read_json, read_yaml, lambda path, kind: read_model(path, kind, Thing)]


def pipe(path):
    os.mkfifo(path)


def sparse(path):
    with path.open("wb") as file:
        file.truncate(50_000_000_000)


@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda path: None, "cannot be read: No such file"),
        (os.mkdir, "cannot be read: is a folder"),
        (pipe, "cannot be read: is a device or a pipe"),
        (lambda path: path.symlink_to("/dev/zero"), "cannot be read: is a device or a pipe"),
        (lambda path: path.symlink_to(path), "cannot be read: Too many levels"),
        (sparse, "no thing: larger than 0.01 MB"),
    ],
)
def test_nothing_but_regular_files_of_bounded_size_is_read(read, make, says, tmp_path):
    """Reading a pipe to which nobody writes would block for ever."""
    path = tmp_path / "file"
    make(path)
    with pytest.raises(MapError, match=f"{path}: {says}.*; valid: a"):
        read(path, KIND)


@pytest.mark.parametrize(
    ("read", "content", "says"),
    [
        (read_text, b"\xff\xfe", "not text in UTF-8"),
        (lines, b"\xff\xfe", "not text in UTF-8"),
        (lines, b"1 2\n" + b"3" * 100_000, "line 2 has more than 20000 characters"),
        (read_json, b"[" * 200_000 + b"]" * 200_000, "nested too deeply"),
        (read_json, b'{"a":' * 200_000, "nested too deeply"),
        (read_json, b"[" + b"9" * 5000 + b"]", "too many digits"),
        (read_json, b"{", "is not JSON: Expecting"),
        (read_json, b'[{"a": 1, "b": {"c": 1, "c": 1}}]', "has the field 'c' twice in one object; valid: once"),
        (READERS[-1], b"[" * 200_000, "recursion limit"),
        (READERS[-1], b'{"size": "' + b"x" * 1_000_000 + b'"}', "size: Input should be a valid number"),
        (READERS[-1], b'{"size": ' + b"9" * 5000 + b"}", "no thing: Invalid JSON: number out of range"),
        (READERS[-1], b'{"size": 1, "size": 2}', "has the field 'size' twice in one object; valid: once"),
        (read_yaml, b"[" * 5000, "is not YAML"),
        (read_yaml, b"- 1", "holds no keys"),
        (read_yaml, b"# nothing", "holds no keys"),
        (read_yaml, b"a: &a {b: 1}\nc: *a", "aliases are not read"),
        (read_yaml, b"a: &a {k: 1}\nb: &b {<<: [*a, *a, *a]}\nc: {<<: [*b, *b, *b]}", "aliases are not read"),
    ],
)
def test_what_is_wrong_inside_is_one_short_line(read, content, says, tmp_path):
    path = tmp_path / "file"
    path.write_bytes(content)
    with pytest.raises(MapError, match=says) as error:
        read(path, LARGE)
    assert "\n" not in str(error.value) and len(str(error.value)) < 300 + len(str(path))
    assert str(error.value).count("; valid: ") == 1


def test_yaml_is_text_whatever_its_scalars_and_tags_pretend(tmp_path):
    path = tmp_path / "file"
    path.write_text("%YAML:1.0\ndate: 2001-13-99\nnumber: .inf\nset: !!set {a}\ntag: !!python/name:os.system x\n")
    assert read_yaml(path, KIND) == {"date": "2001-13-99", "number": ".inf", "set": {"a": ""}, "tag": "x"}


def test_lines_are_numbered_and_comments_left_out(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"# first\r\n1 2\r\n\n 3\n#4")
    assert lines(path, KIND) == [(2, "1 2"), (4, " 3")]


@pytest.mark.parametrize("most", [30, 31, 32, 100])
def test_a_long_text_keeps_its_ends_on_one_line(most):
    said = one_line("first words\n" + "x" * 1_000_000 + "\n valid: 1", most)
    assert len(said) == most and said.startswith("first words xx") and said.endswith("xx valid: 1"[-most // 3 + 1 :])
    assert one_line(" a\n\n b ") == "a b" and one_line(LexisError()) == "LexisError"


@pytest.mark.parametrize("name", ["a\0.json", "a\ud800.json"])
def test_what_cannot_be_the_name_of_a_file_is_no_foreign_exception(tmp_path, name):
    with pytest.raises(LexisError, match="is not a valid file name"):
        read_bytes(tmp_path / name, FileKind("a file", 10))


def test_a_byte_order_mark_is_no_part_of_the_first_line(tmp_path):
    (tmp_path / "list.txt").write_bytes(b"\xef\xbb\xbf# comment\n1 a\n")
    assert list(numbered_lines(tmp_path / "list.txt", FileKind("a list", 100))) == [(2, "1 a")]


def test_a_file_is_not_read_beyond_its_bound_whatever_its_size_says():
    """Files of /proc state a size of 0."""
    with pytest.raises(LexisError, match="larger than"):
        read_bytes(Path("/proc/self/status"), FileKind("a file", 10))
