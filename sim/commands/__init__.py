"""The commands of `lexis-sim`: a module for each group of commands. `sim.cli` puts the groups together.

A command imports slow packages (torch, MuJoCo) inside the function that needs them, so that `--help` and error messages
for mistyped arguments appear at once.
"""
