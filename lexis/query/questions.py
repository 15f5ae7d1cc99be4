"""The content of a question, apart from its wording: "where can I cook?" and "a place to cook" are one question.

An encoder that reads captions takes every word for a part of the picture, so that "I need the toilet" resembles neither a
toilet nor its room. The words that only ask are therefore taken off, and what is left is put into captions again.
"""

import re
from typing import NamedTuple, TypeAlias

from lexis.encoder.prompts import with_article
from lexis.errors import LexisError

MAX_CHARACTERS = 500
"""Longest question that is read: the time to read one grows with the square of its length."""
THING_CAPTIONS = ("{}", "{a}", "a photo of {a}", "a view of {a}")
"""Around a thing or the name of a room, {a} with its article."""
ACTIVITY_CAPTIONS = (
    "{}", "a place to {}", "where can I {}", "a room to {} in", "where to {}", "I want to {}", "a room where people {}",
)  # fmt: skip
"""Around what somebody does."""

Captions: TypeAlias = tuple[str, ...]
"""Texts that say the same, of which the mean embedding counts."""

_THE = r"(?:the|a|an|my|our|your|his|her|their|some|any|this|that)"
_WHO = r"(?:i|we|you|one|people|they|somebody|someone|anybody|anyone)"
_CAN = r"(?:can|could|do|does|did|should|shall|may|might|must|would|will)"
_WANT = rf"{_WHO} (?:really |just |all )?(?:want|need|have|has|wish|got|would like|would love)"
_VAGUE = r"(?:good|best|better|nice|quiet|calm|cosy|cozy|comfortable|suitable|right|proper|closest|nearest)"
_PLACE = rf"(?:(?:an?|the|some|any) )?(?:{_VAGUE} )*(?:place|spot|room|area|space|corner|somewhere|anywhere)(?: {_VAGUE})?"


def _leads(*alternatives: str) -> re.Pattern[str]:
    return re.compile(f"(?:{'|'.join(alternatives)}) ")


_TO_A_THING = _leads(
    rf"where (?:is|are|was|were)(?= {_THE} )",
    rf"where {_CAN} {_WHO} (?:find|see|put|leave|keep|look for|get to|go for)(?= {_THE} )",
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
"""Words that stand before a thing or a room."""
_TO_AN_ACTIVITY = _leads(
    rf"(?:where|how|when) {_CAN} {_WHO}(?: best)?|(?:can|could|may) {_WHO}|where to|{_WANT} to",
    rf"{_PLACE} (?:to|where {_WHO}(?: {_CAN})?)",
)
"""Words that stand before an activity."""
_POLITE = _leads(
    r"please,?|hello,?|hi,?|hey,?|robot,?|excuse me,?", r"(?:can|could|would|will) you(?: please)?(?= \w+ (?:me|us|to) )"
)
_TRAILING = re.compile(
    r"(?:,? (?:please|here|there|now|somewhere|anywhere|around|nearby|in it|in a room"
    r"|in (?:a|this|the|my|our) (?:house|home|flat|building)))+$"
)
_NEGATION = _leads(
    rf"not(?: in)?(?= {_THE} )|not(?= \w+$)",
    r"(?:any|every)(?:thing|where) (?:but|except|other than)",
    r"(?:all|any|every)(?: rooms?)? (?:but|except|other than)",
    rf"{_PLACE} (?:without|with no|other than|(?:that|which) (?:is|has) (?:not|no))",
)
_NEGATED_PART = re.compile(r"\b(?:without|with no|except|but not|not(?= (?:an?|the|in|my|our) ))\b")
_ARTICLE = re.compile(rf"^{_THE} (?=\w)")
_ROOM_TO = re.compile(r".*\broom to .* in$")
_SHORT = {"’": "'", "i'm": "i am", "i'd": "i would", "we'd": "we would", "we're": "we are", "where's": "where is"}

_SERVED_BY = (
    (re.compile(r"\b(?:toilet|loo|wc|lavatory)\b"), ("bathroom",)),
    (re.compile(r"\b(?:fresh air|outside|outdoors)\b"), ("garden", "balcony")),
    (re.compile(r"\b(?:movie|film)\b"), ("television",)),
    (re.compile(r"\b(?:hungry|something to eat)\b"), ("kitchen", "dining room")),
    (re.compile(r"\b(?:relax|unwind)\b"), ("sofa",)),
)
"""Words, and the rooms and things that also serve whoever says them."""


class Question(NamedTuple):
    """A question as an encoder shall read it."""

    readings: tuple[Captions, ...]
    """Meanings of the question: first the literal one, then those that serve the same need. One that fits is enough."""
    negated: bool
    """Whether it asks for what does not fit the first of them."""


def read_question(text: str) -> Question:
    """The content of a question, as captions.

    Words that no rule knows stay as they are: one reading of one caption, the text itself.

    Raises:
        LexisError: the text is blank or too long, or negates only a part of what it asks for.
    """
    if len(text) > MAX_CHARACTERS:
        raise LexisError(f"the question has {len(text)} characters; valid: at most {MAX_CHARACTERS} characters")
    plain = _plain(text)
    if not plain:
        raise LexisError("the question is blank; valid: some words")
    content, captions = _peeled(plain)
    if negation := _NEGATION.match(content):
        content, captions = _ARTICLE.sub("", content[negation.end() :], count=1), THING_CAPTIONS
    if part := _NEGATED_PART.search(content):
        raise LexisError(
            f"the question {text.strip()!r} says {part[0]!r} of a part of it, which images do not show; "
            'valid: what to look for, or "not a kitchen" for all rooms that are none'
        )
    first = _filled(captions, content) if captions else (text.strip() if content == plain else content,)
    if negation:
        return Question((first,), negated=True)
    names = [name for words, names in _SERVED_BY if words.search(content) for name in names if name not in content]
    return Question((first, *(_filled(THING_CAPTIONS, name) for name in names)), negated=False)


def _filled(captions: Captions, content: str) -> Captions:
    return tuple(caption.format(content, a=with_article(content)) for caption in captions)


def _peeled(plain: str) -> tuple[str, Captions | None]:
    """The rest without the words that only ask, and its captions; None where nothing tells a thing from an activity."""
    captions: Captions | None = None
    rest = plain
    while lead := _POLITE.match(rest) or _TO_A_THING.match(rest) or _TO_AN_ACTIVITY.match(rest):
        if lead.re is not _POLITE:
            captions = THING_CAPTIONS if lead.re is _TO_A_THING else ACTIVITY_CAPTIONS
        rest = rest[lead.end() :]
    if captions is not ACTIVITY_CAPTIONS and (article := _ARTICLE.match(rest)):
        rest, captions = rest[article.end() :], THING_CAPTIONS
    return rest, captions


def _plain(text: str) -> str:
    """Small letters, single spaces, no punctuation at the end, no short forms."""
    plain = " ".join(text.lower().split())
    for short, full in _SHORT.items():
        plain = plain.replace(short, full)
    plain = _TRAILING.sub("", plain.rstrip(" ?.!,;"))
    return plain.removesuffix(" in") if _ROOM_TO.match(plain) else plain
