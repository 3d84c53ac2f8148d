"""libcollided.so by ctypes: its structures, where it is found, and its errors as this package's."""

from __future__ import annotations

import ctypes
import functools
import os
from ctypes import POINTER, c_char, c_char_p, c_double, c_int32, c_size_t, c_uint32, c_uint64, c_void_p
from typing import Any

from collided.columns import COLUMNS
from collided.errors import FailedPrecondition, error_of
from collided.programs import bundled_library

_ABI = 1  # COLLIDED_ABI_VERSION
_NAME = f"libcollided.so.{_ABI}"
_NUMBERS = (c_double, c_int32, c_uint32, c_uint64)
CANCELLED = ctypes.CFUNCTYPE(c_int32, c_void_p)


class _Sized(ctypes.Structure):
    """A structure whose first member is its size."""

    def __init__(self, message: Any = None, **members: Any) -> None:
        """Numbers that the protocol's message has by the same names are members, too, unless they are given otherwise."""
        same = () if message is None else message.DESCRIPTOR.fields_by_name
        numbers = {name: getattr(message, name) for name, kind, *_ in self._fields_ if name in same and kind in _NUMBERS
                   and name not in members}
        super().__init__(struct_size=ctypes.sizeof(self), **numbers, **members)


class Mesh(_Sized):
    _fields_ = [("struct_size", c_size_t), ("triangles", c_void_p), ("edges", c_void_p), ("points", c_void_p),
                ("triangle_count", c_uint64), ("edge_count", c_uint64), ("point_count", c_uint64),
                ("vertex_count", c_uint32), ("motion", c_int32), ("groups", c_uint32), ("collide_mask", c_uint32),
                ("no_self_contacts", c_int32), ("excluded_rings", c_uint32), ("excludes_rest_pairs", c_int32),
                ("reserved", c_int32), ("half_thickness", c_double), ("solid", c_int32), ("reserved2", c_int32)]


class SceneSpec(_Sized):
    _fields_ = [("struct_size", c_size_t), ("meshes", POINTER(Mesh)), ("mesh_count", c_uint64),
                ("excluded_meshes", c_void_p), ("excluded_mesh_count", c_uint64), ("device", c_char_p),
                ("mode", c_int32), ("accuracy", c_int32), ("report", c_int32), ("position_format", c_int32),
                ("broad_phase_engine", c_int32), ("reuse", c_int32), ("kinds", c_uint32), ("fields", c_uint32),
                ("thickness", c_double), ("delta", c_double), ("min_separation", c_double), ("rest_distance", c_double),
                ("quantized_in", POINTER(c_double)), ("memory_budget", c_uint64), ("expected_contacts", c_uint64),
                ("threads", c_int32), ("reserved", c_int32)]


class DeviceInfo(_Sized):
    _fields_ = [("struct_size", c_size_t), ("id", c_char * 16), ("name", c_char * 128), ("memory_bytes", c_uint64)]


class Topology(_Sized):
    _fields_ = [("struct_size", c_size_t), ("elements", c_void_p), ("edges", c_void_p), ("vertex_offsets", c_void_p),
                ("element_offsets", c_void_p), ("vertex_count", c_uint64), ("element_count", c_uint64),
                ("edge_count", c_uint64), ("mesh_count", c_uint64)]


class Update(_Sized):
    _fields_ = [("struct_size", c_size_t), ("start", c_void_p), ("end", c_void_p), ("start_bytes", c_uint64),
                ("end_bytes", c_uint64), ("indices", c_void_p), ("index_count", c_uint64), ("is_sparse", c_int32),
                ("mesh", c_uint32), ("transform", c_void_p), ("start_transform", c_void_p)]


class Frame(_Sized):
    _fields_ = [("struct_size", c_size_t), ("updates", POINTER(Update)), ("update_count", c_uint64), ("mode", c_int32),
                ("accuracy", c_int32), ("report", c_int32), ("ignore_separating", c_int32), ("advance", c_int32),
                ("trial", c_int32), ("delta", POINTER(c_double)), ("start_fraction", POINTER(c_double)),
                ("cancelled", CANCELLED), ("cancelled_context", c_void_p), ("stream", c_void_p), ("room", c_void_p),
                ("room_bytes", c_uint64), ("advance_mode", c_int32), ("limits", c_int32)]


class Contacts(_Sized):
    _fields_ = [("struct_size", c_size_t), ("count", c_uint64), *((name, c_void_p) for name in COLUMNS)]


