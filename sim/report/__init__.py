"""The report of a run: one HTML file that needs no network, floor plans as pictures, and a table for the terminal.

`data` is the content of a report, as plain data that any SLAM can fill. `page` writes the HTML from `findings` (sentences on
what went wrong), `figures` (names and meanings of the figures), `timeline`, `confusion`, `room_errors` and floor plans
(`house_plan`); `table` prints the figures. A plan is drawn as marks (`drawing`) by `plan`, `symbols` and `overlay`, and
becomes SVG (`svg`) or PNG (`png`, `inline_image`). `palette` gives every label a colour. `drive_picture` draws a drive
of the robot, and `frame_picture` what the camera saw at a frame, and where.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
