"""Memory that a client shares with the daemon on its host: a sealed memfd."""

from __future__ import annotations

import fcntl
import mmap
import os
from dataclasses import dataclass

import numpy as np

from collided.errors import ResourceExhausted
from collided.v1 import scene_pb2

PAGE, ALIGNMENT = 4096, 64
MAX_PACKET_BYTES = 64 << 10
_UPDATE_BYTES = 256  # of each mesh: its update's message, and the alignment of its arrays
_MAX_OUTPUT_BYTES, _MAX_EDIT_BYTES = 1 << 30, 256 << 20
_SEALS = fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL
_POSITION_BYTES = {scene_pb2.POSITION_FORMAT_F32: 12, scene_pb2.POSITION_FORMAT_F64: 24, scene_pb2.POSITION_FORMAT_Q16: 6}


@dataclass(frozen=True)
class RegionLayout:
    """How the memory is divided: input for each frame of the window, then contacts of all frames."""

    window: int
    frame_bytes: int
    output_bytes: int

    @property
    def input_bytes(self) -> int:
        return self.window * self.frame_bytes


def region_layout(spec: scene_pb2.SceneSpec, window: int, output_bytes: int, edit_bytes: int) -> RegionLayout:
    """Room for any frame of the scene."""
    positions = 1 if spec.mode == scene_pb2.DETECTION_MODE_DCD else 2
    vertices = sum(mesh.vertex_count for mesh in spec.meshes)
    message = MAX_PACKET_BYTES + len(spec.meshes) * _UPDATE_BYTES
    frame = _whole_pages(vertices * (positions * _POSITION_BYTES[spec.position_format] + 4) + message)
    edit = min(_whole_pages(edit_bytes), _MAX_EDIT_BYTES // window // PAGE * PAGE)
    output = min(_whole_pages(output_bytes), _MAX_OUTPUT_BYTES // window // PAGE * PAGE)
    return RegionLayout(window, frame + edit, window * output)


def _whole_pages(size: int) -> int:
    return -(-size // PAGE) * PAGE


class Region:
    """Neither side can shrink or grow it. Pages are allocated on first touch; unmapped once nothing views them."""

    def __init__(self, size: int) -> None:
        try:
            self._file = open(os.memfd_create("collided", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING), "r+b", buffering=0)
            os.ftruncate(self.file, size)
            fcntl.fcntl(self.file, fcntl.F_ADD_SEALS, _SEALS)
            self.bytes = np.frombuffer(mmap.mmap(self.file, size), np.uint8)
        except OSError as error:
            raise ResourceExhausted(f"no shared memory of {size} bytes: {error.strerror}") from None

    @property
    def file(self) -> int:
        """The descriptor to hand over."""
        return self._file.fileno()

    def close(self) -> None:
        self._file.close()
        self.bytes = self.bytes[:0]
