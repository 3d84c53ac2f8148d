"""Calls of libcudart that take memory of the host for a device's."""

import ctypes

from collided.gpu import Cuda

_ALIGNMENT = 256  # of cudaMalloc


class HostCuda:
    """libcudart on host memory: a handle holds the address."""

    def __init__(self):
        self.buffers = {}

    def cudaMalloc(self, pointer, size):
        buffer = ctypes.create_string_buffer(size.value + _ALIGNMENT)
        pointer._obj.value = -(-ctypes.addressof(buffer) // _ALIGNMENT) * _ALIGNMENT
        self.buffers[pointer._obj.value] = buffer
        return 0

    def cudaFree(self, address):
        del self.buffers[address.value]
        return 0

    def cudaIpcGetMemHandle(self, handle, address):
        ctypes.memmove(handle, str(address.value).encode(), len(str(address.value)))
        return 0

    def cudaMemcpy(self, to, source, size, kind):
        ctypes.memmove(to, source, size.value)
        return 0

    def cudaStreamSynchronize(self, stream):
        return 0


class CpuMemory(Cuda):
    """What a session on the device needs of scenes on CPU cores, whose device is the host."""

    backend = "cpu"
    default_stream = None

    def __init__(self):
        super().__init__(HostCuda())
