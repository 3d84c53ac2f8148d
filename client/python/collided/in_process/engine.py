"""A scene of the engine in this process."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from collided.columns import COLUMNS
from collided.errors import FailedPrecondition, Unimplemented
from collided.frames.updates import Incoming, Update
from collided.in_process import library
from collided.in_process.library import Library
from collided.kinds import EDGE_EDGE, KINDS, TRIANGLE_TRIANGLE, VERTEX_TRIANGLE
from collided.layout import Layout
from collided.options import FIELDS
from collided.v1 import contact_pb2, frame_pb2, metrics_pb2, scene_pb2

# Fields of contacts, in the order of the bits of the library's mask.
_FIELDS = [contact_pb2.ContactField.Value(f"CONTACT_FIELD_{name.upper()}") for name in (*FIELDS, "pair_states")]
_NAMES = {"excluded_rings": "exclude_rings", "excludes_rest_pairs": "exclude_rest_pairs"}  # of the library, and here


@dataclass(frozen=True)
class OnDevice:
    """The frame begins after the work that a stream holds, and its contacts stay in memory of the scene's device."""

    stream: int | None
    address: int  # of the room
    size: int


class Result:
    """Holds what a frame found. Its messages name arrays in the library's memory, which free() gives back."""

    def __init__(self, loaded: Library, pointer: ctypes.c_void_p) -> None:
        self._library, self._pointer = loaded, pointer

    def done(self, has_advanced: bool) -> frame_pb2.FrameDone:
        """Describes a frame whose contacts all came to the host."""
        done = self._facts(has_advanced)
        done.contacts.extend(_chunk(kind, contacts) for kind, contacts in self._contacts("result_contacts"))
        return done

    def done_on_device(self, has_advanced: bool, memory: int) -> frame_pb2.FrameDone:
        """Describes a frame that had room on the device. Offsets count from `memory`. Contacts on the host are copied."""
        done = self._facts(has_advanced)
        done.contacts.extend(_chunk(kind, contacts, memory) for kind, contacts in self._contacts("result_contacts_in_room"))
        done.contacts.extend(_copy(kind, contacts) for kind, contacts in self._contacts("result_contacts"))
        return done

    def _contacts(self, function: str) -> Iterator[tuple[contact_pb2.ContactKind, library.Contacts]]:
        """Yields each kind that has contacts."""
        for kind in KINDS:
            contacts = library.Contacts()
            self._library.call(function, self._pointer, kind, ctypes.byref(contacts))
            if contacts.count:
                yield kind, contacts

    def _facts(self, has_advanced: bool) -> frame_pb2.FrameDone:
        facts = library.Facts()
        self._library.call("result_facts", self._pointer, ctypes.byref(facts))
        done = frame_pb2.FrameDone(contact_count=facts.contact_count, earliest_toi=facts.earliest_toi,
                                   any_contact=bool(facts.any_contact), metrics=self._metrics(facts))
        if has_advanced:
            done.advanced, done.way = facts.advanced, facts.way
            done.shortened.ids = ctypes.string_at(facts.shortened_ids, 4 * facts.shortened_count)
            done.shortened.fractions = ctypes.string_at(facts.shortened_fractions, 8 * facts.shortened_count)
            done.limits.extend(_copy(kind, contacts) for kind, contacts in self._contacts("result_limits"))
        if facts.mesh_pair_count:
            done.pairs.CopyFrom(self._pairs(facts.mesh_pair_count))
        return done

    def _pairs(self, count: int) -> contact_pb2.MeshPairs:
        rows = (library.MeshPair * count)()
        for i, row in enumerate(rows):
            row.struct_size = ctypes.sizeof(library.MeshPair)
            self._library.call("result_mesh_pair", self._pointer, i, ctypes.byref(row))
        table = np.ctypeslib.as_array(rows)

        def packed(dtype: str, *names: str) -> bytes:
            return np.stack([table[name] for name in names], axis=-1).astype(dtype).tobytes()

        return contact_pb2.MeshPairs(meshes=packed("<u4", "first", "second"), states=packed("u1", "state"),
                                     inside=packed("<u4", "first_inside", "second_inside"), deepest=packed("<u4", "deepest"),
                                     depths=packed("<f8", "depth"))

    def _metrics(self, facts: library.Facts) -> metrics_pb2.FrameMetrics:
        counts = metrics_pb2.FrameCounts(**{name: getattr(facts, name) for name in (
            "cells", "leaves", "top_level", "base_level", "registrations", "tests", "pairs", "exact_decisions",
            "inside_out")})
        counts.contacts_edge_triangle, counts.contacts_vertex_solid = facts.edge_triangle_contacts, facts.vertex_solid_contacts
        for i, kind in enumerate((VERTEX_TRIANGLE, EDGE_EDGE, TRIANGLE_TRIANGLE)):
            for counter in ("candidates", "survivors", "contacts"):
                if (field := f"{counter}_{kind.name}") in counts.DESCRIPTOR.fields_by_name:  # triangle pairs have no candidates
                    setattr(counts, field, getattr(facts, counter)[i])
        metrics = metrics_pb2.FrameMetrics(
            counts=counts, replays=facts.replays, allocations=facts.allocations, graph_launches=facts.graph_launches,
            step_milliseconds=facts.step_milliseconds, broad_phase_engine=facts.broad_phase_engine,
            unused_options=self._unused_options(facts.unused_option_count))
        if facts.input_resolution:
            metrics.warnings.append(metrics_pb2.FRAME_WARNING_INPUT_RESOLUTION)
        for i in range(facts.stage_count):
            name, milliseconds = ctypes.c_char_p(), ctypes.c_double()
            self._library.call("result_stage", self._pointer, i, ctypes.byref(name), ctypes.byref(milliseconds))
            metrics.stages.add(stage=(name.value or b"").decode(), milliseconds=milliseconds.value)
        return metrics

    def _unused_options(self, count: int) -> Iterator[str]:
        for i in range(count):
            name = ctypes.c_char_p()
            self._library.call("result_unused_option", self._pointer, i, ctypes.byref(name))
            mesh, dot, option = (name.value or b"").decode().rpartition(".")
            yield "spec." + mesh + dot + _NAMES.get(option, option)

    def free(self) -> None:
        pointer, self._pointer = self._pointer, ctypes.c_void_p()
        self._library.free_result(pointer)


