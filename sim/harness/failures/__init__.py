"""What is written about a failure: where the SLAM first went wrong, a page with pictures, and a test that replays it.

`first_wrong` finds where in a run the SLAM first went wrong, for trajectories by the motions of `wrong_motion`.
`error_kinds` says what the wrong frames have in common.
`claimed_frames` prepares the SLAM's claims for the plan of this place, and `why_page` makes the page why.md.
`failure_folder` writes the folder of a failed claim, and `failed_test` the folder of a failed test in pytest, after the
`search` for its smallest scenario.
"""
