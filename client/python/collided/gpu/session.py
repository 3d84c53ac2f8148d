"""Frames whose positions and contacts stay on the daemon's GPU."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Unpack, cast

import collided.leftovers as leftovers
from collided.contacts import Contacts
from collided.contacts.answer import Answer
from collided.contacts.columns import Part, read_limits
from collided.contacts.pairs import read_pairs
from collided.errors import DataLoss, FailedPrecondition, InvalidArgument, ResourceExhausted, error_of_frame
from collided.frames.advance import read_advance
from collided.frames.options import FrameOptions
from collided.frames.updates import Update
from collided.gpu.arrays import incoming, is_on_device
from collided.gpu.contacts import DeviceContacts
from collided.gpu.cuda import Cuda
from collided.gpu.in_process import DeviceTransport, Rooms
from collided.gpu.memory import DeviceMemory, OutputMemory
from collided.in_process.client import LocalClient
from collided.layout import Layout
from collided.leftovers import Leftover
from collided.scene import Scene
from collided.transport.local_transport import LocalTransport
from collided.transport.opening import MOST_FRAMES, local_socket, opened_by
from collided.transport.peer import LocalPeer
from collided.transport.region import region_layout
from collided.v1 import collision_service_pb2 as api
from collided.v1 import contact_pb2, frame_pb2


@dataclass(eq=False)
class _Pending:
    """A frame in flight. edited: what its edit makes of the scene."""

    wire_id: int
    contacts: DeviceContacts
    head: frame_pb2.Frame
    edited: Layout | None
    shortened: list[frame_pb2.ShortenedWays] = field(default_factory=list)
    pairs: list[contact_pb2.MeshPairs] = field(default_factory=list)
    limits: list[Part] = field(default_factory=list)


class DeviceSession:
    """As Session, for simulators on the daemon's GPU: only a frame's status crosses PCIe. A context manager.

    meshes: a Scene on the GPU, or what Scene takes, with its options.
    window: frames in flight, 1 to the daemon's limit.
    output_bytes: room for each frame's contacts on the device; those beyond it come to the host.
    cuda: calls on the device that the scene is on; None: libcudart's on the current one.

    Positions are arrays with `__cuda_array_interface__` or DLPack, of the scene's own type, (n, 3) and contiguous, or in host
    memory, or `Sparse` or `Rigid`. Arrays may be changed once `send` returns. The client does not know where the scene is: a
    daemon that is lost is not put back, and raises Unavailable.

    server="local": the engine in this process, on the scene's GPU; `send` computes the frame, positions are read where they are, and
    Ctrl-C acts once the frame is answered. It begins after the work that is in line on the arrays' streams (that of
    `__cuda_array_interface__`, else the default stream), and so does whatever still reads an earlier frame's contacts there.
    """

    def __init__(self, meshes: Any, *, window: int = 2, output_bytes: int = 16 << 20, edit_bytes: int = 0,
                 daemon_user: int | None = None, cuda: Cuda | None = None, **scene_options: Any) -> None:
        self._owns_scene = not isinstance(meshes, Scene)
        self.scene = meshes if isinstance(meshes, Scene) else Scene(meshes, **scene_options)
        try:
            self._open(cuda or Cuda(), window, (output_bytes, edit_bytes), daemon_user)
        except BaseException as error:
            if self._owns_scene:
                self.scene.give_up(error)
            raise
        ends = [self._transport.close]
        self._leftover = leftovers.watch(self, self.scene.left_by("DeviceSession", ends) if self._owns_scene else
                                         Leftover("DeviceSession", ends, name=self.scene.name))
        self.window = window
        self._sent = 0
        self._has_begun = False
        self._answered_layout: Layout = self.scene.layout
        self._pending: deque[_Pending] = deque()

    def _open(self, cuda: Cuda, window: int, room: tuple[int, int], daemon_user: int | None) -> None:
        client = self.scene.client
        if isinstance(client, LocalClient):
            if not 1 <= window <= MOST_FRAMES:
                raise ResourceExhausted(f"window is {window}; it must be from 1 to {MOST_FRAMES}", field="window")
            rooms = Rooms(cuda, window, room[0])
            self._memory: OutputMemory = rooms
            self._transport: DeviceTransport | LocalTransport = DeviceTransport(client, self.scene.message, rooms)
            return
        limit = client.info.limits.max_window
        if not 1 <= window <= limit:
            raise ResourceExhausted(f"window is {window}; the daemon's limit is {limit}", field="window")
        path = local_socket(client, self.scene.message)
        memory = DeviceMemory(cuda, region_layout(self.scene.refresh(), window, *room))
        self._memory = memory
        transport = LocalTransport(LocalPeer(path, client.address, daemon_user, client.options), memory)
        self._transport = transport
        opened_by(transport, api.OpenStream(scene_id=self.scene.id, window=window), client, client.options.deadline)

    def step(self, positions: Any = None, start: Any = None, **options: Unpack[FrameOptions]) -> DeviceContacts:
        """Sends a frame and waits for its contacts."""
        if self._pending:
            raise FailedPrecondition(f"step() with {len(self._pending)} frames in flight: receive them first")
        self.send(positions, start, **options)
        return self.receive()

    def send(self, positions: Any = None, start: Any = None, **options: Unpack[FrameOptions]) -> int:
        """Sends a frame. FailedPrecondition while a whole window is in flight, or an edit where there is another one."""
        if len(self._pending) >= self.window:
            raise FailedPrecondition(f"{self.window} frames are in flight, the whole window: receive one first")
        if options.get("edit") is not None and any(pending.edited for pending in self._pending):
            # One that is refused leaves another layout to the next one.
            raise FailedPrecondition("an edit is in flight: receive it first")
        there, elsewhere = self._split(positions), self._split(start)
        track = self.scene.track
        alone = elsewhere[0].keys() - there[0].keys()
        if alone:
            raise InvalidArgument(f"start names mesh {min(alone)} on the device, and positions do not", field="start")
        placed = [Update(i, positions=array, start=elsewhere[0].get(i)) for i, array in there[0].items()]
        is_first = not self._has_begun and all(pending.head.trial for pending in self._pending)
        request = track.request(self._layout, is_first, there[1], elsewhere[1], cast(FrameOptions, options), placed)
        self.scene.client.check_known(request.head, "frame")
        wire_id = track.next_id()
        self._transport.send(wire_id, request.head, request.updates)
        self._sent += 1
        self._pending.append(_Pending(wire_id, DeviceContacts(self._sent), request.head,
                                      request.edit.layout if request.edit else None))
        return self._sent

    @property
    def _layout(self) -> Layout:
        """Of the scene once all that was sent is answered."""
        return next((pending.edited for pending in self._pending if pending.edited), self._answered_layout)

    def receive(self) -> DeviceContacts:
        """The next frame's contacts; raises what the daemon refused it with."""
        if not self._pending:
            raise FailedPrecondition("receive() with no frame in flight")
        pending, contacts = self._pending[0], self._pending[0].contacts
        while True:
            response = self._transport.read(None)
            kind = response.WhichOneof("response") if response is not None else None
            if response is None or kind in (None, "draining"):
                continue
            if response.frame_id != pending.wire_id or kind not in ("contacts", "limits", "shortened", "pairs", "done", "error"):
                raise DataLoss(f"the daemon answers frame {response.frame_id} with {kind!r} instead of frame {pending.wire_id}")
            if kind == "contacts":
                contacts.add(response.contacts, self._memory)
                continue
            if kind == "limits":
                pending.limits += read_limits([response.limits], pending.head.limits)
                continue
            if kind == "shortened":
                pending.shortened.append(response.shortened)
                continue
            if kind == "pairs":
                pending.pairs.append(response.pairs)
                continue
            self._pending.popleft()
            if kind == "error":
                raise error_of_frame(response.error, contacts.frame_id)
            done, layout = response.done, pending.edited or self._answered_layout
            for chunk in done.contacts:
                contacts.add(chunk, self._memory)
            pending.limits += read_limits(done.limits, pending.head.limits)
            del done.contacts[:], done.limits[:]
            advance = read_advance(pending.head, done, pending.shortened, layout)
            pairs = read_pairs(pending.pairs, done, layout, self.scene.track.tells_pairs(pending.head, self.scene.message.spec))
            answer = Answer(contacts.frame_id, pending.wire_id, done, layout, None, True, advance=advance, limits=pending.limits)
            contacts.done, contacts.limits = done, Contacts.of_parts(answer, []).limits
            contacts.pairs = pairs
            contacts.shortened = advance.shortened if advance else contacts.shortened
            if not pending.head.trial:
                self._has_begun = True
                self._answered_layout = layout
            return contacts

    def _split(self, values: Any) -> tuple[dict[int, Any], Any]:
        """Arrays on the device by mesh, and all else."""
        if values is None or not (isinstance(values, Mapping) or is_on_device(values)):
            return {}, values
        if not isinstance(values, Mapping):
            movable = self._layout.movable
            if len(movable) != 1:
                raise InvalidArgument(f"positions are not a mapping of meshes, and {len(movable)} meshes can move",
                                      field="positions")
            values = {movable[0]: values}
        dtype, there = self.scene.track.form.dtype, {}
        on_device = {name: value for name, value in values.items() if is_on_device(value)}
        for index, value in self._layout.by_index(on_device, "positions").items():
            mesh = self._layout.mesh(index)
            there[index] = incoming(value, dtype, mesh.vertex_count, f"positions[{mesh.name!r}]")
        return there, {name: value for name, value in values.items() if name not in on_device}

    def close(self) -> None:
        """Ends the stream, and deletes the scene if it is the session's own."""
        self._leftover.take()
        self._leftover.end_streams()
        if self._owns_scene:
            self.scene.close()

    def __repr__(self) -> str:
        state = "closed" if self._leftover.is_over else f"{len(self._pending)} of {self.window} frames in flight"
        return f"<DeviceSession of {self.scene.name}: {state}>"

    def __enter__(self) -> DeviceSession:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
