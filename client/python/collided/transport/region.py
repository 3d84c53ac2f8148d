"""Memory that a client shares with the daemon on its host: a sealed memfd."""

from __future__ import annotations

import mmap
import os
import sys
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from collided.errors import DataLoss, FailedPrecondition, ResourceExhausted
from collided.positions import format_row
from collided.transport.peer import NEEDS_LINUX
from collided.v1 import local_pb2, scene_pb2

PAGE, ALIGNMENT = 4096, 64  # bytes
MAX_PACKET_BYTES = 64 << 10
_UPDATE_BYTES = 256  # of each mesh: its update's message, and the alignment of its arrays
_MAX_OUTPUT_BYTES, _MAX_EDIT_BYTES = 1 << 30, 256 << 20


@dataclass(frozen=True)
class RegionLayout:
    """How the memory is divided: input for each frame of the window, positions that stay there, then contacts of all frames.

    lasting, lasting_bytes: how many frames' positions may stay, and bytes of each.
    """

    window: int
    frame_bytes: int
    lasting: int
    lasting_bytes: int
    output_bytes: int

    @property
    def lasting_at(self) -> int:
        return self.window * self.frame_bytes

    @property
    def input_bytes(self) -> int:
        return self.lasting_at + self.lasting * self.lasting_bytes


class Part(NamedTuple):
    """A frame's part of the input. bytes: if it is this frame's until no array views them any more."""

    start: int
    size: int
    bytes: np.ndarray | None = None


def region_layout(scene: scene_pb2.Scene, window: int, output_bytes: int, edit_bytes: int,
                  lasting: int = 0) -> RegionLayout:
    """Room for any frame of the scene, or of the set, and for the positions of `lasting` frames to stay."""
    spec, worlds = scene.spec, max(scene.worlds, 1)
    positions = 1 if spec.mode == scene_pb2.DETECTION_MODE_DCD else 2
    vertices = worlds * sum(mesh.vertex_count for mesh in spec.meshes)
    message = MAX_PACKET_BYTES + worlds * len(spec.meshes) * _UPDATE_BYTES
    form = format_row(spec.position_format)
    if form is None:
        raise DataLoss(f"spec.position_format is {spec.position_format}, which this client does not know")
    position = form.position_bytes
    frame = whole_pages(vertices * (positions * position + 4) + message)
    all_positions = whole_pages(vertices * position + len(spec.meshes) * ALIGNMENT)
    edit = min(whole_pages(edit_bytes), _MAX_EDIT_BYTES // window // PAGE * PAGE)
    output = min(whole_pages(output_bytes), _MAX_OUTPUT_BYTES // window // PAGE * PAGE)
    return RegionLayout(window, frame + edit, lasting, all_positions, window * output)


def whole_pages(size: int) -> int:
    return -(-size // PAGE) * PAGE


class Memory(Protocol):
    """What client and daemon share: a Region, or memory of a GPU."""

    layout: RegionLayout

    def describe(self, opening: local_pb2.LocalOpen) -> list[int]: ...

    def part(self, frame: int) -> Part: ...

    def lasting_part(self, size: int) -> Part | None: ...

    def write(self, start: int, array: Any) -> None: ...

    def output(self, start: int, size: int) -> memoryview: ...

    def close(self) -> None: ...


def _sealed_file(size: int) -> int:
    """Returns the descriptor of a memfd, whose size is final."""
    if sys.platform != "linux":
        raise FailedPrecondition(NEEDS_LINUX, field="transport")
    import fcntl  # not on Windows

    file = os.memfd_create("collided", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
    try:
        os.ftruncate(file, size)
        fcntl.fcntl(file, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL)
    except BaseException:
        os.close(file)
        raise
    return file


class Region:
    """Neither side can shrink or grow it. Pages are allocated on first touch; unmapped once nothing views them."""

    def __init__(self, layout: RegionLayout) -> None:
        self.layout = layout
        size = layout.input_bytes + layout.output_bytes
        try:
            self._file = open(_sealed_file(size), "r+b", buffering=0)
            self._bytes = memoryview(mmap.mmap(self._file.fileno(), size))
        except (OSError, OverflowError, ValueError) as error:  # of sizes that no mapping can have
            why = error.strerror if isinstance(error, OSError) else error
            raise ResourceExhausted(f"no shared memory of {size} bytes: {why}") from None
        self._lasting: list[Callable[[], object]] = [lambda: None] * layout.lasting  # what each part is taken by

    def describe(self, opening: local_pb2.LocalOpen) -> list[int]:
        """Tells the daemon of it. The descriptors to hand over."""
        opening.input_bytes, opening.output_bytes = self.layout.input_bytes, self.layout.output_bytes
        return [self._file.fileno()]

    def part(self, frame: int) -> Part:
        """For a frame, until it is answered."""
        return Part(frame % self.layout.window * self.layout.frame_bytes, self.layout.frame_bytes)

    def lasting_part(self, size: int) -> Part | None:
        """A part of so many bytes that nothing views any more; None if there is none."""
        room = self.layout.lasting_bytes
        for index, taken_by in enumerate(self._lasting):
            if size <= room and taken_by() is None:
                start = self.layout.lasting_at + index * room
                array = np.frombuffer(self._bytes, np.uint8, room, start)  # which numpy keeps as the base of all views of it
                self._lasting[index] = weakref.ref(array)
                return Part(start, room, array)
        return None

    def write(self, start: int, array: Any) -> None:
        self._bytes[start:start + array.nbytes] = array.reshape(-1).view(np.uint8).data

    def output(self, start: int, size: int) -> memoryview:
        """Bytes of the output."""
        room = self.layout.output_bytes
        if start > room or size > room - start:
            raise DataLoss(f"contacts.shared names {size} bytes at offset {start}; the output region has {room}")
        at = self.layout.input_bytes + start
        return self._bytes[at:at + size]

    def close(self) -> None:
        self._file.close()
        self._bytes = memoryview(b"")
