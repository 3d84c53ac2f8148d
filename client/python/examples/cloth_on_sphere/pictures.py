"""Draws a simulation: cloth, sphere and floor with light and shadow, and dots where the cloth touches something."""

import numpy as np
from PIL import Image
from raster import View, rasterize

PAPER = np.array([0.96, 0.96, 0.97])
DOTS = {"cloth": np.array([0.85, 0.05, 0.1]), "sphere": np.array([1, 0.55, 0]), "floor": np.array([0, 0.55, 0.35])}  # by what it touches
FADED = 0.4  # so much of the paper's colour is in meshes, where all contacts are marked
FRONT, BACK = np.array([0.22, 0.45, 0.75]), np.array([0.95, 0.70, 0.30])  # sides of the cloth
SMOOTH = 2  # each pixel of a picture is the mean of so many, squared
CHECKS = 10  # along each side of the cloth
COVER = 0.02  # dots are seen through so much cloth, m


class Painter:
    """Pictures of a simulation; size: (columns, rows)."""

    def __init__(self, simulation, size):
        meshes = list(simulation.meshes.values())
        starts = np.cumsum([0, *(mesh.vertex_count for mesh in meshes)])
        self.triangles = np.concatenate([mesh.triangles + start for mesh, start in zip(meshes, starts)])
        self.colours = np.concatenate([COLOURS[name](mesh) for name, mesh in simulation.meshes.items()])
        self.is_floor = np.arange(len(self.triangles)) < len(meshes[0].triangles)
        self.size = size
        self.view = View((0.2, 1, -0.45), (0, 0, 0.42), 2.3, tuple(SMOOTH * side for side in size))
        self.light = View((0.5, 0.9, -1.6), (0, 0, 0.3), 2.6, (700, 700))

    def picture(self, positions, marked):
        """positions: of all meshes. marked: contacts of the cloth, by the mesh that it touches; more than one mesh fades them all."""
        vertices = np.concatenate(list(positions.values())).astype(float)
        seen = rasterize(self.view, vertices, self.triangles)
        image = np.tile(PAPER, (self.view.size[0] * self.view.size[1], 1))
        image[seen.number] = self._lit(seen, vertices)
        if len(marked) > 1:
            image += FADED * (PAPER - image)
        for mesh, contacts in marked.items():
            self._mark(image, seen, (contacts.points[0] + contacts.points[1]) / 2, DOTS[mesh])
        columns, rows = self.size
        image = image.reshape(rows, SMOOTH, columns, SMOOTH, 3).mean(axis=(1, 3))
        return Image.fromarray((255 * np.clip(image, 0, 1)).round().astype("u1"))

    def _lit(self, seen, vertices):
        """The colour of each pixel, in light and shadow."""
        corners = self.triangles[seen.triangle]
        points = np.einsum("ij,ijk->ik", seen.weights, vertices[corners])
        normals = np.einsum("ij,ijk->ik", seen.weights, _normals(vertices, self.triangles)[corners])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        is_front = normals @ self.view.axes[2] < 0
        normals[~is_front] *= -1
        colours = np.where(is_front[:, None], self.colours[seen.triangle, 0], self.colours[seen.triangle, 1])
        is_floor = self.is_floor[seen.triangle][:, None]
        towards = normals @ -self.light.axes[2]
        bright = 0.55 + 0.15 * normals[:, 2] + 0.42 * np.maximum(0, towards) * self._lightness(points, vertices)
        shine = np.maximum(0, normals @ -_unit(self.light.axes[2] + self.view.axes[2]))[:, None] ** 40
        lit = colours * bright[:, None] + 0.12 * shine * ~is_floor
        # The floor ends in the paper, without a rim.
        far = is_floor * np.clip((np.linalg.norm(points[:, :2], axis=1)[:, None] - 0.9) / 0.6, 0, 1)
        return lit + far * (PAPER - lit)

    def _lightness(self, points, vertices):
        """How much light comes to points: 1, or less in shadow, whose rim is soft."""
        columns, rows = self.light.size
        depth = np.full((rows, columns), np.inf)
        lit = rasterize(self.light, vertices, self.triangles)
        depth.reshape(-1)[lit.number] = lit.depth
        at = self.light.project(points)
        column, row = at[:, :2].round().astype(int).T
        light = np.zeros(len(points))
        offsets = [(i, j) for i in (-2, 0, 2) for j in (-2, 0, 2)]
        for i, j in offsets:
            there = depth[np.clip(row + i, 0, rows - 1), np.clip(column + j, 0, columns - 1)]
            light += at[:, 2] < there + 0.015
        return light / len(offsets)

    def _mark(self, image, seen, points, colour):
        """A dot at each point that is not deeper than COVER below what is seen."""
        columns, rows = self.view.size
        depth = np.full(rows * columns, np.inf)
        depth[seen.number] = seen.depth
        at = self.view.project(points)
        column, row = at[:, :2].round().astype(int).T
        shown = (column >= 2) & (column < columns - 2) & (row >= 2) & (row < rows - 2)
        middle = (row * columns + column)[shown]
        middle = middle[at[shown, 2] < depth[middle] + COVER]
        for i, j in ((i, j) for i in range(-2, 3) for j in range(-2, 3) if i * i + j * j < 6):
            image[middle + i * columns + j] = colour


def _floor_colours(mesh):
    return np.full((len(mesh.triangles), 2, 3), 0.93)


def _sphere_colours(mesh):
    """A beach ball, so that its turning shows."""
    x, y, _ = mesh.vertices[mesh.triangles].mean(axis=1).T
    odd = np.floor(4 / np.pi * np.arctan2(y, x)) % 2 == 1
    return np.repeat(np.where(odd[:, None], [0.85, 0.30, 0.28], [0.97, 0.95, 0.92])[:, None], 2, axis=1)


def _cloth_colours(mesh):
    """Checks, so that it shows how the cloth stretches and shears; its back has another colour."""
    cells = int((len(mesh.triangles) // 2)**0.5)
    i, j = np.mgrid[:cells, :cells] * CHECKS // cells
    shade = np.where((i + j) % 2 == 0, 1, 1.15).reshape(-1, 1)
    shade = np.concatenate([shade, shade])  # the first triangle of each cell, then the second
    return np.stack([shade * FRONT, np.minimum(1, shade * BACK)], axis=1)


# Two colours of each triangle of a mesh: of its front and of its back.
COLOURS = {"floor": _floor_colours, "sphere": _sphere_colours, "cloth": _cloth_colours}


def _normals(vertices, triangles):
    """Of all vertices, not of unit length."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    faces = np.cross(b - a, c - a)
    return np.stack([np.bincount(triangles.ravel(), np.repeat(face, 3), len(vertices)) for face in faces.T], axis=1)


def _unit(vector):
    return vector / np.linalg.norm(vector)
