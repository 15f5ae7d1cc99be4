"""Questions: the wording makes no difference, the content does."""

import re
import string

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lexis.errors import LexisError
from lexis.questions.captions import ACTIVITY_CAPTIONS, THING_CAPTIONS, read_question
from sim.bench.everyday_questions import HELD_OUT, TUNING
from sim.training.phrases import PLACE_FRAMES, ROOM_NAMES, THING_FRAMES, framed

THING_FORMS = (
    "the {}", "where is the {}", "Where is the {}?", "I need the {}", "I want the {}", "take me to the {}", "go to the {}",
    "Please take me to the {}.", "is there a {}", "show me the {}", "find me a {}", "I'm looking for the {}",
    "could you bring me to the {} please", "a room with a {}", "I want to go to the {}", "a photo of a {}",
    "which way to the {}", "I can't find the {}", "we cannot find a {}",
)  # fmt: skip
ACTIVITY_FORMS = (
    "where can I {}", "where do we {}", "I need to {}", "I'd like to {}", "a place to {}", "a quiet place to {}",
    "where to {}", "somewhere to {}", "find me a place to {}", "the best place to {}", "can I {} somewhere",
    "Where should I {} here?",
    "a room to {} in", "I want to {}",
)  # fmt: skip
PLAIN_WORDS = st.text(string.ascii_lowercase, min_size=1, max_size=8)


@pytest.mark.parametrize("thing", ["kitchen", "dining table", "toilet", "umbrella stand", "office"])
def test_a_thing_is_one_question_in_any_form(thing):
    questions = {read_question(form.format(thing)) for form in THING_FORMS}
    assert len(questions) == 1
    (question,) = questions
    assert question.readings[0][0] == thing and len(question.readings[0]) == len(THING_CAPTIONS) and not question.negated


@pytest.mark.parametrize("activity", ["cook dinner", "wash my hands", "work", "go upstairs", "take a bath"])
def test_an_activity_is_one_question_in_any_form(activity):
    questions = {read_question(form.format(activity)) for form in ACTIVITY_FORMS}
    assert len(questions) == 1
    (question,) = questions
    assert question.readings[0][0] == activity and len(question.readings[0]) == len(ACTIVITY_CAPTIONS)


@pytest.mark.parametrize("lead", ["where to", "take me to", "please", "a place to", "inside the", "not the", "where can I"])
@pytest.mark.parametrize("end", [" , please", " , here", ",, now", " ; please , here", " ... , please?"])
def test_punctuation_before_polite_words_neither_counts_as_content_nor_leaves_none(lead, end):
    assert all(caption.strip(" ,;.?") for caption in read_question(lead + end).readings[0])
    if lead != "please":
        assert read_question(f"{lead} kitchen{end}") == read_question(f"{lead} kitchen")
    with pytest.raises(LexisError, match="valid: some words"):
        read_question(end)


def test_captions_the_encoder_was_trained_in_are_read_too():
    for activity in ("cook dinner", "wash my hands"):
        texts = [text for text in framed(PLACE_FRAMES, [activity]) if text != activity]
        assert {read_question(text).readings[0][0] for text in texts} == {activity}
    texts = [text for text in framed(THING_FRAMES, ["bathtub"]) if text != "bathtub"]
    assert {read_question(text).readings[0][0] for text in texts} == {"bathtub"}


def test_names_alone_stay_as_they_are():
    for text in (name for names in ROOM_NAMES.values() for name in names if " with " not in name and " to " not in name):
        assert read_question(text).readings[0] == (text,)
    assert read_question("PCs and Macs").readings == (("PCs and Macs",),)


@pytest.mark.parametrize(
    "text",
    ["not a kitchen", "isn't a kitchen", "not the kitchen", "not in the kitchen", "anything but the kitchen",
     "everything except the kitchen",
     "all rooms but the kitchen", "take me to a room without a kitchen", "somewhere other than the kitchen",
     "Not a kitchen!", "no kitchen", "a room that isn't a kitchen", "a place which isn’t the kitchen",
     "No kitchen, please."],
)  # fmt: skip
def test_what_is_not_wanted_is_understood(text):
    question = read_question(text)
    assert question.negated and question.readings == (read_question("the kitchen").readings[0],)


