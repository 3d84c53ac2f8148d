"""Where a scene on a daemon is, and how it got there: what putting another scene in its place takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from collided.errors import FailedPrecondition, InvalidArgument
from collided.frames.advance import Advance
from collided.frames.edit import Applied, apply_edit
from collided.frames.options import FrameOptions, frame_head
from collided.frames.state import State, Way, first_placement, way_of
from collided.frames.updates import Context, Update, updates_of
from collided.layout import Layout
from collided.meshes import Mesh
from collided.options import SceneOptions
from collided.v1 import contact_pb2, frame_pb2, scene_pb2

NOWHERE = -1  # instead of the last frame that a scene has applied: it is not where the track says


@dataclass(eq=False)
class Request:
    """A frame to be sent: its message without updates, its updates, and what its edit makes of the scene.

    way: its own, if it is known before the answer.
    """

    head: frame_pb2.Frame
    updates: list[Update]
    edit: Applied | None = None
    is_counted: bool = True  # False: it brings a new scene to where this one is already
    way: Way | None = None

    @property
    def begun(self) -> frozenset[int]:
        """Meshes that have their first positions in it."""
        return self.edit.begun if self.edit else frozenset()


@dataclass(eq=False)
class Track:
    """The scene as of its last answered frame. `state` is empty before the first one.

    way: of the last frame that was not refused, on which the next one may begin, if the daemon lets it.
    """

    layout: Layout
    options: SceneOptions
    state: State = field(default_factory=dict)
    way: Way | None = None
    last: frame_pb2.Frame = field(default_factory=frame_pb2.Frame)
    last_applied: int = 0  # id on the wire, or NOWHERE
    last_sent: int = 0

    def __post_init__(self) -> None:
        self.form = self.options.format(self.layout)

    @property
    def has_starts(self) -> bool:
        """Whether frames have a beginning and an end."""
        return self.options.mode != "dcd"

    @property
    def creatable(self) -> Layout:
        """The layout as a new scene can have it: with points that `placing` removes."""
        meshes = list(self.layout.meshes)
        for i in self._points:
            meshes[i:i + 1] = [Mesh(points=[0], name=f"collided removed {i}", exclude_rest_pairs=self.options.rest_distance > 0)]
        return replace(self.layout, meshes=tuple(meshes))

    @property
    def _points(self) -> list[int]:
        """Indices at which a new scene has a point at first: of meshes that were removed, so that the others keep theirs; else
        one more where a rest_distance, which edits may need again, is only taken with a mesh that uses it."""
        is_used = any(mesh.exclude_rest_pairs for _, mesh in self.layout.present())
        needs_one = self.options.rest_distance > 0 and not is_used and not self.layout.removed
        return [len(self.layout.meshes)] if needs_one else self.layout.removed

    def has_motion(self, head: frame_pb2.Frame) -> bool:
        """Whether a frame asks what touches on the way, by its mode."""
        return self.has_starts and head.mode != scene_pb2.DETECTION_MODE_DCD

    def tells_pairs(self, head: frame_pb2.Frame, spec: scene_pb2.SceneSpec) -> bool:
        """Returns True if the answer to a frame has states of pairs. spec: that of the scene, as it was created."""
        if contact_pb2.CONTACT_FIELD_PAIR_STATES not in spec.fields or self.has_motion(head):
            return False
        return (head.report or spec.report or scene_pb2.REPORT_ALL) == scene_pb2.REPORT_ALL

    def next_id(self) -> int:
        self.last_sent += 1
        return self.last_sent

    def initial(self) -> State | None:
        """Where the scene is before its first frame; None if a mesh has no vertices."""
        if any(mesh.vertices is None for _, mesh in self.layout.present()):
            return None
        return {i: first_placement(self.form.encode(mesh.vertices, f"vertices of {mesh.name!r}", None), mesh.is_rigid)
                for i, mesh in self.layout.present()}

    def request(self, layout: Layout, is_first: bool, positions: Any, start: Any, options: FrameOptions,
                placed: Sequence[Update] = ()) -> Request:
        """A frame, checked. layout: of the scene by then. is_first: no frame has been sent before. placed: updates that
        `positions` do not have, in memory that they cannot name."""
        head = frame_head(options)
        edit = options.get("edit")
        applied = None if edit is None else apply_edit(edit, layout, self.options.rest_distance == 0)
        context = Context(layout if applied is None else applied.layout, self.form, self.has_starts)
        updates = [*updates_of(context, positions, start), *placed]
        if applied is not None:
            head.edit.CopyFrom(applied.message)
            before = {i for i, _ in layout.present()}
            for index in applied.begun:
                self._begin(context, updates, index, has_start=index in before)
        if is_first:
            for index, _ in layout.present():
                self._begin(context, updates, index, has_start=False)
        return Request(head, updates, applied)

    def _begin(self, context: Context, updates: list[Update], index: int, has_start: bool) -> None:
        """Gives a mesh its first positions, where the frame has none. has_start: it needs to be told where it begins."""
        mesh = context.layout.mesh(index)
        update = next((u for u in updates if u.mesh == index), None)
        if update is None:
            update = Update(index)
            updates.append(update)
        if update.indices is not None:
            raise InvalidArgument(f"positions[{mesh.name!r}] are sparse, and it is the mesh's first frame",
                                  field="positions")
        needs_start = has_start and self.has_starts and mesh.motion == "deformable" and update.start is None
        if update.positions is not None and not (needs_start and mesh.vertices is not None):
            return
        if mesh.vertices is None:
            raise InvalidArgument(f"mesh {mesh.name!r} has no positions: it has no vertices, and positions do not name it",
                                  field="positions")
        vertices = self.form.encode(mesh.vertices, f"vertices of {mesh.name!r}", None)
        update.positions = vertices if update.positions is None else update.positions
        update.start = vertices if needs_start else update.start

    def foresee(self, request: Request) -> None:
        """The way of a frame that was sent with no other in flight, while the daemon is at work. Of a plain one alone: what
        else may be wrong with a frame, the daemon is to say."""
        is_plain = request.edit is None and not request.head.HasField("from_last_fraction")
        request.way = self._way_of(request) if is_plain else None

    def apply(self, request: Request, advance: Advance | None, wire_id: int) -> Way:
        """The frame was answered: the scene is where it left it. The same if it is done again."""
        head = request.head
        request.way = way = self._way_of(request) if request.way is None else request.way
        self.way = way if advance is None else Way(way.start, way.gone(advance), way.layout, self.form)
        self.last = head
        if not head.trial:
            self.state, self.layout, self.last_applied = self.way.end, way.layout, wire_id
        return way

    def layout_of(self, request: Request) -> Layout:
        """Returns what the scene is made of in a frame, if that is the first in flight."""
        return self.layout if request.edit is None else request.edit.layout

    def _way_of(self, request: Request) -> Way:
        """From where the scene is now."""
        head, start = request.head, self.state
        if head.HasField("from_last_fraction") and self.way is not None:
            start = self.way.along(head.from_last_fraction)
        way = way_of(request.updates, start, request.begun, self.layout_of(request), self.form)
        for index in request.edit.rested if request.edit else ():
            way.end[index] = way.end[index].at_rest()
            way.start[index] = replace(way.start[index], rest=way.end[index].rest)  # where a new scene begins the way again
        return way

    def beginning(self, state: State) -> Request:
        """The first frame of a scene whose meshes all have vertices."""
        return Request(frame_pb2.Frame(), [Update(i, positions=place.positions) for i, place in state.items()])

    def placing(self, state: State) -> list[Request]:
        """Frames that bring a new scene of this layout to a state and stand still."""
        places = [(i, mesh, state[i]) for i, mesh in self.layout.present()]
        for _, mesh, place in places:
            if place.positions.dtype != self.form.dtype:
                raise FailedPrecondition(f"mesh {mesh.name!r} is between the steps of Q16 after an advance, where a new "
                                         "scene cannot be put")
        at_rest = {i for i, mesh, place in places if mesh.exclude_rest_pairs and place.rest is not place.positions}
        first = [Update(i, positions=place.rest if i in at_rest else place.positions, pose=place.pose)
                 for i, _, place in places]
        then = [Update(i, positions=place.positions, start=place.positions if self.has_starts else None)
                for i, mesh, place in places if i in at_rest and not mesh.is_rigid]
        removed = frame_pb2.Frame()
        for i in self._points:
            first.append(Update(i, positions=np.zeros((1, 3), self.form.dtype)))
            removed.edit.meshes.add(mesh=i)
        requests = [Request(frame_pb2.Frame(), first, is_counted=False)]
        return requests + [Request(removed, then, is_counted=False)] if then or removed.HasField("edit") else requests

    def replaying(self) -> list[Request]:
        """Frames that bring a new scene of this layout to where this one is, with the last frame's way behind it."""
        if self.way is None or not self.has_starts:
            return self.placing(self.state)
        way = self.way
        begin = self.state if self.last.trial else way.start
        updates = [Update(i, positions=None if end.pose is not None else end.positions, pose=end.pose,
                          start=None if end.pose is not None or way.start[i] is begin[i] else way.start[i].positions,
                          start_pose=None if end.pose is None or way.start[i] is begin[i] else way.start[i].pose)
                   for i, end in way.end.items()
                   if (end is not begin[i] or way.start[i] is not begin[i]) and not way.layout.mesh(i).is_static]
        replay = Request(frame_pb2.Frame(trial=self.last.trial), updates, is_counted=False)
        return [*self.placing(begin), replay]