def _chunk(kind: contact_pb2.ContactKind, contacts: library.Contacts, memory: int = 0) -> contact_pb2.ContactChunk:
    """Names each array by its offset from `memory`."""
    chunk = contact_pb2.ContactChunk(kind=kind, count=contacts.count)
    for name, column in COLUMNS.items():
        if (address := getattr(contacts, name)) is not None:
            shared = getattr(chunk.shared, name)
            shared.offset, shared.size = address - memory, contacts.count * column.width
    return chunk


def _copy(kind: contact_pb2.ContactKind, contacts: library.Contacts) -> contact_pb2.ContactChunk:
    arrays: dict[str, Any] = {name: ctypes.string_at(address, contacts.count * column.width)
                              for name, column in COLUMNS.items() if (address := getattr(contacts, name)) is not None}
    return contact_pb2.ContactChunk(kind=kind, count=contacts.count, **arrays)


class EngineScene:
    """A scene, for one frame at a time. Raises what the library refuses it with."""

    def __init__(self, loaded: Library, spec: scene_pb2.SceneSpec, layout: Layout) -> None:
        self._library = loaded
        self._scene = ctypes.c_void_p()
        self._lock = threading.RLock()  # a garbage collection in detect() may close the scene
        self._is_busy = self._is_closed = False
        self._gives_up = False
        self._ask = library.CANCELLED(lambda _: self._gives_up)
        self.last_frame_id = 0  # that was applied
        self.stream: Any = None  # the transport that it belongs to
        keep: list[np.ndarray] = []  # until the library has copied it
        self._library.call("scene_create", ctypes.byref(_spec(spec, layout, keep)), ctypes.byref(self._scene))

    def facts(self, message: scene_pb2.Scene) -> None:
        """Fills in what the engine knows of the scene."""
        topology, device, memory = library.Topology(), library.DeviceInfo(), ctypes.c_uint64()
        with self._lock:
            self._check_open()
            self._library.call("scene_topology", self._scene, ctypes.byref(topology))
            self._library.call("scene_device", self._scene, ctypes.byref(device))
            self._library.call("scene_memory", self._scene, ctypes.byref(memory))
        message.vertex_count, message.edge_count = topology.vertex_count, topology.edge_count
        message.device, message.device_id = device.name.decode(errors="replace"), device.id.decode()
        message.last_frame_id = self.last_frame_id
        del message.memory[:]
        message.memory.add(part="scene", bytes=memory.value)

    def detect(self, frame_id: int, head: frame_pb2.Frame, updates: list[Update],
               on_device: OnDevice | None = None) -> Result:
        """Waits for the frame. Raises Cancelled after give_up(), which does not end one that is on the device: a callback into
        the interpreter would swallow an interrupt of its main thread."""
        if head.HasField("edit"):
            raise Unimplemented("edit is given, which an engine in the process does not take; use a daemon", field="edit")
        result = ctypes.c_void_p()
        frame = self._frame(head, updates)
        if on_device:
            frame.stream, frame.room, frame.room_bytes = on_device.stream, on_device.address, on_device.size
            frame.cancelled = library.CANCELLED()
        with self._lock:
            self._check_open()
            self._is_busy = True
            try:
                self._library.call("detect", self._scene, ctypes.byref(frame), ctypes.byref(result))
            finally:
                self._is_busy = False
                self._free_if_closed()
            if not head.trial:
                self.last_frame_id = frame_id
        return Result(self._library, result)

    def _frame(self, head: frame_pb2.Frame, updates: list[Update]) -> library.Frame:
        array = (library.Update * len(updates))(*(_update(update) for update in updates))
        frame = library.Frame(head, updates=array, update_count=len(updates), cancelled=self._ask)
        if head.HasField("delta"):
            frame.delta = ctypes.pointer(ctypes.c_double(head.delta))
        if head.HasField("from_last_fraction"):
            frame.start_fraction = ctypes.pointer(ctypes.c_double(head.from_last_fraction))
        return frame

    def give_up(self, gives_up: bool) -> None:
        """Ends the frame in work, and every later one, until it is called with False."""
        self._gives_up = gives_up

    def close(self) -> None:
        """Frees the scene, once a frame in work has been given up."""
        self._gives_up = True
        with self._lock:
            self._is_closed = True
            self._free_if_closed()

    def _free_if_closed(self) -> None:
        if self._is_closed and not self._is_busy:
            scene, self._scene = self._scene, ctypes.c_void_p()
            self._library.free_scene(scene)

    def _check_open(self) -> None:
        if self._is_closed:
            raise FailedPrecondition("the scene is closed")


