"""The page why.md of a failure: what fails, where the run first went wrong, what mends it, and how to replay it."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sim.errors import GraphicsError
from sim.harness.crash import TRACEBACK, Crash
from sim.harness.diagnosis.error_kinds import most_frequent
from sim.harness.diagnosis.first_wrong import WrongFrame, crash_frame, first_wrong, wrong_labels
from sim.harness.failures.blame_table import BlameTable
from sim.harness.failures.estimated_frames import estimated_frames
from sim.harness.failures.nearest_changes import nearest
from sim.harness.failures.search import Reference, Search
from sim.harness.finished_run import Run
from sim.harness.results import group_of
from sim.harness.scenario import Scenario
from sim.harness.scenario_sessions import picture_session
from sim.harness.shrinking.failure_test import FailureTest, Observed
from sim.harness.shrinking.reduction import Reduction
from sim.harness.shrinking.scenario_difference import difference, relabelled_rooms
from sim.harness.shrinking.scenario_size import ScenarioSize
from sim.harness.slam_under_test import full_name_of
from sim.render.image_files import encoded
from sim.report.frame_picture import FrameEstimates, place_image
from sim.session import Session
from sim.wording import counted, joined

WHY = "why.md"
_LISTED = 8
"""Largest number of listed changes by which the failure goes away."""
_LEAST_PX = 480
"""Least width of the picture of the first wrong frame [px], unless the SLAM was given smaller images."""
_IMAGE, _PLAN = "first-wrong.png", "first-wrong-plan.png"
_UNITS = {
    "drift": "drift (kinds of odometry error)",
    "motion": "motion (number of complications)",
    "length_m": "length of the tour [m]",
    "area_m2": "area of the rooms, gardens included [m²]",
}
_HOW_TO_REPLAY = (
    "## Replay",
    "",
    "Run `pytest PATH`, with the path of this folder, where the failure was found: in the folder of your tests, or where",
    "`lexis-sim` was started. It fails as long as the failure exists. The scenario is in `scenario.json`.",
)
"""The last section of why.md."""
_WHOLE_RUN = "`report.html` shows the whole run."
_ORIGINAL = "`original.json` is the scenario in which the failure was found."
_RANKED = ("opening_ranks", "labels", "appearance", "rig")
"""Entries of `ScenarioSize` that only rank scenarios: their numbers mean nothing to a reader."""


@dataclass(frozen=True)
class Page:
    """Lines of Markdown, and the pictures that they show."""

    lines: tuple[str, ...]
    pictures: Mapping[str, bytes]
    """Contents of the picture files, by file name."""

    @property
    def files(self) -> dict[str, bytes]:
        """Contents of why.md and of the picture files, by file name."""
        return {WHY: ("\n".join(self.lines) + "\n").encode(), **self.pictures}


def why_page(
    reduction: Reduction,
    test: FailureTest,
    blamed: BlameTable,
    smallest: Observed | Crash,
    reference: Run | None,
) -> Page:
    """Make the page about a failure of a SLAM.

    `smallest` is the run or crash of the SLAM in the smallest scenario, and `reference` the run of the reference there.
    """
    if isinstance(smallest, Crash):
        return crash_page(f"The SLAM {smallest.what}", smallest, reduction, blamed)
    assert test.condition is not None
    figure = test.condition.figure
    head = [
        f"# {test.condition}",
        *_under_test(full_name_of(smallest.run.slam)),
        "",
        *_failure(reduction, test, smallest, reference),
    ]
    place = wrong_frame_page(smallest.run, figure, reference)
    hint = _unfurnished(reduction, figure, '`--keep "drop furniture"` keeps it.')
    return _page(head, place, _search_sections(reduction, blamed, figure, hint), _WHOLE_RUN)


def failed_test_page(
    name: str,
    run: Run,
    figure: str | None,
    message: str,
    search: Search | None,
    reference: Reference,
) -> Page:
    """Make the page about a test that fails.

    `figure` is the figure that the failing assertion is about, such as "floors.accuracy"; None if it is unknown. `message`
    is what pytest says about the failure, "" if it is not known. `search` is None if no smaller scenario was searched for.
    """
    head = [f"# {name} fails", *_under_test(full_name_of(run.slam)), *_quoted(message)]
    if reference.run is not None:
        head += ["", f"The test passes with the reference, `{full_name_of(reference.run.slam)}`."]
    head += ["", reference.left_out] if reference.left_out else []
    place = wrong_frame_page(run, figure, reference.run)
    if search is None:
        return _page(head, place, (), _WHOLE_RUN)
    head += _compared_with_original(search, message, reference.run is None)
    command = f"lexis-sim shrink PATH/original.json --slam {full_name_of(run.slam) or 'MODULE:CLASS'}"
    options = '--fails CONDITION --keep "drop furniture" -o furnished'
    meant = 'PATH is the path of this folder, and CONDITION the opposite of the assertion, such as "labels.accuracy < 0.9".'
    hint = _unfurnished(search.reduction, figure, f"`{command} {options}` keeps it.", meant)
    return _page(head, place, _search_sections(search.reduction, search.blamed, hint=hint), _WHOLE_RUN)


def _unfurnished(reduction: Reduction, figure: str | None, *remedy: str) -> tuple[str, ...]:
    """Return lines on a search that has removed all furniture, for figures of labels and rooms; none otherwise."""
    before, after = reduction.sizes
    if not before.furniture or after.furniture or group_of(figure) not in ("labels", "rooms"):
        return ()
    return ("No furniture is left by which an encoder could recognise a room.", *remedy)


def _compared_with_original(search: Search, message: str, may_be_another: bool) -> Iterator[str]:
    """Yield lines on the failure in the original scenario. If the smallest one may fail for another reason, they say so."""
    if search.kinds:
        yield from ("", search.kinds)
    if search.found and search.found != message:
        yield from ("", "In the scenario in which the failure was found, pytest said:", *_quoted(search.found))
        if search.found_place and not search.kinds and may_be_another:
            yield ""
            yield from _first_place(search.found_place, "`pytest --no-lexis-shrink` shows the failure as it was found.")


def _under_test(slam: str) -> list[str]:
    """Return the lines that name the SLAM under test; none for an unknown SLAM."""
    return ["", f"SLAM under test: `{slam}`"] if slam else []


def _quoted(message: str) -> list[str]:
    return ["", "```", *message.splitlines(), "```"] if message else []


def crash_page(title: str, crash: Crash, reduction: Reduction | None = None, blamed: BlameTable | None = None) -> Page:
    """Make the page about a crash of the SLAM.

    `reduction` and `blamed` are None if no smaller scenario was searched for.
    """
    more = f" More is in `{TRACEBACK}`." if crash.traceback else ""
    head = [f"# {title}", *_under_test(crash.slam), "", f"`{crash.message.replace('`', '')}`.{more}"]
    return _page(head, _crash_frame_page(crash), _search_sections(reduction, blamed))


def _page(head: Sequence[str], place: Page, sections: Iterable[str], whole_run: str = "") -> Page:
    """Join the parts of a page: first lines, a section about one frame, sections about a search, and how to replay."""
    middle = list(sections)
    files = [line for line in (whole_run, _ORIGINAL if middle else "") if line]
    lines = (*head, "", *place.lines, *([""] if place.lines else []), *middle, *_HOW_TO_REPLAY, *files)
    return Page(lines, place.pictures)


def _failure(reduction: Reduction, test: FailureTest, smallest: Observed, reference: Run | None) -> Iterator[str]:
    assert test.condition is not None
    original, figure = reduction.signature.value, test.condition.figure
    yield f"`{figure}` is **{_number(smallest.value)}** in this scenario; a SLAM without the failure has"
    yield f"`{test.condition.opposite}`. In the scenario in which the failure was found, it is {_number(original)}."
    if not reduction.accepted:
        return
    if kinds := test.original.compared(smallest.run, figure):
        yield kinds
    if reference is not None:
        yield f"The reference, `{full_name_of(reference.slam)}`, passes in both."
    elif not kinds and test.original.first_wrong:
        yield ""
        yield from _first_place(test.original.first_wrong, "`original.json` is the scenario as it was found.")


def _first_place(place: str, found: str) -> list[str]:
    """Return the lines that compare the smallest scenario with the original, which first went wrong at `place`."""
    return [
        f"The original run first went wrong {place}. If the error below is of another kind, the smallest scenario",
        f"may fail for another reason; {found}",
    ]


def wrong_frame_page(run: Run, figure: str | None, reference: Run | None = None) -> Page:
    """Make the section about the first wrong frame, with its place on a plan and, if images can be rendered, its image.

    Frames that are wrong in the run of the `reference`, too, are passed over.
    """
    frame = first_wrong(run, figure, reference)
    is_new = reference is not None and not (frame is not None and frame.in_reference)
    title = "## Where it first went wrong" + (", and the reference did not" if is_new else "")
    if frame is None:
        return Page((title, "", f"No single frame shows what is wrong with {figure or 'this run'}."), {})
    estimates = estimated_frames(run, figure, frame)
    drawn = "".join(_how_drawn(run, frame, estimates))
    shared = ["The reference is wrong at every frame at which this run is wrong, too."] if frame.in_reference else []
    more = [*shared, *_frequent_label(run, figure), *_faults(run), *_most_similar(run, figure, frame)]
    return _frame_page(title, run.session, frame, run.scenario, estimates, drawn, more)


def _frequent_label(run: Run, figure: str | None) -> list[str]:
    """Return a line on the most frequent wrong label, for figures of labels; no line for other figures."""
    if run.estimate.labels is None or figure is None or not figure.startswith("labels."):
        return []
    names = [*run.room_names, "nothing"]  # the label -1 stands for none
    rows = np.flatnonzero(wrong_labels(run, figure))
    pairs = zip(run.true_labels[rows].tolist(), run.estimate.labels[rows].tolist(), strict=True)
    wrong = Counter(f"{names[truth]} is labelled {names[estimate]}" for truth, estimate in pairs)
    if not wrong:
        return []
    kind = most_frequent(wrong)
    share = f"{wrong[kind]} of {counted(wrong.total(), 'frame')} with a wrong label"
    return [f"The most frequent wrong label: {kind}, in {share}."]


def _most_similar(run: Run, figure: str | None, frame: WrongFrame) -> Iterator[str]:
    """Yield the room names most similar to the image and, for a wrong label, whether the image alone is misleading."""
    if not frame.similarities:
        return
    yield f"Most similar room names: {', '.join(f'{name} {value:.3f}' for name, value in frame.similarities)}."
    wrong = np.flatnonzero(wrong_labels(run, figure)).tolist()
    row = int(np.searchsorted(run.estimate.frames, frame.frame))
    if row in wrong:
        right = {k for k in wrong if run.most_similar(k, 1)[0][0] == run.room_names[run.true_labels[k]]}
        count = len(right) if row in right else len(wrong) - len(right)
        name, reason = ("the true name", "; the error comes after the encoder") if row in right else ("a wrong name", "")
        yield f"The image alone is most similar to {name}, as in {count} of {counted(len(wrong), 'wrong frame')}{reason}."


def _faults(run: Run) -> list[str]:
    """Return a line on the faults of a run, and when each of them first changed a frame; no line without any."""
    first: dict[str, int] = {}
    for truth in run.delivered:
        for name in truth.faults:
            first.setdefault(name, truth.index)
    stamps = run.session.tour.stamps
    listed = [f"{name}, first at {stamps[index] - stamps[0]:.1f} s" for name, index in first.items()]
    return [f"Faults of this run: {'; '.join(listed)}."] if listed else []


def _how_drawn(run: Run, frame: WrongFrame, estimates: FrameEstimates) -> Iterator[str]:
    """Yield sentences on what the plan shows of the estimate, each with a space before it."""
    if estimates.T_W_B is not None:
        since_s = run.session.tour.stamps[frame.since or 0] - run.session.tour.stamps[0]
        agrees = (
            f"so that it agrees with the true path at {since_s:.1f} s" if frame.since is not None else "onto the true path"
        )
        yield f" The estimated path is moved as a whole {agrees}."
    if estimates.groups:
        yield " Each dot is a frame at its true position, in the colour of the SLAM's estimate; later frames are small."


def _crash_frame_page(crash: Crash) -> Page:
    """Make the section about the frame at which the SLAM raised an exception; it is empty if this frame is not known."""
    if crash.done is None:
        return Page((), {})
    session = picture_session(crash.scenario)
    return _frame_page("## Where it happened", session, crash_frame(session, crash.done), crash.scenario)


def _frame_page(
    title: str,
    session: Session,
    frame: WrongFrame,
    scenario: Scenario,
    estimates: FrameEstimates | None = None,
    how_drawn: str = "",
    more: Sequence[str] = (),
) -> Page:
    lines = [title, "", f"{str(frame)[0].upper()}{str(frame)[1:]}.", *more]
    pictures = {_PLAN: encoded(place_image(session, frame.frame, estimates), ".png")}
    shown = f"![the place on the plan]({_PLAN})"
    storey = f"storey {session.truths[frame.frame].storey}" if len(session.house.storeys) > 1 else "the storey"
    caption = f"The plan shows {storey}, and the camera's place and field of view in yellow.{how_drawn}"
    try:
        (image,) = _with_large_images(session, scenario).pictures([frame.frame])
        pictures[_IMAGE] = encoded(image, ".png")
        shown = f"![the image of the camera]({_IMAGE}) {shown}"
        if scenario.fidelity == "features":
            caption += " The SLAM was given features; the image was rendered for this page."
        if left_out := session.faults_of_images:
            caption += f" The image is shown without the effect of {joined(left_out, 'and')}."
    except GraphicsError as error:
        caption += f" The image of the camera is left out: {error}."
    return Page((*lines, "", shown, "", caption), pictures)


def _with_large_images(session: Session, scenario: Scenario) -> Session:
    """Return the session, or if the SLAM was given features, one whose images are at least `_LEAST_PX` wide.

    The search for a smaller scenario makes images small, too, although nothing is gained by small images on features.
    """
    rig = scenario.rig
    if scenario.fidelity != "features" or rig.width >= _LEAST_PX:
        return session
    larger = replace(rig, width=_LEAST_PX, height=round(rig.height * _LEAST_PX / rig.width))
    return picture_session(replace(scenario, rig=larger))


def _search_sections(
    reduction: Reduction | None, blamed: BlameTable | None, figure: str = "", hint: Sequence[str] = ()
) -> Iterator[str]:
    """Yield the lines on what mends the failure, what the failure needs, and how small the scenario has become.

    `reduction` and `blamed` are None if there was no search; there are no lines then. `hint` are lines on what the search
    has removed.
    """
    if reduction is None or blamed is None:
        return
    yield from _mends(blamed, figure)
    yield ""
    yield from _needs(reduction)
    yield ""
    yield from _sizes(reduction, hint)
    yield ""


def _mends(blamed: BlameTable, figure: str) -> Iterator[str]:
    """Yield the lines of a table that shows, for each part of the run that was replaced, whether the failure is gone.

    The table has one row for each replacement, for example by perfect odometry. If `figure` is given, the row also has the
    value of the figure with the replacement.
    """
    yield "## What mends it"
    yield from _effects(blamed, figure, "the smallest scenario")
    if blamed.not_needed and blamed.not_needed not in str(blamed):
        yield ""
        yield f"In the smallest scenario, the failure needs {blamed.not_needed}."
    if blamed.original is not None:
        yield ""
        yield "In the scenario in which the failure was found:"
        yield from _effects(blamed.original, figure, "the original scenario")
    if blamed.another_error:
        yield ""
        yield blamed.another_error


def _effects(blamed: BlameTable, figure: str, scenario: str) -> Iterator[str]:
    """Yield a summary of a blame table and, if there are rows to show, the rows as a table in Markdown."""
    yield ""
    yield f"{str(blamed)[0].upper()}{str(blamed)[1:]}"
    if not any(row.effect in _EFFECTS for row in blamed.rows):
        return
    yield ""
    yield f"| {scenario} with | the failure is |{f' {figure} |' * bool(figure)}"
    yield "|---|---|" + "---|" * bool(figure)
    for row in blamed.rows:
        if row.effect in _EFFECTS:
            said = _EFFECTS[row.effect] + (f": {row.detail}" if row.detail else "")
            yield f"| {row.substitution} | {said} |{f' {_number(row.value)} |' * bool(figure)}"


_EFFECTS = {"mends": "**gone**", "does not mend": "still there", "cannot be told": "unknown"}


def _needs(reduction: Reduction) -> Iterator[str]:
    yield "## What the failure needs"
    yield ""
    if not reduction.passing:
        yield "None of the smaller scenarios that were run passes." if reduction.tried else "No smaller scenario was run."
        if reduction.last_passing is not None:
            larger, change = reduction.last_passing
            yield f"In a larger scenario, this change made the failure go away: {difference(larger, change.scenario)}."
        return
    yield "The failure goes away with any one of these changes:"
    yield ""
    changed = nearest(reduction.scenario, [change.scenario for change in reduction.passing])
    unique = list(dict.fromkeys(difference(reduction.scenario, other) for other in changed))
    yield from (f"- {text}" for text in unique[:_LISTED])
    if len(unique) > _LISTED:
        yield f"- and {len(unique) - _LISTED} more"


def _sizes(reduction: Reduction, hint: Sequence[str]) -> Iterator[str]:
    before, after = reduction.sizes
    yield "## How small it is"
    yield ""
    yield reduction.note
    yield from hint
    yield ""
    yield from _size_table(before, after)
    if changed := relabelled_rooms(reduction.original, reduction.scenario):
        yield ""
        yield f"The search gave some rooms simpler labels, and they kept their ids: {', '.join(changed)}."


def _size_table(before: ScenarioSize, after: ScenarioSize) -> Iterator[str]:
    """Yield a table with the sizes of the original and the smallest scenario. Entries that are zero in both are left out."""
    yield "| | original | smallest |"
    yield "|---|---|---|"
    for name, old, new in zip(ScenarioSize._fields, before, after, strict=True):
        if name not in _RANKED and (old or new):
            yield f"| {_UNITS.get(name, name)} | {_size(old)} | {_size(new)} |"


def _size(value: object) -> str:
    """Return a size as text; an infinite length becomes "as long as needed"."""
    return "as long as needed" if value == math.inf else f"{value:g}"


def _number(value: float | None) -> str:
    return "null" if value is None else f"{value:.4g}"
