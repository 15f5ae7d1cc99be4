"""The commands of `lexis-sim`, a file for each group.

They import late what takes long (torch, MuJoCo), inside the functions that need it: `--help` and a mistyped
argument should not wait for it.
"""
