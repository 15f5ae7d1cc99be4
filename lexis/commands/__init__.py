"""The commands of `lexis`, which `lexis.cli` joins.

`run` and `merge` make maps. `info`, `plan` and `query` answer from a map. `relabel` gives it other room names, `interchange`
holds `lexis export` and `lexis import`, and `config` prints the settings. `arguments` holds what several of them share.

A command imports slow packages (torch) inside the function that needs them, so that `--help` and error messages for mistyped
arguments appear at once.
"""
