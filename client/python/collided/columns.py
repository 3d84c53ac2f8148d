"""The columns of contacts. A column is a row of COLUMNS, in the order of the C interface, and a property of HasColumns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

NO_VERTEX = 2**32 - 1
Values = TypeVar("Values", covariant=True)


@dataclass(frozen=True)
class Column:
    """A field of contacts.

    field: its name in the options of a scene.
    shape: of one entry.
    missing: the value in a kind of contacts that lacks the field.
    parts: the names of its components, in tables that have one number a cell.
    in_limits: contacts that limit the way of an advance have it.
    """

    name: str
    field: str
    dtype: np.dtype
    shape: tuple[int, ...]
    missing: Any
    parts: tuple[str, ...] = ()
    in_limits: bool = True

    @property
    def width(self) -> int:
        """Bytes of one entry."""
        return self.dtype.itemsize * int(np.prod(self.shape, dtype=int))


COLUMNS = {column.name: column for column in (
    Column("elements", "elements", np.dtype("<u4"), (2,), NO_VERTEX, ("first", "second")),
    Column("stencils", "stencil", np.dtype("<u4"), (4,), NO_VERTEX, ("v0", "v1", "v2", "v3")),
    Column("toi", "toi", np.dtype("<f8"), (), np.nan),
    Column("distance", "distance", np.dtype("<f8"), (), np.nan),
    Column("weights", "weights", np.dtype("<f8"), (2,), np.nan, ("w0", "w1")),
    Column("normals", "normal", np.dtype("<f4"), (3,), np.nan, ("normal_x", "normal_y", "normal_z")),
    Column("flags", "flags", np.dtype("u1"), (), 0),
    Column("features", "features", np.dtype("u1"), (), 0, in_limits=False),
    Column("signed_distances", "signed_distance", np.dtype("<f8"), (), np.nan, in_limits=False))}


class HasColumns(Generic[Values]):
    """Contacts, an array for each of their columns."""

    def _column(self, name: str) -> Values:
        raise NotImplementedError

    @property
    def elements(self) -> Values:
        """uint32[n][2]: scene-wide ids of the two features."""
        return self._column("elements")

    @property
    def stencils(self) -> Values:
        """uint32[n][4]: scene-wide vertex ids: vertex and triangle, or the ends of both edges; 2^32 - 1 of triangle pairs."""
        return self._column("stencils")

    @property
    def toi(self) -> Values:
        """float64[n]: time of impact in [0, 1] of the step; not in DCD."""
        return self._column("toi")

    @property
    def distance(self) -> Values:
        """float64[n]: distance >= 0 at the time of impact, or in the frame (DCD), in the unit of the positions. Of a vertex in a solid
        it is minus its depth, < 0."""
        return self._column("distance")

    @property
    def weights(self) -> Values:
        """float64[n][2]: where the closest points are: of the triangle's second and third corner, or along each edge."""
        return self._column("weights")

    @property
    def normals(self) -> Values:
        """float32[n][3]: unit vectors from the second feature to the first."""
        return self._column("normals")

    @property
    def flags(self) -> Values:
        """uint8[n]: masks of `Flag`."""
        return self._column("flags")

    @property
    def features(self) -> Values:
        """uint8[n]: on which features the closest points are, and masks of `Feature`; `OnTriangle.of` and `OnEdge.of` read it. In DCD
        with the report "all", from "fast" on, in a scene on one device; 0 of triangle pairs, edge-triangle and vertex-solid contacts."""
        return self._column("features")

    @property
    def signed_distances(self) -> Values:
        """float64[n]: minus `distance` where the closest point of one feature is inside the other feature's mesh, a solid, else
        `distance`. In DCD with the report "all", from "fast" on, in a scene with a solid. NaN where neither mesh is a solid, of a
        mesh and itself, where one of two features at a distance above 0 meets the other's mesh, and of kinds but vertex-triangle and edge-edge."""
        return self._column("signed_distances")
