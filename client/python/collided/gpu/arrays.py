"""Arrays on the device: those of other libraries that come in, and ours that go out."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from collided.errors import InvalidArgument
from collided.frames.updates import Incoming
from collided.gpu.cuda import Cuda

_CUDA_DEVICE = 2  # kDLCUDA
_LEGACY_STREAM = 1
_KINDS = {0: "i", 1: "u", 2: "f"}


@dataclass(frozen=True, eq=False)
class DeviceArray:
    """An array in the session's memory on the device, with `__cuda_array_interface__`. Complete: no stream has to wait."""

    address: int
    shape: tuple[int, ...]
    dtype: np.dtype
    cuda: Cuda = field(repr=False)
    owner: Any = field(repr=False)  # the memory lives as long

    @property
    def nbytes(self) -> int:
        """Bytes of the whole array."""
        return int(np.prod(self.shape, dtype=int)) * self.dtype.itemsize

    @property
    def __cuda_array_interface__(self) -> dict[str, Any]:
        return {"shape": self.shape, "typestr": self.dtype.str, "data": (self.address if self.nbytes else 0, False),
                "strides": None, "version": 3, "stream": None}

    def __len__(self) -> int:
        return self.shape[0]

    def to_host(self) -> np.ndarray:
        """A copy in host memory."""
        out = np.empty(self.shape, self.dtype)
        if out.nbytes:
            self.cuda.copy(out.ctypes.data, self.address, out.nbytes)
            self.cuda.synchronize()
        return out


def is_on_device(value: Any) -> bool:
    """Whether an object is an array on a GPU."""
    if hasattr(value, "__cuda_array_interface__"):
        return True
    return hasattr(value, "__dlpack_device__") and value.__dlpack_device__()[0] == _CUDA_DEVICE


def incoming(value: Any, dtype: np.dtype, count: int, argument: str) -> Incoming:
    """Positions on the device: of the scene's own type, (count, 3), without gaps, since nothing converts them there."""
    if hasattr(value, "__cuda_array_interface__"):
        described = value.__cuda_array_interface__
        shape, found, strides = described["shape"], np.dtype(described["typestr"]), described.get("strides")
        address, stream = described["data"][0], described.get("stream") or 0
        keep: Any = value
    else:
        keep = value.__dlpack__(stream=_LEGACY_STREAM)
        address, shape, found, strides = _tensor(keep)
        stream = 0
    if found != dtype:
        raise InvalidArgument(f"{argument} has dtype {found} on the device; it must be {dtype}", field=argument)
    if tuple(shape) != (count, 3):
        raise InvalidArgument(f"{argument} has shape {tuple(shape)}; it must be ({count}, 3)", field=argument)
    if strides is not None and tuple(strides) != (3 * dtype.itemsize, dtype.itemsize):
        raise InvalidArgument(f"{argument} has strides {tuple(strides)} on the device; it must be contiguous", field=argument)
    return Incoming(address, count * 3 * dtype.itemsize, stream, keep)


class _Tensor(ctypes.Structure):
    """DLTensor."""

    _fields_ = [("data", ctypes.c_void_p), ("device_type", ctypes.c_int32), ("device_id", ctypes.c_int32),
                ("ndim", ctypes.c_int32), ("code", ctypes.c_uint8), ("bits", ctypes.c_uint8), ("lanes", ctypes.c_uint16),
                ("shape", ctypes.POINTER(ctypes.c_int64)), ("strides", ctypes.POINTER(ctypes.c_int64)),
                ("byte_offset", ctypes.c_uint64)]


def _tensor(capsule: Any) -> tuple[int, tuple[int, ...], np.dtype, tuple[int, ...] | None]:
    """Address, shape, dtype and strides in bytes. The capsule stays its maker's, and is freed by it."""
    pointer_of = ctypes.pythonapi.PyCapsule_GetPointer
    pointer_of.restype, pointer_of.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    tensor = ctypes.cast(pointer_of(capsule, b"dltensor"), ctypes.POINTER(_Tensor)).contents
    if tensor.code not in _KINDS or tensor.lanes != 1 or tensor.bits not in (16, 32, 64):
        raise InvalidArgument(f"a DLPack array has type code {tensor.code} of {tensor.bits} bits; it must be of real numbers")
    dtype = np.dtype(f"<{_KINDS[tensor.code]}{tensor.bits // 8}")
    strides = tuple(s * dtype.itemsize for s in tensor.strides[:tensor.ndim]) if tensor.strides else None
    return (tensor.data or 0) + tensor.byte_offset, tuple(tensor.shape[:tensor.ndim]), dtype, strides
