"""Memory that a client shares with the daemon on its host: a sealed memfd."""

from __future__ import annotations

import fcntl
import mmap
import os
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from collided.errors import DataLoss, ResourceExhausted
from collided.v1 import local_pb2, scene_pb2

PAGE, ALIGNMENT = 4096, 64  # bytes
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
    frame = whole_pages(vertices * (positions * _POSITION_BYTES[spec.position_format] + 4) + message)
    edit = min(whole_pages(edit_bytes), _MAX_EDIT_BYTES // window // PAGE * PAGE)
    output = min(whole_pages(output_bytes), _MAX_OUTPUT_BYTES // window // PAGE * PAGE)
    return RegionLayout(window, frame + edit, window * output)


def whole_pages(size: int) -> int:
    return -(-size // PAGE) * PAGE


class Memory(Protocol):
    """What client and daemon share: a Region, or memory of a GPU."""

    layout: RegionLayout

    def describe(self, opening: local_pb2.LocalOpen) -> list[int]: ...

    def start_of(self, frame: int) -> int: ...

    def write(self, start: int, array: Any) -> None: ...

    def output(self, start: int, size: int) -> memoryview: ...

    def close(self) -> None: ...


class Region:
    """Neither side can shrink or grow it. Pages are allocated on first touch; unmapped once nothing views them."""

    def __init__(self, layout: RegionLayout) -> None:
        self.layout = layout
        size = layout.input_bytes + layout.output_bytes
        try:
            self._file = open(os.memfd_create("collided", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING), "r+b", buffering=0)
            os.ftruncate(self._file.fileno(), size)
            fcntl.fcntl(self._file.fileno(), fcntl.F_ADD_SEALS, _SEALS)
            self._bytes = np.frombuffer(mmap.mmap(self._file.fileno(), size), np.uint8)
        except OSError as error:
            raise ResourceExhausted(f"no shared memory of {size} bytes: {error.strerror}") from None

    def describe(self, opening: local_pb2.LocalOpen) -> list[int]:
        """Tells the daemon of it. The descriptors to hand over."""
        opening.input_bytes, opening.output_bytes = self.layout.input_bytes, self.layout.output_bytes
        return [self._file.fileno()]

    def start_of(self, frame: int) -> int:
        """Where a frame's part of the input begins."""
        return frame % self.layout.window * self.layout.frame_bytes

    def write(self, start: int, array: Any) -> None:
        np.copyto(self._bytes[start:start + array.nbytes], array.reshape(-1).view(np.uint8))

    def output(self, start: int, size: int) -> memoryview:
        """Bytes of the output."""
        room = self.layout.output_bytes
        if start > room or size > room - start:
            raise DataLoss(f"contacts.shared names {size} bytes at offset {start}; the output region has {room}")
        at = self.layout.input_bytes + start
        return self._bytes[at:at + size].data

    def close(self) -> None:
        self._file.close()
        self._bytes = np.empty(0, np.uint8)
