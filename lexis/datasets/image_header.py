"""Headers of PNG and JPEG images: size and completeness, found without decoding the image."""

import zlib

_PNG = b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR"
_JPEG = b"\xff\xd8"
_FRAMES = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}
"""Markers of JPEG that begin a frame, and so state its size."""


def image_size(content: bytes) -> tuple[int, int] | None:
    """Width and height [px]; None for what is neither PNG nor JPEG, or is damaged as far as a PNG's checksums tell."""
    if content.startswith(_PNG):
        return (int.from_bytes(content[16:20]), int.from_bytes(content[20:24])) if _is_whole(content) else None
    return _jpeg_size(content) if content.startswith(_JPEG) else None


def _is_whole(content: bytes) -> bool:
    """Whether the chunks of a PNG have the checksums that they state, and the last one is there.

    OpenCV fills in what is missing, and complains on stderr.
    """
    at = 8
    while at + 12 <= len(content):
        end = at + 8 + int.from_bytes(content[at : at + 4])
        if zlib.crc32(content[at + 4 : end]) != int.from_bytes(content[end : end + 4]):
            return False
        if content[at + 4 : at + 8] == b"IEND":
            return True
        at = end + 4
    return False


def _jpeg_size(content: bytes) -> tuple[int, int] | None:
    """The size in the first frame, which segments of stated length come before."""
    at = len(_JPEG)
    while at + 9 <= len(content) and content[at] == 0xFF:
        marker = content[at + 1]
        if marker == 0xFF:  # a marker may be preceded by any number of these
            at += 1
            continue
        if marker in _FRAMES:
            return int.from_bytes(content[at + 7 : at + 9]), int.from_bytes(content[at + 5 : at + 7])
        at += 2 + int.from_bytes(content[at + 2 : at + 4])
    return None
