"""Benchmarks of LEXIS's optimiser on given pose graphs.

`g2o_files` optimises the public graphs in g2o files. `kernels` tests robust kernels on finished maps, to which it adds the
false loops of `injected_loops`.
"""
