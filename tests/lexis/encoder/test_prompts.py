import pytest

from lexis.encoder.prompts import TEMPLATES, prompts, with_article


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("kitchen", "a kitchen"),
        ("office", "an office"),
        ("open-plan office", "an open-plan office"),
        ("utility room", "a utility room"),
        ("stairs", "stairs"),
        ("children's room", "a children's room"),
        ("fitness", "a fitness"),
    ],
)
def test_the_article_follows_the_sound_and_plurals_take_none(name, expected):
    assert with_article(name) == expected


def test_every_prompt_holds_the_name():
    assert len(prompts("lobby")) == len(TEMPLATES)
    assert all("a lobby" in prompt for prompt in prompts("lobby"))