class Facts(_Sized):
    _fields_ = [("struct_size", c_size_t), ("contact_count", c_uint64), ("earliest_toi", c_double),
                ("advanced", c_double), ("any_contact", c_int32), ("input_resolution", c_int32),
                ("step_milliseconds", c_double), ("stage_count", c_uint32), ("unused_option_count", c_uint32),
                ("replays", c_uint32), ("allocations", c_uint32), ("graph_launches", c_uint32),
                ("broad_phase_engine", c_int32), ("cells", c_uint64), ("leaves", c_uint64), ("registrations", c_uint64),
                ("tests", c_uint64), ("pairs", c_uint64), ("exact_decisions", c_uint64), ("top_level", c_uint32),
                ("base_level", c_uint32), ("candidates", c_uint64 * 3), ("survivors", c_uint64 * 3),
                ("contacts", c_uint64 * 3), ("way", c_double), ("shortened_count", c_uint64), ("shortened_ids", c_void_p),
                ("shortened_fractions", c_void_p), ("edge_triangle_contacts", c_uint64), ("vertex_solid_contacts", c_uint64),
                ("mesh_pair_count", c_uint64), ("inside_out", c_uint64)]


class MeshPair(_Sized):
    _fields_ = [("struct_size", c_size_t), ("first", c_uint32), ("second", c_uint32), ("state", c_int32),
                ("first_inside", c_uint32), ("second_inside", c_uint32), ("deepest", c_uint32), ("depth", c_double)]


_FUNCTIONS = {
    "scene_create": [POINTER(SceneSpec), POINTER(c_void_p)],
    "scene_topology": [c_void_p, POINTER(Topology)],
    "scene_memory": [c_void_p, POINTER(c_uint64)],
    "scene_device": [c_void_p, POINTER(DeviceInfo)],
    "detect": [c_void_p, POINTER(Frame), POINTER(c_void_p)],
    "result_contacts": [c_void_p, c_int32, POINTER(Contacts)],
    "result_contacts_in_room": [c_void_p, c_int32, POINTER(Contacts)],
    "result_limits": [c_void_p, c_int32, POINTER(Contacts)],
    "result_facts": [c_void_p, POINTER(Facts)],
    "result_mesh_pair": [c_void_p, c_uint64, POINTER(MeshPair)],
    "result_stage": [c_void_p, c_uint32, POINTER(c_char_p), POINTER(c_double)],
    "result_unused_option": [c_void_p, c_uint32, POINTER(c_char_p)]}


class Library:
    """The functions of the library by their names without `collided_`. Those that fail raise Error."""

    def __init__(self, path: str) -> None:
        try:
            self._loaded = ctypes.CDLL(path)
            version = self._loaded.collided_abi_version()
            if version != _ABI:
                raise FailedPrecondition(f"server is 'local', but {path!r} has interface {version}; this package needs {_ABI}",
                                         field="server")
            self._declare()
        except (OSError, AttributeError) as error:  # it lacks a function, if it is older
            raise FailedPrecondition(f"server is 'local', but {path!r} cannot be used: {error}", field="server") from None

    def _declare(self) -> None:
        for name in ("error_message", "error_field", "version"):
            getattr(self._loaded, f"collided_{name}").restype = c_char_p
        for name, arguments in _FUNCTIONS.items():
            getattr(self._loaded, f"collided_{name}").argtypes = arguments
        for name in ("scene_free", "result_free"):
            function = getattr(self._loaded, f"collided_{name}")
            function.argtypes, function.restype = [c_void_p], None

    @property
    def version(self) -> str:
        return self._loaded.collided_version().decode()

    def call(self, name: str, *arguments: Any) -> None:
        """Raises the library's error. An interpreter lets other threads run meanwhile."""
        code = getattr(self._loaded, f"collided_{name}")(*arguments)
        if code:
            raise error_of(code, self._loaded.collided_error_message().decode(errors="replace"),
                           field=self._loaded.collided_error_field().decode(errors="replace"))

    def free_scene(self, scene: Any) -> None:
        self._loaded.collided_scene_free(scene)

    def free_result(self, result: Any) -> None:
        self._loaded.collided_result_free(result)


def find_library() -> str:
    """$COLLIDED_LIBRARY; else what a wheel brought along; else what the system's loader finds by name."""
    return os.environ.get("COLLIDED_LIBRARY") or bundled_library(_NAME) or _NAME


@functools.cache
def load(path: str) -> Library:
    return Library(path)
