"""The few calls of libcudart that sharing memory takes."""

from __future__ import annotations

import ctypes
import ctypes.util
from typing import Any

from collided.errors import FailedPrecondition, ResourceExhausted

HANDLE_BYTES = 64
_NAMES = ("libcudart.so", "libcudart.so.13", "libcudart.so.12", "libcudart.so.11.0")
_DEFAULT = 4  # cudaMemcpyDefault: either side is told by its address


class _Handle(ctypes.Structure):
    _fields_ = [("reserved", ctypes.c_char * HANDLE_BYTES)]


class Cuda:
    """Calls on the current device. Raises FailedPrecondition where there is no libcudart or no GPU."""

    backend = "cuda"  # of the scenes whose device it is
    default_stream: int | None = 1  # cudaStreamLegacy, which waits for work on all streams but the non-blocking ones

    def __init__(self, library: Any = None) -> None:
        """library: None: libcudart, as the loader finds it."""
        self._library = library or _load()

    def allocate(self, size: int) -> int:
        """Address of so many bytes on the device, by cudaMalloc: memory of pools cannot be shared."""
        address = ctypes.c_void_p()
        self._check(self._library.cudaMalloc(ctypes.byref(address), ctypes.c_size_t(size)), f"allocate {size} bytes")
        return address.value or 0

    def free(self, address: int) -> None:
        """Gives back memory that `allocate` gave."""
        self._library.cudaFree(ctypes.c_void_p(address))

    def handle(self, address: int) -> bytes:
        """The cudaIpcMemHandle_t of an allocation, with which other processes open it."""
        handle = _Handle()
        self._check(self._library.cudaIpcGetMemHandle(ctypes.byref(handle), ctypes.c_void_p(address)), "share memory")
        return bytes(handle)

    def copy(self, to: int, source: int, size: int) -> None:
        """From either side to either, behind the work of the default stream."""
        self._check(self._library.cudaMemcpy(ctypes.c_void_p(to), ctypes.c_void_p(source), ctypes.c_size_t(size), _DEFAULT),
                    f"copy {size} bytes")

    def synchronize(self, stream: int = 0) -> None:
        """Waits for the work of a stream."""
        self._check(self._library.cudaStreamSynchronize(ctypes.c_void_p(stream)), "wait for a stream")

    def _check(self, code: int, what: str) -> None:
        if code == 0:
            return
        reason = self._library.cudaGetErrorString(code)
        kind = ResourceExhausted if code == 2 else FailedPrecondition
        raise kind(f"CUDA cannot {what}: {reason.decode() if reason else code}")


def _load() -> Any:
    found = ctypes.util.find_library("cudart")
    for name in (*_NAMES, *([found] if found else [])):
        try:
            library = ctypes.CDLL(name)
        except OSError:
            continue
        library.cudaGetErrorString.restype = ctypes.c_char_p
        return library
    raise FailedPrecondition(f"no libcudart was found ({', '.join(_NAMES)}); LD_LIBRARY_PATH may name its folder")
