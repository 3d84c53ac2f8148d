"""Arrays on a GPU, or that only say so, by both protocols."""

import ctypes

from support import np


class OnDevice:
    """By `__cuda_array_interface__`. memory: on the device, with its `address`; None: the host's, which is said to be there."""

    def __init__(self, array, strides=None, memory=None):
        self.array, self.memory = array, memory
        self.__cuda_array_interface__ = {"shape": array.shape, "typestr": array.dtype.str, "strides": strides, "version": 3,
                                         "data": (memory.address if memory else array.ctypes.data, False)}


class Tensor(ctypes.Structure):
    """DLManagedTensor."""

    _fields_ = [("data", ctypes.c_void_p), ("device", ctypes.c_int32 * 2), ("ndim", ctypes.c_int32), ("code", ctypes.c_uint8),
                ("bits", ctypes.c_uint8), ("lanes", ctypes.c_uint16), ("shape", ctypes.POINTER(ctypes.c_int64)),
                ("strides", ctypes.POINTER(ctypes.c_int64)), ("byte_offset", ctypes.c_uint64), ("context", ctypes.c_void_p),
                ("deleter", ctypes.c_void_p)]


class InDlpack:
    """By DLPack, a number into its memory, as of `OnDevice`."""

    def __init__(self, array, memory=None):
        self.array, self.memory = with_a_number_before(array), memory
        self.shape = (ctypes.c_int64 * 2)(*array.shape)
        self.tensor = Tensor(memory.address if memory else self.array.ctypes.data, (2, 0), 2, 2, 8 * array.itemsize, 1,
                             self.shape, None, array.itemsize)

    def __dlpack_device__(self):
        return 2, 0

    def __dlpack__(self, stream):
        make = ctypes.pythonapi.PyCapsule_New
        make.restype, make.argtypes = ctypes.py_object, [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]
        return make(ctypes.addressof(self.tensor), b"dltensor", None)


def with_a_number_before(array):
    return np.concatenate([[0], array.ravel()]).astype(array.dtype)
