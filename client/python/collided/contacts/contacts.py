"""Contacts of a frame as one structured view."""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any

import numpy as np

from collided.contacts.answer import Answer
from collided.contacts.checks import check_done, check_part
from collided.contacts.columns import COLUMNS, Part, joined
from collided.contacts.geometry import closest_points, meshes_of
from collided.contacts.tables import dataframe, records
from collided.errors import FailedPrecondition, InvalidArgument
from collided.v1 import contact_pb2, metrics_pb2

VERTEX_TRIANGLE = contact_pb2.CONTACT_KIND_VERTEX_TRIANGLE
EDGE_EDGE = contact_pb2.CONTACT_KIND_EDGE_EDGE
TRIANGLE_TRIANGLE = contact_pb2.CONTACT_KIND_TRIANGLE_TRIANGLE


class Flag(enum.IntFlag):
    """Masks of a contact's flags: test bits, for more may be added."""

    CERTIFIED = contact_pb2.CONTACT_FLAG_CERTIFIED
    NEAR = contact_pb2.CONTACT_FLAG_NEAR
    CAPPED = contact_pb2.CONTACT_FLAG_CAPPED
    INITIAL = contact_pb2.CONTACT_FLAG_INITIAL
    SEPARATING = contact_pb2.CONTACT_FLAG_SEPARATING