@pytest.mark.parametrize(
    "text",
    [
        "a bedroom without a window",
        "the bathroom but not the shower",
        "a table, not a desk",
        "a room with a bed except mine",
        "I don't want the kitchen",
        "Don’t take me to the kitchen",
        "where can't I sleep",
        "where isn't there a window",
        "I am not looking for a desk",
        "I cannot sleep in the office",
        "I want no kitchen",
        "a bedroom with a desk and no window",
        "neither a kitchen nor a bathroom",
        "no kitchen nor a bathroom",
    ],
)
def test_a_part_that_is_not_wanted_is_refused_in_a_line(text):
    with pytest.raises(LexisError, match='valid: what to look for, or "not a kitchen"') as error:
        read_question(text)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "text",
    [
        "a room that doesn't have a bathtub", "which room doesn't have a bed", "rooms that don't have a bed",
        "rooms that aren't bathrooms", "rooms other than the bathroom", "apart from the bathroom",
        "take me anywhere but the bathroom", "where can't I cook", "a quiet place, not the kitchen",
        "where isn't there a kitchen", "where I cannot cook",
    ],
)  # fmt: skip
def test_a_room_is_never_found_by_what_is_not_wanted(text):
    with pytest.raises(LexisError, match="negates a part of itself") as error:
        read_question(text)
    negation = re.search("negates a part of itself by (?:'([^']+)'|\"([^\"]+)\")", str(error.value))
    assert (negation[1] or negation[2]) in text


@pytest.mark.parametrize(
    ("text", "content"),
    [("not dining room", "dining room"), ("not children's room", "children's room"), ("where can I not cook", "cook")],
)
def test_a_negation_may_have_two_words(text, content):
    question = read_question(text)
    assert question.negated and question.readings[0][0] == content


def test_a_negated_activity_is_still_an_activity():
    assert read_question("where can I not cook").readings[0] == read_question("where can I cook").readings[0]


def test_a_relative_clause_is_no_negation():
    question = read_question("where can I keep things that are not needed")
    assert not question.negated and question.readings[0][0] == "keep things that are not needed"
    assert read_question("where can I keep things that aren't needed") == question
    assert not read_question("office no 3").negated


def test_a_need_also_asks_for_things_that_serve_it_unless_they_are_named():
    assert [reading[0] for reading in read_question("I need the toilet").readings] == ["toilet", "bathroom"]
    assert len(read_question("a bathroom with a toilet").readings) == 1
    assert len(read_question("not a toilet").readings) == 1


@pytest.mark.parametrize("text", ["", "  ", "?", " . "])
def test_a_blank_question_is_refused(text):
    with pytest.raises(LexisError, match="blank"):
        read_question(text)


@given(st.text(max_size=80))
def test_any_text_is_read_or_refused(text):
    try:
        question = read_question(text)
    except LexisError:
        return
    assert question.readings and all(caption.strip() for reading in question.readings for caption in reading)


@given(st.lists(PLAIN_WORDS, min_size=1, max_size=4).map(" ".join))
def test_reading_what_was_read_changes_nothing(words):
    """The first caption of a question is its content: parsing that again gives the same content."""
    read = read_question(f"where can I find the {words}")
    assert read_question(f"the {read.readings[0][0]}").readings == read.readings


def test_the_lists_of_everyday_questions_share_none_and_have_different_forms():
    texts = [question.text for question in (*TUNING, *HELD_OUT)]
    assert len(set(texts)) == len(texts) >= 60 and len(HELD_OUT) >= 30
    assert all(read_question(question.text).negated == question.negated for question in (*TUNING, *HELD_OUT))


@pytest.mark.parametrize("thing", ["sofa bed", "tea room", "media room", "yoga studio", "pizza oven"])
def test_a_negated_thing_keeps_the_letters_of_its_words(thing):
    assert read_question(f"not a {thing}").readings[0][0] == thing


def test_a_question_of_endless_length_is_refused():
    with pytest.raises(LexisError, match="500 characters"):
        read_question("please " * 20_000)
