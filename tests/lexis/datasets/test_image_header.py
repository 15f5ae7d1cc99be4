"""The size stated in the header of a PNG or JPEG equals the size of the decoded image."""

import zlib

import cv2
import numpy as np
import pytest

from lexis.datasets.image_header import image_size


def encoded(suffix, *options):
    return cv2.imencode(suffix, np.random.default_rng(1).integers(0, 256, (24, 32, 3), dtype=np.uint8), options)[1].tobytes()


@pytest.mark.parametrize("content", [encoded(".png"), encoded(".jpg"), encoded(".jpg", cv2.IMWRITE_JPEG_PROGRESSIVE, 1)])
def test_the_size_is_that_of_the_decoded_image(content):
    assert image_size(content) == (32, 24)
    assert image_size(content[:2] + b"\xff" * (content[0] == 0xFF) + content[2:]) == (32, 24)  # fill bytes of JPEG
    assert image_size(content[:12]) is None


@pytest.mark.parametrize("content", [b"", b"GIF89a", b"\xff\xd8", b"\xff\xd8\x00\x01", encoded(".bmp"), encoded(".webp")])
def test_anything_else_has_none(content):
    assert image_size(content) is None


@pytest.mark.parametrize("at", [20, 60, 500, -5])
def test_a_png_of_which_a_bit_is_wrong_or_the_end_is_missing_is_damaged(at):
    content = bytearray(encoded(".png"))
    assert image_size(bytes(content[:at])) is None
    content[at] ^= 4
    assert image_size(bytes(content)) is None


def test_a_png_may_state_more_than_it_holds():
    head = b"IHDR" + (40_000).to_bytes(4) * 2 + b"\x08\x02\x00\x00\x00"
    content = encoded(".png")
    content = content[:12] + head + zlib.crc32(head).to_bytes(4) + content[33:]
    assert image_size(content) == (40_000, 40_000)
