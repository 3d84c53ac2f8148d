"""Positions and contacts that stay on the daemon's GPU.

A `DeviceSession` takes arrays of any library that has `__cuda_array_interface__` or DLPack (cupy, torch, warp, numba, jax), and
its contacts have that interface: `cupy.asarray(contacts.vt.toi)`. It needs libcudart, and a daemon on this host with --cuda-ipc or the
engine in this process (server="local").
"""

from collided.gpu.arrays import DeviceArray
from collided.gpu.contacts import DeviceContacts, KindOnDevice
from collided.gpu.cuda import Cuda
from collided.gpu.session import DeviceSession

__all__ = ["Cuda", "DeviceArray", "DeviceContacts", "DeviceSession", "KindOnDevice"]
