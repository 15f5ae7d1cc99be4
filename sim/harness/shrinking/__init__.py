"""The search for the smallest scenario in which a SLAM fails in the same way.

`failure_test` says whether a run fails, and a `failure_signature` tells failures apart. For this, `original_failure`
compares the failure in a smaller scenario with the first one, and `good_slam` tells whether a good SLAM fails there, too.
`reducer` is the search, and returns a `reduction`. It tries the steps of `reductions`, and compares scenarios by
`scenario_size`. Steps that change the house are in `house_reductions` and `wall_reductions`, which share `house_edits`.
`scenario_difference` says in words what the search has changed.
"""
