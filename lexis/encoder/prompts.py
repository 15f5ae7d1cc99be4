"""Prompts for room names: captions such as "a photo of a kitchen", which CLIP understands better than bare nouns."""

from collections.abc import Sequence

from lexis.errors import EncoderError

TEMPLATES = ("a photo of {}", "a picture of {}", "{} in a house", "a view of {}", "inside {}")
"""Prompts for a room name; {} stands for the name with its article. Their embeddings are averaged, so that no single wording
decides."""

_CONSONANT_SOUND = ("uni", "use", "uti", "eu", "one ")
_VOWEL_SOUND = ("hour", "honour", "honor")


def prompts(name: str, templates: Sequence[str] = TEMPLATES) -> tuple[str, ...]:
    """Return the prompts for a room name. The first prompt for "office" is "a photo of an office"."""
    return tuple(template.format(with_article(name)) for template in templates)


def check_template(template: str) -> None:
    """Raise EncoderError unless the template has one {} and no other braces."""
    before, hole, after = template.partition("{}")
    if not hole or set("{}") & set(before + after):
        raise EncoderError(f'prompt template {template!r} is unusable; valid: one {{}} in it, as in "a photo of {{}}"')


def with_article(name: str) -> str:
    """Return the name with its article: "a kitchen", "an office", "a utility room", and plain "stairs"."""
    name = name.strip()
    lowered = name.lower()
    if lowered.endswith("s") and not lowered.endswith(("ss", "'s", "us")):
        return name
    vowel = lowered[0] in "aeiou" and not lowered.startswith(_CONSONANT_SOUND)
    return f"{'an' if vowel or lowered.startswith(_VOWEL_SOUND) else 'a'} {name}"