class Contacts:
    """Contacts of one frame, in canonical order: by kind (vertex-triangle, edge-edge, triangle-triangle), then by ids.

    Every array has one row for each contact. An index (a mask, a slice, numbers) gives the contacts that it selects, and so
    do `vt`, `ee`, `tt`, `of_mesh` and `between`; what concerns the whole frame, such as `earliest_toi`, stays as it is.
    Positions of the frame are kept as long as its contacts are.

    A column that the scene did not ask for, or that its mode or level does not compute, raises FailedPrecondition.
    """

    def __init__(self, answer: Answer, count: int, column: Callable[[str], np.ndarray | None]) -> None:
        self.answer = answer
        self._count = count
        self._column_of = column
        self._columns: dict[str, np.ndarray] = {}

    @staticmethod
    def of_parts(answer: Answer, parts: list[Part]) -> Contacts:
        """All contacts of a frame. Raises DataLoss for ids that the scene does not have, and times that are none."""
        check_done(answer.done)
        for part in parts if answer.has_layout else ():
            check_part(part, answer.layout)

        def column(name: str) -> np.ndarray | None:
            if name == "kinds":
                return np.concatenate([np.empty(0, "u1"), *(np.full(part.count, part.kind, "u1") for part in parts)])
            return joined(parts, name)

        return Contacts(answer, sum(part.count for part in parts), column)

    # The frame.

    @property
    def frame_id(self) -> int:
        """Number of the frame in its session, from 1; of a frame that is watched, its wire_id."""
        return self.answer.frame_id

    @property
    def wire_id(self) -> int:
        """The frame's id on the wire, as watchers and the daemon's log have it. It counts frames that a session sends of its
        own, too: one that puts meshes where their vertices are, those that bring a new scene to where the old one was."""
        return self.answer.wire_id

    @property
    def skipped(self) -> bool:
        """Whether a later frame replaced this one (LATEST_WINS), so that it has no contacts."""
        return self.answer.is_skipped

    @property
    def earliest_toi(self) -> float:
        """Earliest time of impact in [0, 1] of the step; 1 where there is none, and where times are not computed."""
        return self.answer.done.earliest_toi

    @property
    def any_contact(self) -> bool:
        """Whether there is a contact, also where none is sent ("any_hit"); candidates do not count."""
        return self.answer.done.any_contact

    @property
    def advanced(self) -> float | None:
        """How far the scene went, in [0, 1], in a frame with `advance`; else None."""
        return self.answer.done.advanced if self.answer.done.HasField("advanced") else None

    @property
    def metrics(self) -> metrics_pb2.FrameMetrics:
        """What the frame cost."""
        return self.answer.done.metrics

    # Columns.

    @property
    def kinds(self) -> np.ndarray:
        """uint8[n]: 1 vertex-triangle, 2 edge-edge, 3 triangle-triangle."""
        return self._column("kinds")

    @property
    def elements(self) -> np.ndarray:
        """uint32[n][2]: scene-wide ids of the two features."""
        return self._column("elements")

    @property
    def stencils(self) -> np.ndarray:
        """uint32[n][4]: scene-wide vertex ids: vertex and triangle, or the ends of both edges; 2^32 - 1 of triangle pairs."""
        return self._column("stencils")

    @property
    def toi(self) -> np.ndarray:
        """float64[n]: time of impact in [0, 1] of the step; not in DCD."""
        return self._column("toi")

    @property
    def distance(self) -> np.ndarray:
        """float64[n]: distance >= 0 at the time of impact, or in the frame (DCD), in the unit of the positions."""
        return self._column("distance")

    @property
    def weights(self) -> np.ndarray:
        """float64[n][2]: where the closest points are: of the triangle's second and third corner, or along each edge."""
        return self._column("weights")

    @property
    def normals(self) -> np.ndarray:
        """float32[n][3]: unit vectors from the second feature to the first."""
        return self._column("normals")

    @property
    def flags(self) -> np.ndarray:
        """uint8[n]: masks of `Flag`."""
        return self._column("flags")

    def has_flag(self, flag: Flag) -> np.ndarray:
        """bool[n]: whether each contact has it: `contacts[contacts.has_flag(Flag.CERTIFIED)]`."""
        return (self.flags & flag) != 0

    @cached_property
    def meshes(self) -> np.ndarray:
        """int64[n][2]: indices of the meshes of the two features. Edge pairs need the field "stencil"."""
        return meshes_of(self)

    @cached_property
    def local_stencils(self) -> np.ndarray:
        """uint32[n][4]: the stencils with vertices numbered within their meshes."""
        offsets = self.answer.layout.vertex_offsets
        owner = np.searchsorted(offsets, self.stencils, side="right") - 1
        is_vertex = self.stencils < offsets[-1]
        return np.where(is_vertex, self.stencils - offsets[np.minimum(owner, len(offsets) - 1)],
                        self.stencils).astype("<u4")

    @cached_property
    def points(self) -> tuple[np.ndarray, np.ndarray]:
        """float64[n][3] each: the closest points of the first and the second feature, at the time of impact, or in the
        frame (DCD). Needs the fields "stencil" and "weights"; NaN of triangle pairs."""
        return closest_points(self)

    # Selections.

    @property
    def vt(self) -> Contacts:
        """Those of a vertex and a triangle, or another loose element."""
        return self[self.kinds == VERTEX_TRIANGLE]

    @property
    def ee(self) -> Contacts:
        """Those of two edges."""
        return self[self.kinds == EDGE_EDGE]

    @property
    def tt(self) -> Contacts:
        """Those of two triangles."""
        return self[self.kinds == TRIANGLE_TRIANGLE]

    def of_mesh(self, mesh: str | int) -> Contacts:
        """Those of which a feature is the mesh's, by name or index."""
        return self[(self.meshes == self.answer.layout.index(mesh)).any(axis=1)]

    def between(self, first: str | int, second: str | int) -> Contacts:
        """Those of two meshes, whichever has the first feature; of a mesh with itself if both are the same."""
        a, b = self.answer.layout.index(first), self.answer.layout.index(second)
        return self[(self.meshes == (a, b)).all(axis=1) | (self.meshes == (b, a)).all(axis=1)]

    def __getitem__(self, index: Any) -> Contacts:
        if isinstance(index, (int, np.integer)) and not isinstance(index, (bool, np.bool_)):
            index = [index]
        try:
            rows = np.arange(self._count)[index]
        except IndexError as error:
            if isinstance(index, list):
                raise
            raise InvalidArgument(f"contacts cannot be indexed so: {error}") from None
        return Contacts(self.answer, len(rows), lambda name: self._column(name)[rows])

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[np.void]:
        """Rows of `records`."""
        return iter(self.records)

    # Other forms.

    @cached_property
    def records(self) -> np.ndarray:
        """A structured array, with a field for each column that the contacts have."""
        return records(self)

    def to_dataframe(self) -> Any:
        """A pandas.DataFrame, a row for each contact; vectors are columns such as `normal_x`. Needs pandas."""
        return dataframe(self)

    def has_column(self, name: str) -> bool:
        """Whether these contacts have a column, such as "weights"."""
        try:
            self._column(name)
        except FailedPrecondition:
            return False
        return True

    def _column(self, name: str) -> np.ndarray:
        if name not in self._columns:
            array = self._column_of(name)
            if array is None:
                raise FailedPrecondition(f"the frame's contacts have no {COLUMNS[name].name}: the scene's fields do not "
                                         "ask for it, or its mode or accuracy does not compute it", field="fields")
            self._columns[name] = array
        return self._columns[name]

    def __repr__(self) -> str:
        names = ((VERTEX_TRIANGLE, "vertex-triangle"), (EDGE_EDGE, "edge-edge"), (TRIANGLE_TRIANGLE, "triangle-triangle"))
        counts = [f"{int((self.kinds == kind).sum())} {name}" for kind, name in names if (self.kinds == kind).any()]
        return f"<Contacts of frame {self.frame_id}: {', '.join(counts) or 'none'}>"
