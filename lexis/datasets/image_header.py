"""The size of PNG and JPEG images, and a check that a PNG is complete, both without decoding the image."""

import zlib

_PNG = b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR"
_JPEG = b"\xff\xd8"
_FRAMES = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}
"""JPEG markers of frame headers, which contain the size."""


def image_size(content: bytes) -> tuple[int, int] | None:
    """Return width and height [px]; None unless the content is a complete, undamaged PNG or a JPEG with a frame header."""
    if content.startswith(_PNG):
        return (int.from_bytes(content[16:20]), int.from_bytes(content[20:24])) if _is_whole(content) else None
    return _jpeg_size(content) if content.startswith(_JPEG) else None


def _is_whole(content: bytes) -> bool:
    """Whether all chunks of a PNG have correct checksums and the last chunk is present.

    OpenCV would fill missing parts of a damaged image and only print a warning on stderr.
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
    """Return the size that the first frame header states; None if there is no frame header."""
    at = len(_JPEG)
    while at + 9 <= len(content) and content[at] == 0xFF:
        marker = content[at + 1]
        if marker == 0xFF:  # any number of fill bytes may precede a marker
            at += 1
            continue
        if marker in _FRAMES:
            return int.from_bytes(content[at + 7 : at + 9]), int.from_bytes(content[at + 5 : at + 7])
        at += 2 + int.from_bytes(content[at + 2 : at + 4])
    return None
