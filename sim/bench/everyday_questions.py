"""Everyday questions to a robot at home, with the rooms that are right answers. This module contains only data.

A line is `question | room labels | kinds of things`. A room is a right answer if it has one of the labels or contains one of
the things. With `not:` before the labels, all other rooms are the right answers. The prompts of `lexis query` were chosen on
the list `TUNING`. The list `HELD_OUT` is for reported figures, and nothing may be tuned on it.
"""

from typing import NamedTuple


class EverydayQuestion(NamedTuple):
    """A question, and the condition for a room to be a right answer."""

    text: str
    labels: frozenset[str]
    kinds: frozenset[str]
    """Kinds of things; a room that contains a thing of these kinds is a right answer too."""
    negated: bool
    """Whether the question is negated: the right answers are then the rooms without any of the labels and things."""


def _table(text: str) -> tuple[EverydayQuestion, ...]:
    return tuple(_row(*map(str.strip, line.split("|"))) for line in text.strip().splitlines())


def _row(text: str, labels: str, kinds: str) -> EverydayQuestion:
    negated = labels.startswith("not:")
    return EverydayQuestion(text, _names(labels.removeprefix("not:")), _names(kinds), negated)


def _names(text: str) -> frozenset[str]:
    return frozenset(name.strip() for name in text.split(",") if name.strip())


TUNING = _table("""
I need the toilet | toilet | toilet bowl
where are the books | library | bookshelf, book pile
a quiet place to work | office | desk, double desk
where do I cook dinner | kitchen | stove
not a kitchen | not: kitchen |
I want to sleep | bedroom | double bed, single bed, bunk bed
where can I wash my hands | bathroom, toilet | washbasin, hand basin, kitchen sink, utility sink
take me to the sofa | | sofa
where do the children play | children's room | toy shelf, toy blocks, sandpit, swing
is there a bathtub | | bathtub
I am hungry | kitchen, dining room, pantry | fridge
where is the TV | | television
go to the kitchen | kitchen |
where can we eat together | dining room | dining table
show me the garden | garden |
I need to take a shower | bathroom | shower
bring me to the bedroom | bedroom |
where can I hang my jacket | entrance hall | coat hooks, wardrobe
where do we keep the toys | children's room | toy shelf, toy blocks, teddy bear
how do I get upstairs | stairs |
can I watch a movie somewhere | living room | television
where should I brush my teeth | bathroom | washbasin
I would like some fresh air | garden, balcony |
find me a place to sit outside | garden, balcony | garden bench, garden chair
which room has a bed in it | bedroom | double bed, single bed, bunk bed
where do I leave my shoes | entrance hall | shoe rack, shoes
I'm looking for the fridge | | fridge
please go to the dining table | | dining table
anything but the bathroom | not: bathroom |
where can I relax after work | living room, garden | sofa
where is the photocopier | print room | photocopier
take me to the laboratory | laboratory |
I need to lift weights | gym | weight bench, weight rack
where can I park the car | garage |
""")
"""Questions on which the prompts of `lexis query` were chosen."""

HELD_OUT = _table("""
I have to use the restroom | toilet | toilet bowl
where can I find something to read | library | bookshelf, book pile, magazines
somewhere calm to study | office | desk, small desk
where is dinner made | kitchen | stove
not the garden | not: garden |
I'm tired | bedroom | double bed, single bed, bunk bed, sofa
my hands are dirty | bathroom, toilet | washbasin, hand basin, kitchen sink, utility sink
drive to the couch | | sofa
let the kids play | children's room | toy shelf, toy blocks, sandpit, swing
where could I have a bath | bathroom | bathtub
make me a cup of coffee | kitchen | kettle
where's the television | | television
I want to go to the living room | living room |
where will the guests have lunch | dining room | dining table
the lawn needs mowing | garden | lawn mower
I need a towel | bathroom | towel rail
which way to the master bedroom | bedroom |
I just came in, where does my coat go | entrance hall | coat hooks, wardrobe
where did I put the teddy bear | | teddy bear
I want to go to the upper floor | stairs |
where can I lie down for a nap | bedroom, living room | double bed, single bed, bunk bed, sofa
wash the dishes | kitchen | dishwasher, kitchen sink
I'd love to sit in the sun | garden, balcony | sun lounger
water the flowers | garden | flower bed
do you see a wardrobe anywhere | | wardrobe
where do we keep the pots and pans | kitchen | pan rail, pot
is there an oven here | kitchen | stove
have a look at the dining area | dining room | dining table
a room without a bed | not: | double bed, single bed, bunk bed, cot
who put the baby to sleep, and where | children's room | cot, single bed, bunk bed, double bed
where is the swimming pool | swimming pool |
is there a microscope | laboratory | microscope
drive me to the gym | gym | treadmill, weight bench, weight rack
where do pupils learn | classroom | school desk, blackboard
""")
"""Questions for reported figures only; nothing may be tuned on them."""
