"""Folders that look as if LEXIS had written them."""

from lexis.files.replace import CONTENTS, _files


def list_files(folder):
    """Write the list of files of a folder, as if `replaced_folder` had written the files that it holds now."""
    (folder / CONTENTS).write_text("".join(f"{line}\n" for line in _files(folder).values()))
