"""Contacts that stay on the device."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Optional

from collided.columns import COLUMNS, HasColumns
from collided.contacts import Contacts
from collided.contacts.columns import Part, read_chunk
from collided.contacts.pairs import MeshPairs
from collided.errors import DataLoss
from collided.frames.advance import Shortened
from collided.gpu.arrays import DeviceArray
from collided.gpu.memory import OutputMemory
from collided.kinds import KINDS, HasKinds, Kind
from collided.v1 import contact_pb2, frame_pb2


@dataclass(eq=False)
class KindOnDevice(HasColumns[Optional[DeviceArray]]):
    """Contacts of one kind, a row each; columns that were not sent are None. Types are those of Contacts."""

    count: int = 0
    arrays: Mapping[str, DeviceArray] = field(default_factory=dict)

    def _column(self, name: str) -> DeviceArray | None:
        return self.arrays.get(name)

    def __len__(self) -> int:
        return self.count


@dataclass(eq=False)
class DeviceContacts(HasKinds[KindOnDevice]):
    """A frame's contacts: the first of each kind on the device, valid until as many more frames were sent as the window has.

    on_host: those that had no room there, after them, in the same order; `output_bytes` makes room.
    shortened, limits: as of `Contacts`, in host memory; `limits` is there once the frame is answered, and has no `points`.
    pairs: as of `Contacts`, in host memory; None in frames without them.
    """

    frame_id: int
    on_device: dict[Kind, KindOnDevice] = field(default_factory=dict)
    on_host: list[Part] = field(default_factory=list)
    done: frame_pb2.FrameDone = field(default_factory=frame_pb2.FrameDone)
    shortened: Shortened = Shortened()
    pairs: Optional[MeshPairs] = None
    limits: Contacts = field(init=False)

    def add(self, chunk: contact_pb2.ContactChunk, memory: OutputMemory) -> None:
        """A chunk of the daemon's."""
        if chunk.kind not in KINDS:
            raise DataLoss(f"contacts.kind is {chunk.kind}, which this client does not know")
        if not chunk.HasField("shared"):
            self.on_host.append(read_chunk(chunk))
            return
        arrays = {name: array for name in COLUMNS if (array := _array(chunk, name, memory)) is not None}
        self.on_device[KINDS[chunk.kind]] = KindOnDevice(chunk.count, arrays)

    def _of_kind(self, kind: Kind) -> KindOnDevice:
        return self.on_device.get(kind, KindOnDevice())


def _array(chunk: contact_pb2.ContactChunk, name: str, memory: OutputMemory) -> DeviceArray | None:
    column, place = COLUMNS[name], getattr(chunk.shared, name)
    needed = chunk.count * column.width
    if place.size == 0:
        return None
    room = memory.output_bytes
    if place.size != needed or place.offset > room or place.size > room - place.offset:
        raise DataLoss(f"contacts.shared.{name} has {place.size} bytes at offset {place.offset} for {chunk.count} contacts; it "
                       f"needs {needed}, and the output region has {room}")
    return DeviceArray(memory.address + place.offset, (chunk.count, *column.shape), column.dtype, memory.cuda, memory)
