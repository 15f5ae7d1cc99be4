"""The report of a run: one HTML file that needs no network, floor plans as pictures, and a table for the terminal.

`data` defines the content of a report, as plain data that any SLAM can fill. `page` writes the HTML from `findings`
(sentences on what went wrong), `figures` (names and meanings of the figures), `timeline`, `confusion`, `room_errors`,
`loop_candidates` (why loop candidates were accepted or refused) and floor plans (`house_plan`). `table` makes a table of the
figures.

A plan is drawn as marks (`drawing`) by `plan`, `symbols`, `rulers` and `overlay`, and becomes SVG (`svg`) or a raster image
(`png`). `inline_image` encodes camera images for the page. `palette` gives every label and room a colour. `drive_picture`
draws a drive of the robot. `frame_picture` shows the camera's image at a frame, and on the plan what was true and estimated
there, with a `legend`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
