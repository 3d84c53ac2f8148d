"""Objects of lines: from each contact's point on one surface to that on the other, and along each crossing.

Vertices have the attributes `frame`, `distance` and `toi` (time of impact, on the way from the frame before); a modifier makes
tubes of the lines.
"""

import bpy
import numpy as np

from .names import CONTACTS, CROSSINGS, PREFIX
from .tubes import discard, tubes

_COLORS = {CONTACTS: (1.0, 0.4, 0.0, 1.0), CROSSINGS: (0.9, 0.0, 0.05, 1.0)}
_RADIUS = 0.004  # of the size of what was tested


def show(scene, findings, size, by_frame):
    found = {CONTACTS: findings.contacts, CROSSINGS: findings.crossings}
    if not any(found.values()):
        return
    collection = bpy.data.collections.new(PREFIX)
    collection[PREFIX] = True
    scene.collection.children.link(collection)
    for name, lines in found.items():
        if lines:
            thing = bpy.data.objects.new(name, _mesh(name, lines))
            thing[PREFIX] = True
            thing.show_in_front = True
            collection.objects.link(thing)
            modifier = thing.modifiers.new("Tubes", "NODES")
            modifier.node_group = tubes(name, _COLORS[name], _RADIUS * size, by_frame)


def remove(scene):
    for collection in [child for child in scene.collection.children if PREFIX in child]:
        for thing in list(collection.objects):
            if PREFIX in thing:
                groups = {modifier.node_group for modifier in thing.modifiers if modifier.type == "NODES"}
                bpy.data.batch_remove([thing, thing.data])
                for group in filter(None, groups):
                    discard(group)
        if not collection.objects:
            bpy.data.collections.remove(collection)


def _mesh(name, lines):
    ends = np.concatenate([part.ends for part in lines])
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(2 * len(ends))
    mesh.vertices.foreach_set("co", ends.astype(np.float32).reshape(-1))
    mesh.edges.add(len(ends))
    mesh.edges.foreach_set("vertices", np.arange(2 * len(ends), dtype=np.int32))
    _attribute(mesh, "frame", "INT", [np.full(len(part.ends), part.frame, np.int32) for part in lines])
    for field in ("distance", "toi"):
        values = np.concatenate([getattr(part, field) for part in lines])
        if not np.isnan(values).all():
            _attribute(mesh, field, "FLOAT", [values.astype(np.float32)])
    mesh.update()
    return mesh


def _attribute(mesh, name, kind, parts):
    """Of both ends of each line."""
    mesh.attributes.new(name, kind, "POINT").data.foreach_set("value", np.repeat(np.concatenate(parts), 2))
