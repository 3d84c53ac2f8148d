"""Touched vertices as a vertex group, touched faces as a face attribute of the objects' own meshes."""

import numpy as np

from .names import CONTACTS, FACES


def mark(search):
    """Objects whose modifiers make other faces, and those of linked files, have no place for marks: returns their names."""
    skipped = []
    for place, thing in enumerate(search.objects):
        vertices, polygons = search.findings.vertices[place], search.findings.polygons[place]
        if not vertices:
            continue
        if not search.has_own_faces[place] or thing.library or thing.data.library:
            skipped.append(thing.name)
            continue
        group = thing.vertex_groups.get(CONTACTS) or thing.vertex_groups.new(name=CONTACTS)
        group.add(sorted(vertices), 1, "REPLACE")
        _add_faces(thing.data, polygons)
    return skipped


def _add_faces(mesh, polygons):
    """To those that another object of the same mesh has marked."""
    attribute = mesh.attributes.get(FACES) or mesh.attributes.new(FACES, "BOOLEAN", "FACE")
    values = touched_faces(mesh)
    values[sorted(polygons)] = True
    attribute.data.foreach_set("value", values)


def touched_faces(mesh):
    """bool[n]: the faces that are marked; all False in a mesh without marks."""
    attribute = mesh.attributes.get(FACES)
    values = np.zeros(len(mesh.polygons), bool)
    if attribute is not None:
        attribute.data.foreach_get("value", values)
    return values


def remove(scene):
    for thing in (thing for thing in scene.objects if thing.type == "MESH"):
        group, attribute = thing.vertex_groups.get(CONTACTS), thing.data.attributes.get(FACES)
        if group is not None and not thing.library and not thing.data.library:
            thing.vertex_groups.remove(group)
        if attribute is not None and not thing.data.library:
            thing.data.attributes.remove(attribute)
