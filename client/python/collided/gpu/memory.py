"""Memory of the scene's GPU that a session shares with the daemon: contacts of each frame in flight, then positions."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from collided.errors import DataLoss
from collided.frames.updates import Incoming
from collided.gpu.cuda import Cuda
from collided.transport.region import Part, RegionLayout
from collided.v1 import local_pb2


class OutputMemory(Protocol):
    """Memory of the device that holds contacts."""

    cuda: Cuda
    address: int
    output_bytes: int


class DeviceMemory:
    """Allocated here, opened by the daemon."""

    def __init__(self, cuda: Cuda, layout: RegionLayout) -> None:
        self.cuda, self.layout = cuda, layout
        self.output_bytes = layout.output_bytes
        self.address = cuda.allocate(layout.output_bytes + layout.input_bytes)

    def describe(self, opening: local_pb2.LocalOpen) -> list[int]:
        """Tells the daemon of it. No descriptor goes with that."""
        handle = self.cuda.handle(self.address)
        opening.cuda_ipc_handle = opening.output_cuda_ipc_handle = handle
        opening.output_bytes = self.layout.output_bytes
        return []

    def part(self, frame: int) -> Part:
        """For a frame, until it is answered."""
        start = self.layout.output_bytes + frame % self.layout.window * self.layout.frame_bytes
        return Part(start, self.layout.frame_bytes)

    def lasting_part(self, size: int) -> Part | None:
        """None: positions are not needed once they were sent."""
        return None

    def write(self, start: int, array: Any) -> None:
        """Complete once this returns."""
        if isinstance(array, np.ndarray):
            self.cuda.copy(self.address + start, array.ctypes.data, array.nbytes)
        else:
            assert isinstance(array, Incoming)
            self.cuda.synchronize(array.stream)
            self.cuda.copy(self.address + start, array.address, array.nbytes)
        self.cuda.synchronize()

    def output(self, start: int, size: int) -> memoryview:
        raise DataLoss(f"contacts.shared names {size} bytes at offset {start}, which are on the device")

    def close(self) -> None:
        """Freed once no array views it."""

    def __del__(self) -> None:
        if hasattr(self, "address"):
            self.cuda.free(self.address)
