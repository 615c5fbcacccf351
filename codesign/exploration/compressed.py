"""Bytes as a store keeps them: one frame of Zstandard, which says how long its content is."""

from __future__ import annotations

_LEVEL = 3
_MOST_BYTES = 2**30


def compressed(data: bytes) -> bytes:
    """The bytes, shorter."""
    import zstandard

    return zstandard.compress(data, _LEVEL)


def expanded(data: bytes) -> bytes:
    """What was compressed, of bounded size.

    Raises:
        ValueError: the bytes are damaged, or too many come of them.
    """
    import zstandard

    try:
        # Checked before: as many bytes are taken as the frame says.
        size = zstandard.get_frame_parameters(data).content_size
        if size > _MOST_BYTES:
            raise ValueError(
                f"a block of more than {_MOST_BYTES:,} bytes, or of a length that it does not say"
            )
        return zstandard.ZstdDecompressor().decompress(data, allow_extra_data=False)
    except zstandard.ZstdError as wrong:
        raise ValueError(str(wrong)) from wrong
