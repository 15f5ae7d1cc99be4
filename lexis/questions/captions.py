"""Conversion of a question to captions: "where can I cook?" and "a place to cook" give the same captions.

An encoder that was trained on captions takes every word for a part of the picture, so that "I need the toilet" resembles
neither a toilet nor its room. The conversion therefore has these steps:

1. Normalise the text: lower case, no punctuation at the end, no contractions.
2. Remove the words that only ask ("where can I", "please"), which leaves the content: a thing, a room or an activity.
3. Recognise a negation ("not a kitchen"), because encoders do not understand negations.
4. Put the content into several captions, so that no single wording decides.
5. Add readings for rooms and things that serve the same need, such as the bathroom for a question about the toilet.
"""

import re
from typing import NamedTuple, TypeAlias

from lexis.encoder.prompts import with_article
from lexis.errors import LexisError

MAX_CHARACTERS = 500
"""Largest number of characters in a question; the time to convert a question grows with the square of its length."""
THING_CAPTIONS = ("{}", "{a}", "a photo of {a}", "a view of {a}")
"""Captions for a thing or a room: {} stands for its name, {a} for its name with an article."""
ACTIVITY_CAPTIONS = (
    "{}", "a place to {}", "where can I {}", "a room to {} in", "where to {}", "I want to {}", "a room where people {}",
)  # fmt: skip
"""Captions for an activity: {} stands for its words, such as "wash my hands"."""

Captions: TypeAlias = tuple[str, ...]
"""Captions with the same meaning, or templates of captions. The embeddings of captions are combined to their mean."""

_THE = r"(?:the|a|an|my|our|your|his|her|their|some|any|this|that)"
_WHO = r"(?:i|we|you|one|people|they|somebody|someone|anybody|anyone)"
_CAN = r"(?:can|could|do|does|did|should|shall|may|might|must|would|will)"
_WANT = rf"{_WHO} (?:really |just |all )?(?:want|need|have|has|wish|got|would like|would love)"
_VAGUE = r"(?:good|best|better|nice|quiet|calm|cosy|cozy|comfortable|suitable|right|proper|closest|nearest)"
_PLACE = rf"(?:(?:an?|the|some|any) )?(?:{_VAGUE} )*(?:place|spot|room|area|space|corner|somewhere|anywhere)(?: {_VAGUE})?"


def _lead_in(*alternatives: str) -> re.Pattern[str]:
    return re.compile(f"(?:{'|'.join(alternatives)}) ")


_TO_A_THING = _lead_in(
    rf"where (?:is|are|was|were)(?= {_THE} )",
    rf"where {_CAN} {_WHO} (?:find|see|put|leave|keep|look for|get to|go for)(?= {_THE} )",
    rf"{_WHO} (?:can|could|do|did) not (?:find|see)",
    rf"{_WANT}(?= {_THE} )",
    rf"{_WHO} (?:am|are|is) (?:looking|searching) for",
    rf"(?:{_WANT} to )?(?:go|get|come|drive|head|walk|move|run|navigate|travel) (?:over )?(?:to|into)",
    r"(?:take|bring|drive|lead|guide|walk|carry|escort|send) (?:me|us|him|her|them|it) (?:over )?(?:to|into)",
    rf"(?:show|find|get)(?: me| us)?(?= {_THE} )",
    r"(?:have a )?look (?:at|for)",
    r"(?:is|are) there|do you (?:have|see)|(?:which|what) way (?:is it )?to|the way to|this is",
    r"(?:which|what) (?:room|place) (?:has|contains|holds|is)",
    rf"{_PLACE} (?:with|(?:that|which) (?:has|contains))(?! (?:no|not) )",
    rf"inside(?= {_THE} )|an? (?:wide )?(?:photo|picture|photograph|image|view) (?:of|taken in)",
)
"""Matches the words of a question before a thing or a room, such as "where is"."""
_TO_AN_ACTIVITY = _lead_in(
    rf"(?:where|how|when) {_CAN} {_WHO}(?: best)?|(?:can|could|may) {_WHO}|where to|{_WANT} to",
    rf"{_PLACE} (?:to|where {_WHO}(?: {_CAN})?)",
)
"""Matches the words of a question before an activity, such as "where can I"."""
_POLITE = _lead_in(
    r"please,?|hello,?|hi,?|hey,?|robot,?|excuse me,?", r"(?:can|could|would|will) you(?: please)?(?= \w+ (?:me|us|to) )"
)
_PUNCTUATION = " ?.!,;"
_TRAILING = re.compile(
    r"(?: ?,? (?:please|here|there|now|somewhere|anywhere|around|nearby|in it|in a room"
    r"|in (?:a|this|the|my|our) (?:house|home|flat|building)))+$"
)
_NEGATION = _lead_in(
    rf"(?:is )?not(?: in)?(?= {_THE} )|(?:is )?not(?= [\w'-]+(?: [\w'-]+)?$)|no(?= [a-z])",
    r"(?:any|every)(?:thing|where) (?:but|except|other than)",
    r"(?:all|any|every)(?: rooms?)? (?:but|except|other than)",
    rf"{_PLACE} (?:without|with no|other than|(?:that|which) (?:is|has) (?:not|no))",
)
_NEGATED_PART = re.compile(
    r"\b(?:without|with no|except|but not|other than|apart from|never|none|nowhere|neither|nor|no(?= [a-z])"
    r"|(?<!things that are )(?<!stuff that is )not"
    r"|(?:any|every)(?:thing|where| rooms?) but)\b"
)
"""Matches words that negate what follows them. After a negation of the whole question was removed, any of them is about a
part of the question."""
_ARTICLE = re.compile(rf"^{_THE} (?=\w)")
_ROOM_TO = re.compile(r".*\broom to .* in$")
_CONTRACTIONS = {
    "’": "'", "i'm": "i am", "i'd": "i would", "we'd": "we would", "we're": "we are", "where's": "where is",
    "can't": "can not", "cannot": "can not", "won't": "will not", "n't": " not",
}  # fmt: skip

