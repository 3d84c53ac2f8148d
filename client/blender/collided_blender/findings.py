"""What was found: contacts and crossings by frame, and which vertices and faces they touch."""

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from .crossings import crossing_segments

_EDGE_EDGE, _TRIANGLE_TRIANGLE = 2, 3


@dataclass(frozen=True, eq=False)
class Lines:
    """Lines that show contacts or crossings of a frame, float64[n][2][3], and what is known of each, float64[n]."""

    frame: int
    ends: np.ndarray
    distance: np.ndarray
    toi: np.ndarray


class Findings:
    """Of objects, which have numbers."""

    def __init__(self):
        self.contacts, self.crossings = [], []
        self.vertices, self.polygons = defaultdict(set), defaultdict(set)  # by object
        self.by_frame = defaultdict(lambda: [0, 0])

    def add(self, frame, contacts, shapes):
        """What the daemon says of a frame. shapes: of the objects that it was asked about, by their numbers, in its order."""
        pairs = contacts.kinds == _TRIANGLE_TRIANGLE
        if (~pairs).any():
            self._add_contacts(frame, contacts[~pairs], shapes)
        if pairs.any():
            self._add_crossings(frame, contacts[pairs], shapes)
        self.by_frame[frame][0] += int((~pairs).sum())
        self.by_frame[frame][1] += int(pairs.sum())

    @property
    def count(self):
        """Numbers of contacts and of crossings."""
        return tuple(sum(counts[i] for counts in self.by_frame.values()) for i in range(2))

    @property
    def frames(self):
        """Those in which there is anything, in order."""
        return sorted(frame for frame, counts in self.by_frame.items() if any(counts))

    def _add_contacts(self, frame, contacts, shapes):
        self.contacts.append(Lines(frame, np.stack(contacts.points, axis=1), _column(contacts, "distance"),
                                   _column(contacts, "toi")))
        is_edges = contacts.kinds == _EDGE_EDGE
        stencils, meshes = contacts.local_stencils, contacts.meshes
        sides = np.where(is_edges[:, None], [0, 0, 1, 1], [0, 1, 1, 1])
        owners = np.take_along_axis(meshes, sides, axis=1)
        triangles = _local_elements(contacts, shapes)[:, 1]
        for mesh, (thing, shape) in enumerate(shapes.items()):
            self.vertices[thing].update(stencils[owners == mesh].tolist())
            is_second = ~is_edges & (meshes[:, 1] == mesh) & (triangles < len(shape.triangles))
            self.polygons[thing].update(shape.polygons[triangles[is_second]].tolist())
            for side in range(2):
                ends = stencils[is_edges & (meshes[:, side] == mesh)][:, 2 * side:2 * side + 2]
                self.polygons[thing].update(_polygons_at(shape, ends))

    def _add_crossings(self, frame, contacts, shapes):
        meshes, triangles = contacts.meshes, _local_elements(contacts, shapes)
        corners = np.empty((len(contacts), 2, 3, 3))
        for mesh, (thing, shape) in enumerate(shapes.items()):
            mine = meshes == mesh
            own = triangles[mine]
            corners[mine] = shape.vertices[shape.triangles[own]]
            self.vertices[thing].update(shape.triangles[own].reshape(-1).tolist())
            self.polygons[thing].update(shape.polygons[own].tolist())
        nothing = np.full(len(contacts), np.nan)
        self.crossings.append(Lines(frame, crossing_segments(corners[:, 0], corners[:, 1]), nothing, nothing))


def _column(contacts, name):
    return getattr(contacts, name) if contacts.has_column(name) else np.full(len(contacts), np.nan)


def _local_elements(contacts, shapes):
    """Elements numbered within their meshes; of no use for edges, which are numbered apart."""
    counts = [len(shape.triangles) + len(shape.edges) + len(shape.points) for shape in shapes.values()]
    return contacts.elements.astype(np.int64) - np.cumsum([0, *counts])[contacts.meshes]


def _polygons_at(shape, ends):
    """Faces that have these edges, int[n][2]."""
    if not len(ends):
        return []
    width = len(shape.vertices)
    wanted = np.unique(_keys(ends[:, 0], ends[:, 1], width))
    sides = [_keys(shape.triangles[:, i], shape.triangles[:, (i + 1) % 3], width) for i in range(3)]
    return np.unique(shape.polygons[np.isin(np.stack(sides), wanted).any(axis=0)]).tolist()


def _keys(first, second, width):
    """A number for each undirected edge."""
    first, second = first.astype(np.int64), second.astype(np.int64)
    return np.minimum(first, second) * width + np.maximum(first, second)
