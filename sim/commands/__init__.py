"""The commands of `lexis-sim`: a module for each group, which `sim.cli` puts together.

A command imports what loads slowly (torch, MuJoCo) inside the function that needs it, so that `--help` and error messages
for mistyped arguments appear at once.
"""
