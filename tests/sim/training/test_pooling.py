"""Pooled evidence in training: the rooms that frames belong to, and the loss of several views of a room together."""

import numpy as np
import torch
from scipy.special import log_softmax, softmax

from lexis.config import SightConfig
from sim.training.pooling import RoomFrames, pooled_loss
from worlds.labels import ROOM_LABELS

HOUSES = np.array([7, 7, 7, 7, 3, 3, 3])
LABELS = np.array([2, 5, 2, 9, 5, 5, 1])


def test_every_frame_belongs_to_one_room_of_its_house_and_label():
    rooms = RoomFrames.of(HOUSES, LABELS)
    assert sorted(np.concatenate(rooms.frames)) == list(range(len(HOUSES)))
    for frames, label, absent in zip(rooms.frames, rooms.labels, rooms.absent, strict=True):
        assert set(LABELS[frames]) == {label} and len(set(HOUSES[frames])) == 1
        assert set(np.flatnonzero(~absent)) == set(LABELS[HOUSES[frames[0]] == HOUSES])
    assert len(rooms.frames) == 5 and rooms.absent.shape == (5, len(ROOM_LABELS))


def test_views_are_drawn_of_their_own_room_and_no_room_twice():
    rooms = RoomFrames.of(HOUSES, LABELS)
    for asked in (2, 5, 64):
        chosen, views = rooms.drawn(asked, 8, np.random.default_rng(asked))
        assert len(set(chosen.tolist())) == len(chosen) == min(asked, 5) and views.shape == (len(chosen), 8)
        assert all(set(drawn) <= set(rooms.frames[room]) for room, drawn in zip(chosen, views.tolist(), strict=True))


def test_the_losses_are_cross_entropies_among_the_labels_of_the_house():
    """Compared with a softmax over the labels that are present, one room at a time."""
    rng = np.random.default_rng(0)
    logits, absent = rng.normal(0.0, 3.0, (6, 4, 10)), rng.random((6, 10)) < 0.4
    own = rng.integers(10, size=6)
    absent[np.arange(6), own] = False
    alone, together = [], []
    for views, never, label in zip(logits, absent, own, strict=True):
        here = np.searchsorted(np.flatnonzero(~never), label)
        present = views[:, ~never]
        alone.extend(-log_softmax(present, axis=1)[:, here])
        evidence = np.log(softmax(present, axis=1) + SightConfig().least_probability).mean(axis=0)
        together.append(-log_softmax(evidence)[here])
    got = pooled_loss(torch.from_numpy(logits), absent, own)
    np.testing.assert_allclose([float(part) for part in got], [np.mean(alone), np.mean(together)], rtol=1e-9)


def test_a_label_that_the_house_lacks_has_no_influence():
    rng = np.random.default_rng(1)
    logits, absent, own = rng.normal(size=(3, 4, 5)), np.zeros((3, 5), bool), np.array([0, 1, 2])
    absent[:, 4] = True
    other = logits.copy()
    other[..., 4] = 50.0
    for one, two in zip(*(pooled_loss(torch.from_numpy(each), absent, own) for each in (logits, other)), strict=True):
        assert float(one) == float(two)


def test_views_that_look_like_another_room_count_together_with_the_others():
    """Most views of a large room may look like a small one; one sure view then outweighs three unsure ones."""
    logits = torch.tensor([[[0.4, 0.0]] * 3 + [[-4.0, 0.0]]], dtype=torch.float64, requires_grad=True)
    _, together = pooled_loss(logits, np.zeros((1, 2), bool), np.array([1]))
    together.backward()
    single = torch.log_softmax(logits.detach(), dim=2).mean(dim=1)
    assert single.argmax() == 1 and (logits.detach().argmax(dim=2) == 0).sum() == 3
    assert (logits.grad[0, :, 1] < 0).all() and together.item() < np.log(2.0)
