"""Where in a run the SLAM first went wrong, and by which kinds of errors.

`first_wrong` finds the first wrong frame, for trajectories by the motions of `wrong_motion`. `error_kinds` says what the
wrong frames have in common. `usual_mistakes` recognises floors, rotations, stamps and loops in another convention.
"""
