"""What is known and written about a failure: its causes, a page with pictures, and a test that replays it.

`blame_table` replaces one stage or difficulty of the run at a time to find which one causes the failure. `nearest_changes`
finds the smallest changes of the scenario by which the failure goes away. `estimated_frames` prepares the SLAM's estimate
for the plan of the place where the SLAM first went wrong, and `why_page` makes the page why.md. `failure_folder` writes the
folder of a failed claim, and `failed_test` the folder of a failed test in pytest, after the `search` for its smallest
scenario.
"""
