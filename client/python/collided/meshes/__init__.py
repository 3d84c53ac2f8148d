"""Meshes: what a scene is made of, and where they come from."""

from collided.meshes.mesh import Mesh, as_mesh

__all__ = ["Mesh", "as_mesh"]