def _address(array: np.ndarray | Incoming | None) -> int | None:
    if isinstance(array, Incoming):
        return array.address
    return None if array is None or not array.size else array.ctypes.data


def _update(update: Update) -> library.Update:
    start, end, indices = update.start, update.positions, update.indices
    return library.Update(
        mesh=update.mesh, start=_address(start), end=_address(end), indices=_address(indices),
        start_bytes=0 if start is None else start.nbytes, end_bytes=0 if end is None else end.nbytes,
        is_sparse=indices is not None, index_count=0 if indices is None else len(indices),
        transform=_address(update.pose), start_transform=_address(update.start_pose))


def _spec(spec: scene_pb2.SceneSpec, layout: Layout, keep: list[np.ndarray]) -> library.SceneSpec:
    """keep: arrays that the structure borrows."""

    def borrowed(values: Any) -> int | None:
        array = np.ascontiguousarray(np.frombuffer(values, "<u4") if isinstance(values, bytes) else values, "<u4")
        keep.append(array)
        return _address(array)

    meshes = (library.Mesh * len(spec.meshes))()
    for i, (asked, (_, mesh)) in enumerate(zip(spec.meshes, layout.present(), strict=True)):
        meshes[i] = library.Mesh(
            triangles=borrowed(mesh.triangles), triangle_count=len(mesh.triangles), edges=borrowed(asked.edges),
            edge_count=len(asked.edges) // 8, points=borrowed(asked.points), point_count=len(asked.points) // 4,
            vertex_count=asked.vertex_count, motion=asked.motion, groups=asked.groups, collide_mask=asked.collide_mask,
            no_self_contacts=asked.no_self_contacts, excluded_rings=asked.exclude_rings,
            excludes_rest_pairs=asked.exclude_rest_pairs, half_thickness=asked.half_thickness, solid=asked.solid)
    excluded = [mesh for pair in spec.excluded_meshes for mesh in (pair.first, pair.second)]
    out = library.SceneSpec(
        spec, meshes=meshes, mesh_count=len(meshes), excluded_meshes=borrowed(excluded), excluded_mesh_count=len(excluded) // 2,
        device=_device(spec), kinds=sum(1 << (kind - 1) for kind in set(spec.kinds)),
        fields=sum(1 << _FIELDS.index(field) for field in set(spec.fields)), memory_budget=spec.memory_budget_bytes)
    if spec.HasField("quantization_box"):
        box = (*spec.quantization_box.lower, *spec.quantization_box.upper)
        out.quantized_in = (ctypes.c_double * 6)(*box)
    return out


def _device(spec: scene_pb2.SceneSpec) -> bytes:
    """Raises Unimplemented for a scene on several devices."""
    if spec.part_devices:
        raise Unimplemented("part_devices is given, which an engine in the process does not take; use a daemon",
                            field="part_devices")
    if spec.device:
        return spec.device.encode()
    return {scene_pb2.BACKEND_CPU: b"cpu", scene_pb2.BACKEND_CUDA: b"cuda"}.get(spec.backend, b"auto")