_SERVED_BY = (
    (re.compile(r"\b(?:toilet|loo|wc|lavatory)\b"), ("bathroom",)),
    (re.compile(r"\b(?:fresh air|outside|outdoors)\b"), ("garden", "balcony")),
    (re.compile(r"\b(?:movie|film)\b"), ("television",)),
    (re.compile(r"\b(?:hungry|something to eat)\b"), ("kitchen", "dining room")),
    (re.compile(r"\b(?:relax|unwind)\b"), ("sofa",)),
)
"""Patterns of words in a question, each with rooms or things that serve the expressed need."""


class Question(NamedTuple):
    """A user's question, rewritten as image captions, which an encoder compares with the images of rooms."""

    readings: tuple[Captions, ...]
    """Captions for the question taken literally, then captions for each room or thing that serves the same need. A room need
    only fit one of these readings."""
    negated: bool
    """Whether the question is negated, as in "not a kitchen": the answer is the rooms that do not fit the first reading."""


def read_question(text: str) -> Question:
    """Convert a question to captions.

    If no rule applies, the question has one reading with one caption: the text itself.

    Raises:
        LexisError: the text is blank or too long, or negates only a part of the question.
    """
    if len(text) > MAX_CHARACTERS:
        raise LexisError(f"the question has {len(text)} characters; valid: at most {MAX_CHARACTERS} characters")
    plain = _normalise(text)
    if not plain:
        raise LexisError("the question is blank; valid: some words")
    content, captions = _strip_lead_ins(plain)
    if negation := _NEGATION.match(content):
        content, captions = _ARTICLE.sub("", content[negation.end() :], count=1), captions or THING_CAPTIONS
    if part := _NEGATED_PART.search(content):
        written = _as_written(part[0], text)
        raise LexisError(
            f"the question {text.strip()!r} negates a part of itself by {written!r}, and images do not show what is "
            'absent; valid: what to look for, or "not a kitchen" for all rooms that are no kitchen'
        )
    first = _fill(captions, content) if captions else (text.strip() if content == plain else content,)
    if negation:
        return Question((first,), negated=True)
    names = [name for words, names in _SERVED_BY if words.search(content) for name in names if name not in content]
    return Question((first, *(_fill(THING_CAPTIONS, name) for name in names)), negated=False)


def _fill(captions: Captions, content: str) -> Captions:
    return tuple(caption.format(content, a=with_article(content)) for caption in captions)


def _strip_lead_ins(plain: str) -> tuple[str, Captions | None]:
    """Return the content of the question, without the words that only ask, and the templates of captions for it.

    The templates are None if the wording does not show whether the content is a thing or an activity.
    """
    captions: Captions | None = None
    rest = plain
    while lead := _POLITE.match(rest) or _TO_A_THING.match(rest) or _TO_AN_ACTIVITY.match(rest):
        if lead.re is not _POLITE:
            captions = THING_CAPTIONS if lead.re is _TO_A_THING else ACTIVITY_CAPTIONS
        rest = rest[lead.end() :]
    if captions is not ACTIVITY_CAPTIONS and (article := _ARTICLE.match(rest)):
        rest, captions = rest[article.end() :], THING_CAPTIONS
    return rest, captions


def _as_written(negation: str, text: str) -> str:
    """Return the word of a question that holds a negation: "isn't" for "not". Other negations are returned as they are."""
    return next((word for word in text.split() if negation in _normalise(word).split()), negation)


def _normalise(text: str) -> str:
    """Return the text in lower case, with single spaces, no contractions, and no punctuation or fillers at the end."""
    plain = " ".join(text.lower().split())
    for short, full in _CONTRACTIONS.items():
        plain = plain.replace(short, full)
    plain = _TRAILING.sub("", plain.rstrip(_PUNCTUATION)).rstrip(_PUNCTUATION)
    return plain.removesuffix(" in") if _ROOM_TO.match(plain) else plain
