"""Contacts of a frame as one structured view."""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any

import numpy as np

from collided.columns import COLUMNS, HasColumns
from collided.contacts.answer import Answer
from collided.contacts.checks import LIMITS, check_done, check_part
from collided.contacts.columns import Part, joined
from collided.contacts.geometry import closest_points, meshes_of
from collided.contacts.pairs import MeshPairs
from collided.contacts.tables import dataframe, records
from collided.errors import FailedPrecondition, InvalidArgument
from collided.frames.advance import Shortened
from collided.kinds import KINDS, HasKinds, Kind
from collided.v1 import contact_pb2, metrics_pb2


class Flag(enum.IntFlag):
    """Masks of a contact's flags: test bits, for more may be added."""

    CERTIFIED = contact_pb2.CONTACT_FLAG_CERTIFIED
    NEAR = contact_pb2.CONTACT_FLAG_NEAR
    CAPPED = contact_pb2.CONTACT_FLAG_CAPPED
    INITIAL = contact_pb2.CONTACT_FLAG_INITIAL
    SEPARATING = contact_pb2.CONTACT_FLAG_SEPARATING
    COVERED = contact_pb2.CONTACT_FLAG_COVERED
    TOUCHING = contact_pb2.CONTACT_FLAG_TOUCHING


class Contacts(HasColumns[np.ndarray], HasKinds["Contacts"]):
    """Contacts of one frame, in canonical order: by kind (vertex-triangle, edge-edge, triangle-triangle, edge-triangle,
    vertex-solid), then by ids.

    Every array has one row for each contact. An index (a mask, a slice, numbers) gives the contacts that it selects, and so
    do `vt`, `ee`, `tt`, `et`, `vs`, `of_mesh` and `between`; what concerns the whole frame, such as `earliest_toi`, stays as it is.
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
        for part in answer.limits:
            check_part(part, answer.layout, LIMITS)
        return Contacts._of_checked(answer, parts)

    @staticmethod
    def _of_checked(answer: Answer, parts: list[Part]) -> Contacts:
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
        """How far the scene went, in [0, 1], in a frame with `advance`; else None. It is the least fraction of anything that moves."""
        return self.answer.done.advanced if self.answer.done.HasField("advanced") else None

    @property
    def way(self) -> float | None:
        """The share of the motion that was gone, in [0, 1], in a frame with `advance`; else None. It divides the summed lengths of
        the ways that vertices went by those of their whole ways."""
        return self.answer.done.way if self.answer.done.HasField("way") else None

    @property
    def shortened(self) -> Shortened:
        """Lists what did not go all of its way in a frame with `advance="per_mesh"` or `"per_vertex"`. Frames that are watched have
        none."""
        return Shortened() if self.answer.advance is None else self.answer.advance.shortened

    def fractions(self, mesh: str | int) -> np.ndarray:
        """float64[n]: how far each vertex of a mesh went, in [0, 1], in a frame with `advance`. `move_along` takes it.

        Raises FailedPrecondition for a frame without `advance`, and for one that is watched."""
        if self.answer.advance is None:
            raise FailedPrecondition(f"frame {self.frame_id} has no fractions: it was sent without advance, or is watched",
                                     field="advance")
        index = self.answer.layout.index(mesh)
        return np.full(self.answer.layout.mesh(index).vertex_count, self.answer.advance.fraction(index))

    @cached_property
    def limits(self) -> Contacts:
        """Contacts that limit the way, in a frame with `limits=True`; else none. A selection of contacts has those of the whole frame.

        The whole way would bring each of these pairs nearer than it may come, or is not certain to keep it that far apart. They are
        vertex-triangle and edge-edge, in canonical order, and have every column but `features` and `signed_distances`, whatever the scene's fields are.
        `distance` is the least that a pair keeps, in the unit of the positions. `toi`, in [0, 1], is the fraction of the whole way at
        which the pair comes to that distance, and never later than in truth. Weights, normals and points are those of `toi`."""
        return Contacts._of_checked(self.answer, self.answer.limits)

    @property
    def pairs(self) -> MeshPairs:
        """Says which meshes touch, overlap, or are one inside the other: the pairs, one of them a solid, that are not apart. A selection
        of contacts has the pairs of the whole frame.

        Raises FailedPrecondition for frames without them: frames of CCD, with a report of one contact, or of a scene without the field
        "pair_states", and frames that are watched."""
        if self.answer.pairs is None:
            raise FailedPrecondition(f"frame {self.frame_id} has no states of pairs: frames of DCD with the report \"all\" have them, in "
                                     'scenes with a solid and the field "pair_states"', field="fields")
        return self.answer.pairs

    @property
    def metrics(self) -> metrics_pb2.FrameMetrics:
        """What the frame cost."""
        return self.answer.done.metrics

    # Columns.

    @property
    def kinds(self) -> np.ndarray:
        """uint8[n]: 1 vertex-triangle, 2 edge-edge, 3 triangle-triangle, 4 edge-triangle, 5 vertex-solid."""
        return self._column("kinds")

    def has_flag(self, flag: Flag) -> np.ndarray:
        """bool[n]: whether each contact has it: `contacts[contacts.has_flag(Flag.CERTIFIED)]`."""
        return (self.flags & flag) != 0

    @property
    def kept(self) -> Contacts:
        """Contacts that no other one covers, in DCD. They have each local minimum of distance between two surfaces once. So all of them
        have one direction on a flat floor, which is what a rigid-body solver needs. Nothing is covered unless the scene asks for
        `features` and has the kinds "vt" and "ee". Needs the field "flags"."""
        return self[~self.has_flag(Flag.COVERED)]

    @cached_property
    def meshes(self) -> np.ndarray:
        """int64[n][2]: indices of the meshes of the two features. Edge pairs need the field "stencil"; edges that go through
        triangles need the elements of the meshes, which frames that are watched do not have."""
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
        frame (DCD). Needs the fields "stencil" and "weights"; NaN of triangle pairs. Both are where the edge meets the triangle,
        of edge-triangle contacts."""
        return closest_points(self)

    # Selections.

    def _of_kind(self, kind: Kind) -> Contacts:
        return self[self.kinds == kind.number]

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
        counts = [f"{count} {kind.name.replace('_', '-')}" for kind in KINDS.values() if (count := len(self._of_kind(kind)))]
        return f"<Contacts of frame {self.frame_id}: {', '.join(counts) or 'none'}>"
