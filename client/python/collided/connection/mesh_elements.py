"""What a mesh of a living scene is made of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from collided.arrays import OneLine
from collided.errors import Aborted, DataLoss, InvalidArgument
from collided.v1 import collision_service_pb2 as api

_TRIES = 8


@dataclass(frozen=True, eq=False, repr=False)
class MeshElements(OneLine):
    """A mesh as it was at `edit_count` (Scene.edit_count).

    elements: uint32[n][3], in the order of their scene-wide ids: triangles, then loose edges as a b b, then loose points as
        a a a. Vertices are numbered within the mesh.
    vertex_count: 0 if the mesh was removed.
    """

    elements: np.ndarray
    vertex_count: int
    edit_count: int

    @property
    def triangles(self) -> np.ndarray:
        """uint32[n][3]."""
        return self.elements[self.elements[:, 1] != self.elements[:, 2]]

    @property
    def edges(self) -> np.ndarray:
        """uint32[n][2]: loose edges."""
        a, b, c = self.elements.T
        return self.elements[(a != b) & (b == c), :2]

    @property
    def points(self) -> np.ndarray:
        """uint32[n]: loose points."""
        a, b, c = self.elements.T
        return self.elements[(a == b) & (b == c), 0]


def read_elements(page_from: Callable[[int], api.GetMeshResponse]) -> MeshElements:
    """All pages, where `page_from` gives the one from an element on; from the start again if the scene is edited meanwhile."""
    for _ in range(_TRIES):
        first = page_from(0)
        pages = _pages(first, page_from)
        if pages is None:
            continue
        elements = np.concatenate(pages)
        if elements.size and elements.max() >= first.vertex_count:
            raise DataLoss(f"elements name vertex {elements.max()} of {first.vertex_count}")
        return MeshElements(elements, first.vertex_count, first.edit_count)
    raise Aborted(f"the scene was edited while the mesh was read, {_TRIES} times")


def _pages(first: api.GetMeshResponse, page_from: Callable[[int], api.GetMeshResponse]) -> list[np.ndarray] | None:
    """None if the scene was edited between two pages."""
    pages = [_elements(first, 0)]
    read = len(pages[0])
    while read < first.element_count:
        try:
            page = page_from(read)
        except InvalidArgument as error:
            if error.field == "first_element":  # the mesh has fewer now
                return None
            raise
        if page.edit_count != first.edit_count:
            return None
        pages.append(_elements(page, read))
        read += len(pages[-1])
    return pages


def _elements(page: api.GetMeshResponse, before: int) -> np.ndarray:
    count = len(page.elements) // 12
    if len(page.elements) % 12 or before + count > page.element_count or (not count and before < page.element_count):
        raise DataLoss(f"elements has {len(page.elements)} bytes after {before} of {page.element_count} elements")
    return np.frombuffer(page.elements, "<u4").reshape(-1, 3)
