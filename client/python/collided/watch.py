"""The frames of a scene as an observer sees them, whoever sends them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from collided import leftovers
from collided.arrays import OneLine
from collided.connection.channel import metadata
from collided.connection.client import Client
from collided.contacts.answer import Answer
from collided.contacts.checks import check_limits
from collided.contacts.columns import read_chunk
from collided.contacts.contacts import Contacts
from collided.errors import Cancelled, DataLoss, DeadlineExceeded, NotFound
from collided.layout import Layout
from collided.leftovers import Leftover
from collided.positions import shown_dtype
from collided.transport.messages import Messages
from collided.v1 import collision_service_pb2 as api
from collided.v1 import scene_pb2
from collided.v1.collision_service_pb2_grpc import CollisionServiceStub


@dataclass(frozen=True, eq=False, repr=False)
class Watched(OneLine):
    """One frame.

    contacts: the first of each kind; `frame_id` is the one on the wire, that of the sender's `Contacts.wire_id`, and totals are
        the frame's own.
    skipped_frames: frames that were not shown since the last one. omitted_contacts: those that the frame has besides these.
    positions: of the meshes that were asked for, by name: of every `vertex_stride`-th vertex, (n, 3); (0, 3) once they are removed.
    edit_count: edits that the scene has had.
    """

    contacts: Contacts
    skipped_frames: int
    omitted_contacts: int
    positions: dict[str, np.ndarray]
    vertex_stride: int
    edit_count: int


class Watcher:
    """Frames that anyone sends to a scene of this client, as an iterator that ends when the scene does, or after `close`.

    frame_interval: every so many frames; 0: every one. max_frames_per_second: 0: as many as are read.
    max_contacts_per_kind: 0 to 8192, the first in canonical order; 0: only their numbers.
    meshes: names or indices of those whose positions are sent, of every `vertex_stride`-th vertex; 0: as many as fit.

    Watching never slows frames down: who reads too slowly is not shown every frame, but always the latest.
    """

    def __init__(self, client: Client, scene_id: str, *, frame_interval: int = 0, max_frames_per_second: float = 0.0,
                 max_contacts_per_kind: int = 0, meshes: Iterable[str | int] = (), vertex_stride: int = 0) -> None:
        self._client, self._scene_id = client, scene_id
        self._names: dict[int, str] = {}  # of meshes by index; the last one where it was removed
        self._see(client.get_scene(scene_id))
        request = api.WatchSceneRequest(
            scene_id=scene_id, frame_interval=frame_interval, max_frames_per_second=max_frames_per_second,
            max_contacts_per_kind=max_contacts_per_kind, vertex_stride=vertex_stride,
            position_meshes=[self._layout.index(mesh) for mesh in meshes])
        client.check_known(request, method="WatchScene")
        carried = metadata(client.options, scene_id)
        with client.stream_channel(self.scene) as channel:
            self._messages = Messages(channel, lambda: CollisionServiceStub(channel).WatchScene(request, metadata=carried))
        self.leftover = leftovers.watch(self, Leftover("Watcher", [self._messages.close],
                                                       name=f"scene {scene_id} at {client.place}"))
        try:
            opened = self._messages.next(client.options.deadline)
            if opened is None:
                raise DeadlineExceeded(f"the daemon at {client.place} did not open the watch within "
                                       f"{client.options.deadline:g} s (deadline)")
            if not opened.HasField("opened"):
                raise DataLoss("the first message of a watch does not open it")
        except BaseException:
            self.close()
            raise
        self._see(opened.opened.scene)

    def receive(self, timeout: float | None = None) -> Watched | None:
        """The next frame; None if none came within `timeout` seconds. NotFound once the scene is gone."""
        message = self._messages.next(timeout)
        if message is None:
            return None
        if not message.HasField("done"):
            raise DataLoss("a message of the watch is neither `opened` nor a frame")
        if message.edit_count != self.scene.edit_count:
            self._see(self._client.get_scene(self._scene_id))
        check_limits(message.done.limits, are_asked=False)  # none are shown
        parts = [read_chunk(chunk) for chunk in message.done.contacts]
        del message.done.contacts[:]
        answer = Answer(message.frame_id, message.frame_id, message.done, self._layout, None, False,
                        has_layout=message.edit_count == self.scene.edit_count)
        return Watched(Contacts.of_parts(answer, parts), message.skipped_frames, message.omitted_contacts,
                       {self._name(sample.mesh): self._positions(sample) for sample in message.positions},
                       message.positions[0].vertex_stride if message.positions else 0, message.edit_count)

    def __iter__(self) -> Iterator[Watched]:
        while True:
            try:
                frame = self.receive()
            except NotFound:
                return
            except Cancelled:
                if self._messages.is_cancelled:
                    return
                raise
            assert frame is not None
            yield frame

    def close(self) -> None:
        """Ends the watch; from any thread."""
        self.leftover.take()
        self.leftover.end_streams()

    def __repr__(self) -> str:
        return f"<Watcher of scene {self._scene_id} at {self._client.place}{': closed' if self.leftover.is_over else ''}>"

    def __enter__(self) -> Watcher:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _see(self, scene: scene_pb2.Scene) -> None:
        self.scene = scene
        self._layout = Layout.of_spec(scene.spec)
        self._names.update((i, mesh.name) for i, mesh in self._layout.present())

    def _name(self, mesh: int) -> str:
        if mesh not in self._names:
            raise DataLoss(f"positions names mesh {mesh}, which the scene never had")
        return self._names[mesh]

    def _positions(self, sample: api.VertexSample) -> np.ndarray:
        dtype = shown_dtype(self.scene.spec.position_format)
        if len(sample.positions) % (3 * dtype.itemsize):
            raise DataLoss(f"positions of mesh {sample.mesh} has {len(sample.positions)} bytes, which are no whole positions")
        return np.frombuffer(sample.positions, dtype).reshape(-1, 3)
