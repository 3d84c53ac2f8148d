"""The kinds of contacts. A kind is a row of KINDS and a property of HasKinds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

from collided.v1 import contact_pb2

Found = TypeVar("Found", covariant=True)


@dataclass(frozen=True)
class Kind:
    """Which two features touch: its number on the wire, its name, and its short name."""

    number: contact_pb2.ContactKind
    name: str
    short: str


VERTEX_TRIANGLE = Kind(contact_pb2.CONTACT_KIND_VERTEX_TRIANGLE, "vertex_triangle", "vt")
EDGE_EDGE = Kind(contact_pb2.CONTACT_KIND_EDGE_EDGE, "edge_edge", "ee")
TRIANGLE_TRIANGLE = Kind(contact_pb2.CONTACT_KIND_TRIANGLE_TRIANGLE, "triangle_triangle", "tt")
EDGE_TRIANGLE = Kind(contact_pb2.CONTACT_KIND_EDGE_TRIANGLE, "edge_triangle", "et")
VERTEX_SOLID = Kind(contact_pb2.CONTACT_KIND_VERTEX_SOLID, "vertex_solid", "vs")
KINDS = {kind.number: kind for kind in (VERTEX_TRIANGLE, EDGE_EDGE, TRIANGLE_TRIANGLE, EDGE_TRIANGLE, VERTEX_SOLID)}


class HasKinds(Generic[Found]):
    """Contacts of all kinds, and those of each."""

    def _of_kind(self, kind: Kind) -> Found:
        raise NotImplementedError

    @property
    def vt(self) -> Found:
        """Those of a vertex and a triangle, or another loose element."""
        return self._of_kind(VERTEX_TRIANGLE)

    @property
    def ee(self) -> Found:
        """Those of two edges."""
        return self._of_kind(EDGE_EDGE)

    @property
    def tt(self) -> Found:
        """Those of two triangles."""
        return self._of_kind(TRIANGLE_TRIANGLE)

    @property
    def et(self) -> Found:
        """Those of an edge that goes through a triangle."""
        return self._of_kind(EDGE_TRIANGLE)

    @property
    def vs(self) -> Found:
        """Those of a vertex inside another mesh, a solid, and the nearest triangle of that."""
        return self._of_kind(VERTEX_SOLID)
