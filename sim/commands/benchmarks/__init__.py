"""The command `lexis-sim bench`: `bench` lists the benchmarks, and the other modules hold their functions.

`bench_runs` measures LEXIS, `bench_peers` compares it with other methods, `bench_encoders` compares encoders, `bench_graphs`
is about pose graphs and long walks, and `bench_harness` about the harness itself. `bench_all` runs them all, and
`bench_options` has what they share. `own_methods` has the options that add methods of the user's own to comparisons.
"""
