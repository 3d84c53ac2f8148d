"""Contacts that stay on the device."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from collided.contacts.columns import COLUMNS, Part, read_chunk
from collided.errors import DataLoss
from collided.gpu.arrays import DeviceArray
from collided.gpu.memory import OutputMemory
from collided.v1 import contact_pb2, frame_pb2

_NAMES = {contact_pb2.CONTACT_KIND_VERTEX_TRIANGLE: "vt", contact_pb2.CONTACT_KIND_EDGE_EDGE: "ee",
          contact_pb2.CONTACT_KIND_TRIANGLE_TRIANGLE: "tt"}


@dataclass(eq=False)
class KindOnDevice:
    """Contacts of one kind, a row each; columns that were not sent are None. Types are those of Contacts."""

    count: int = 0
    elements: DeviceArray | None = None
    stencils: DeviceArray | None = None
    toi: DeviceArray | None = None
    distance: DeviceArray | None = None
    weights: DeviceArray | None = None
    normals: DeviceArray | None = None
    flags: DeviceArray | None = None

    def __len__(self) -> int:
        return self.count


@dataclass(eq=False)
class DeviceContacts:
    """A frame's contacts: the first of each kind on the device, valid until as many more frames were sent as the window has.

    on_host: those that had no room there, after them, in the same order; `output_bytes` makes room.
    """

    frame_id: int
    vt: KindOnDevice = field(default_factory=KindOnDevice)
    ee: KindOnDevice = field(default_factory=KindOnDevice)
    tt: KindOnDevice = field(default_factory=KindOnDevice)
    on_host: list[Part] = field(default_factory=list)
    done: frame_pb2.FrameDone = field(default_factory=frame_pb2.FrameDone)

    def add(self, chunk: contact_pb2.ContactChunk, memory: OutputMemory) -> None:
        """A chunk of the daemon's."""
        if chunk.kind not in _NAMES:
            raise DataLoss(f"contacts.kind is {chunk.kind}, which this client does not know")
        if not chunk.HasField("shared"):
            self.on_host.append(read_chunk(chunk))
            return
        arrays = {name: _array(chunk, name, memory) for name in COLUMNS}
        setattr(self, _NAMES[chunk.kind], KindOnDevice(chunk.count, **arrays))


def _array(chunk: contact_pb2.ContactChunk, name: str, memory: OutputMemory) -> DeviceArray | None:
    column, place = COLUMNS[name], getattr(chunk.shared, name)
    needed = chunk.count * column.dtype.itemsize * int(np.prod(column.shape, dtype=int))
    if place.size == 0:
        return None
    room = memory.output_bytes
    if place.size != needed or place.offset > room or place.size > room - place.offset:
        raise DataLoss(f"contacts.shared.{name} has {place.size} bytes at offset {place.offset} for {chunk.count} contacts; it "
                       f"needs {needed}, and the output region has {room}")
    return DeviceArray(memory.address + place.offset, (chunk.count, *column.shape), column.dtype, memory.cuda, memory)
