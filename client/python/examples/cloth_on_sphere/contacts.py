"""Contacts as constraints: features that a discrete frame found close are kept apart, with friction."""

import numpy as np

VERTEX_TRIANGLE = 1  # in Contacts.kinds


class Repulsion:
    """Keeps pairs of features a gap apart along their normals; those that are closer come back by `recovery` at most.

    near: contacts of a discrete frame. start: where all vertices of the scene are. inverse_masses: of all vertices, 0
    for those that nothing moves.
    """

    def __init__(self, near, start, inverse_masses, gap, recovery, friction):
        w0, w1 = near.weights.T
        is_vertex = (near.kinds == VERTEX_TRIANGLE)[:, None]
        # What each vertex counts in the vector between the closest points.
        self.shares = np.where(is_vertex, np.stack([np.ones_like(w0), w0 + w1 - 1, -w0, -w1], axis=1),
                               np.stack([1 - w0, w0, w1 - 1, -w1], axis=1))
        self.vertices = near.stencils.astype(np.intp)
        self.normals = near.normals.astype(float)
        self.start = self._apart(start)
        self.wanted = np.minimum(gap, near.distance + recovery)
        self.friction = friction
        moves = inverse_masses[self.vertices] * self.shares
        mobility = np.einsum("ij,ij->i", moves, self.shares)
        self.moves = moves / np.where(mobility > 0, mobility, np.inf)[:, None]

    def push(self, p):
        """Pushes all pairs at once, in place; a vertex of several goes by their average. Returns the worst depth."""
        apart = self._apart(p)
        depth = self.wanted - np.einsum("ij,ij->i", apart, self.normals)
        hit = depth > 0
        if not hit.any():
            return 0.0
        worst = depth.max()
        depth, normals = depth[hit, None], self.normals[hit]
        slid = (apart - self.start)[hit]
        slid -= np.einsum("ij,ij->i", slid, normals)[:, None] * normals
        length = np.sqrt(np.einsum("ij,ij->i", slid, slid))[:, None]
        held = np.minimum(1, self.friction * depth / np.maximum(length, 1e-12))
        change = (depth * normals - held * slid)[:, None, :] * self.moves[hit][:, :, None]
        vertices = self.vertices[hit].ravel()
        count = np.maximum(1, np.bincount(vertices, minlength=len(p)))
        for axis in range(3):
            p[:, axis] += np.bincount(vertices, change[:, :, axis].ravel(), len(p)) / count
        return worst

    def _apart(self, p):
        """The vectors between the points that were the closest."""
        return np.einsum("ij,ijk->ik", self.shares, p[self.vertices])
