"""Many scenes of one spec, stepped together: robot cells, environments of reinforcement learning."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from collided.arrays import check_length, ids, numbers
from collided import leftovers
from collided.choices import choice
from collided.connection.client import Client
from collided.contacts import Contacts
from collided.contacts.answer import Answer
from collided.errors import DataLoss, Error, InvalidArgument, error_of_frame
from collided.frames.updates import Update
from collided.layout import Layout
from collided.leftovers import Leftover
from collided.meshes.mesh import counted
from collided.options import SceneOptions
from collided.scene import Resident, divided
from collided.transport.opening import StreamOptions
from collided.set_frames import SetAnswer, SetFrames
from collided.v1 import frame_pb2, metrics_pb2, scene_pb2


class WorldContacts(Mapping[int, Contacts]):
    """The contacts of one step, by world: a mapping from the worlds in the frame to Contacts, whose ids are counted in each
    world as in a scene of its own. (The contacts know no positions, so that they have no `points`.)

    all: contacts of all worlds; each array has one row for each contact, by kind, then by world.
    worlds: int64[w], the worlds in the frame.
    refused: the Error of each world whose frame was refused, which is as it was; its contacts are none.
    """

    def __init__(self, layout: Layout, worlds: np.ndarray, answer: SetAnswer) -> None:
        self.worlds = worlds
        self.refused: dict[int, Error] = {error.world: error_of_frame(error.error, answer.frame_id) for error in answer.errors}
        parts, self._begins = answer.parts, answer.begins
        self._offsets = np.cumsum([0, *(part.count for part in parts)])
        done = Answer(answer.frame_id, answer.frame_id, answer.done, layout, None, False)
        self.all = Contacts.of_parts(done, parts)
        self._places = {int(world): i for i, world in enumerate(worlds)}

    @property
    def any_contact(self) -> bool:
        """Whether some world has a contact; candidates do not count."""
        return self.all.any_contact

    @property
    def earliest_toi(self) -> float:
        """Earliest time of impact in [0, 1] of all worlds; 1 where there is none."""
        return self.all.earliest_toi

    @property
    def metrics(self) -> metrics_pb2.FrameMetrics:
        """What the step of all worlds together cost."""
        return self.all.metrics

    @cached_property
    def counts(self) -> np.ndarray:
        """int64[w]: contacts of each world in the frame."""
        return sum((np.diff(begin) for begin in self._begins), start=np.zeros(len(self.worlds), np.int64))

    @cached_property
    def world_of(self) -> np.ndarray:
        """int64[n]: the world of each row of `all`."""
        return np.concatenate([np.empty(0, np.int64), *(np.repeat(self.worlds, np.diff(begin)) for begin in self._begins)])

    def __getitem__(self, world: int) -> Contacts:
        i = self._places[world]
        rows = [np.arange(begin[i], begin[i + 1]) + offset for begin, offset in zip(self._begins, self._offsets)]
        return self.all[np.concatenate([np.empty(0, np.int64), *rows])]

    def __iter__(self) -> Any:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self.worlds)

    def __repr__(self) -> str:
        return f"<{len(self.all)} contacts in {len(self)} worlds, {len(self.refused)} refused>"


class SceneBatch:
    """A set of `count` scenes of the same meshes on a daemon, as a context manager: made at the beginning, deleted at the
    end. Its scenes are the worlds 0 to count - 1: each has positions of its own, and none touches another. Triangles are
    sent and held once, and one call steps all worlds.

    meshes, server, lease_seconds, options: as of Scene; meshes are deformable or static, and the report is "all".
    count: 1 to 65,536.
    transport: "shared_memory", "grpc", "calls" (deprecated: DetectBatch, without a stream, which takes about twice as long), or
        "auto": the first of these that the daemon offers and grants.
    output_bytes: room for a step's contacts in shared memory; what has none comes over the socket, which is slower.
    daemon_user: as of Session.

    Not for several threads at once. After a loss of the connection the next step connects again.
    """

    def __init__(self, meshes: Any, count: int, *, server: str | Client | None = None, lease_seconds: float = 0.0,
                 transport: str = "auto", output_bytes: int = 32 << 20, daemon_user: int | None = None,
                 **options: Any) -> None:
        stream = StreamOptions(window=1, delivery=0, transport=transport, output_bytes=output_bytes, edit_bytes=0,
                               daemon_user=daemon_user)
        connect, scene = divided(options, server)
        self.options = SceneOptions(**scene)
        self.layout = Layout.of(meshes, self.options.exclude)
        self._form = self.options.format(self.layout)
        self.client = server if isinstance(server, Client) else Client(server, **connect)
        self.message = self.client.create_scenes(self.layout, self.options, count, lease_seconds)
        self._resident = Resident(self.client, not isinstance(server, Client), self.message)
        if self.message.worlds != count:
            self._resident.delete()
            raise DataLoss(f"scenes.worlds is {self.message.worlds}; {count} were asked for")
        self._frames = SetFrames(self.client, self.message, stream)
        self._leftover = leftovers.watch(self, Leftover("SceneBatch", [self._frames.close], self._resident))
        self._has_frame = np.zeros(count, bool)
        self._process = os.getpid()

    @property
    def id(self) -> str:
        """The daemon's id of the set."""
        return self.message.scene_id

    @property
    def count(self) -> int:
        """Number of worlds."""
        return self.message.worlds

    @property
    def is_local(self) -> bool:
        """Whether the last step went through shared memory."""
        return self._frames.is_local

    def step(self, positions: Any, *, start: Any = None, worlds: Sequence[int] | np.ndarray | None = None,
             mode: str | None = None, accuracy: str | None = None, delta: float | None = None) -> WorldContacts:
        """One step of all worlds, or of those that are named; the others stay where they are.

        positions: real numbers of shape (w, n, 3) for w worlds, in their order, in the unit of the positions: of all
            vertices of the meshes in their order, or of those that are not static. In a world's first frame static meshes
            are where their `vertices` are, if those are left out.
        start: the same at t = 0 (CCD); None: where each world's last frame left it, in its first frame where `positions` are.
        worlds: integers, strictly ascending, from 0 to count - 1; None: all.
        mode, accuracy, delta: for this frame, as in FrameOptions.

        Raises Error where the whole frame is refused; worlds that are refused by themselves are in the result.
        """
        chosen = self._worlds(worlds)
        first = ~self._has_frame[chosen]
        if first.any() and not first.all() and self._has_static():
            raise InvalidArgument(f"world {chosen[first][0]} has had no frame and world {chosen[~first][0]} has: static "
                                  "meshes come with the first alone; step them one after the other", field="worlds")
        head = frame_pb2.Frame(worlds=[] if worlds is None else chosen.tolist(),
                               mode=choice(scene_pb2.DetectionMode, "DETECTION_MODE_", mode, "mode"),
                               accuracy=choice(scene_pb2.Accuracy, "ACCURACY_", accuracy, "accuracy"))
        if delta is not None:
            check_length(delta, "delta")
            head.delta = delta
        update = Update(0, self._encode(positions, "positions", len(chosen), bool(first.any())))
        if start is not None:
            update.start = self._encode(start, "start", len(chosen), bool(first.any()))
        contacts = WorldContacts(self.layout, chosen, self._frames.ask(head, update, chosen))
        self._has_frame[[world for world in chosen if world not in contacts.refused]] = True
        return contacts

    def close(self) -> None:
        """Deletes the set, and ends the connection unless it was the caller's.

        A daemon that is gone or does not answer is left alone, as by `Scene.close`; so is everything in a process that was
        forked from the set's.
        """
        if os.getpid() != self._process:
            return
        self._leftover.take()
        self._leftover.end_streams()
        self._resident.delete()

    def __repr__(self) -> str:
        return f"<SceneBatch of {self._resident.name}: {'closed' if self._leftover.is_over else counted(self.count, 'world')}>"

    def __enter__(self) -> SceneBatch:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _worlds(self, worlds: Sequence[int] | np.ndarray | None) -> np.ndarray:
        if worlds is None:
            return np.arange(self.count)
        chosen = ids(worlds, "worlds").astype(np.int64)
        if not len(chosen) or chosen[-1] >= self.count or (np.diff(chosen) <= 0).any():
            raise InvalidArgument(f"worlds are {chosen.tolist()[:8]}; they must ascend strictly, one or more, below "
                                  f"{self.count}", field="worlds")
        return chosen

    def _has_static(self) -> bool:
        return any(mesh.is_static for _, mesh in self.layout.present())

    def _encode(self, values: Any, argument: str, worlds: int, is_first: bool) -> np.ndarray:
        array = numbers(values, argument)
        moving = sum(mesh.vertex_count for _, mesh in self.layout.present() if not mesh.is_static)
        every = int(self.layout.vertex_offsets[-1])
        if array.ndim != 3 or array.shape[0] != worlds or array.shape[1] not in (every, moving) or array.shape[2] != 3:
            shapes = " or ".join(f"({worlds}, {n}, 3)" for n in sorted({every, moving}, reverse=True))
            raise InvalidArgument(f"{argument} has shape {array.shape}; it must be {shapes}", field=argument)
        if is_first and array.shape[1] != every:
            array = self._with_static(array)
        return self._form.encode(array.reshape(-1, 3), argument, None)

    def _with_static(self, array: np.ndarray) -> np.ndarray:
        """Static meshes where their vertices are, in every world."""
        parts, at = [], 0
        for _, mesh in self.layout.present():
            if not mesh.is_static:
                parts.append(array[:, at:at + mesh.vertex_count])
                at += mesh.vertex_count
            elif mesh.vertices is None:
                raise InvalidArgument(f"static mesh {mesh.name!r} has no vertices, and the first positions leave it out",
                                      field="positions")
            else:
                parts.append(np.broadcast_to(mesh.vertices, (len(array), *mesh.vertices.shape)))
        return np.concatenate(parts, axis=1)

