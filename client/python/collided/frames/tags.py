"""How protobuf writes a field: its tag, the bytes that follow, and the bytes. For frames, which are encoded here."""

from __future__ import annotations

from functools import lru_cache

# number << 3 | 2, of fields that have a length.
SCENE_ID = b"\x0a"  # DetectFrameRequest.scene_id
FRAME = b"\x12"  # .frame of StreamFramesRequest, DetectFrameRequest and LocalRequest
SHARED_FRAME = b"\x1a"  # LocalRequest.shared_frame
UPDATES = b"\x1a"  # Frame.updates
SPARSE, RIGID, START, POSITIONS, SHARED_POSITIONS, SHARED_START = b"\x12", b"\x1a", b"\x22", b"\x2a", b"\x32", b"\x3a"
INDICES, SHARED_INDICES = b"\x0a", b"\x12"
MATRIX, START_MATRIX = b"\x0a", b"\x12"
# number << 3, of numbers.
FRAME_ID = b"\x08"  # Frame.frame_id
MESH = b"\x08"  # MeshUpdate.mesh
OFFSET, SIZE = b"\x08", b"\x10"  # of a SharedRange


@lru_cache(256)  # sizes are the same from frame to frame
def varint(value: int) -> bytes:
    """As protobuf writes an unsigned number."""
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def field(tag: bytes, data: bytes) -> bytes:
    """A field that has a length."""
    return tag + varint(len(data)) + data
