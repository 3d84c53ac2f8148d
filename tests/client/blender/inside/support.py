"""What the cases share, inside Blender: the installed add-on, objects, and what the package says of the same objects.

Blender is given, after --: ZIP SERVER DAEMON.
"""

import sys
import unittest

import bpy
import numpy as np

ZIP, SERVER, DAEMON = sys.argv[sys.argv.index("--") + 1:]


def install():
    """As the preferences' button does."""
    bpy.ops.preferences.addon_install(filepath=ZIP)
    bpy.ops.preferences.addon_enable(module="collided_blender")


def package():
    """The Python package, as the add-on finds it."""
    from collided_blender.package import collided
    return collided()


def preferences():
    return bpy.context.preferences.addons["collided_blender"].preferences


class Case(unittest.TestCase):
    """Each test in an empty scene."""

    def setUp(self):
        bpy.ops.wm.read_homefile(use_empty=True)
        preferences().server = SERVER
        self.scene = bpy.context.scene
        self.settings = self.scene.collided

    def refused(self, operator, pattern):
        """An operator reports an error, which scripts get as an exception."""
        with self.assertRaisesRegex(RuntimeError, pattern):
            operator()


def mesh(name, vertices, edges=(), faces=(), location=(0, 0, 0), scale=(1, 1, 1)):
    """A selected object."""
    data = bpy.data.meshes.new(name)
    data.from_pydata(vertices, edges, faces)
    thing = bpy.data.objects.new(name, data)
    thing.location, thing.scale = location, scale
    bpy.context.collection.objects.link(thing)
    thing.select_set(True)
    bpy.context.view_layer.objects.active = thing
    bpy.context.view_layer.update()
    return thing


CORNERS = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def cube(name, **options):
    return mesh(name, CORNERS, (), SIDES, **options)


def square(name="square", **options):
    return mesh(name, [(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)], (), [(0, 1, 2, 3)], **options)


def ball(name, radius, location, segments=16):
    bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, location=location, segments=segments, ring_count=segments // 2)
    bpy.context.object.name = name
    return bpy.context.object


def select(*things):
    bpy.ops.object.select_all(action="DESELECT")
    for thing in things:
        thing.select_set(True)


def seen(thing):
    """World positions and triangles of an object as evaluated, apart from the add-on's code."""
    graph = bpy.context.evaluated_depsgraph_get()
    evaluated = thing.evaluated_get(graph)
    data = evaluated.to_mesh()
    data.calc_loop_triangles()
    world = [[float(value) for value in row] for row in evaluated.matrix_world]
    positions = [[sum(world[i][j] * vertex.co[j] for j in range(3)) + world[i][3] for i in range(3)] for vertex in data.vertices]
    triangles = [tuple(triangle.vertices) for triangle in data.loop_triangles]
    evaluated.to_mesh_clear()
    return np.array(positions), np.array(triangles)


def asked(*things, **options):
    """Contacts of objects by the package itself."""
    meshes = {thing.name: package().Mesh(*seen(thing)) for thing in things}
    with package().Session(meshes, server=SERVER, **options) as session:
        return session.step()


def lines(name):
    """Ends of the lines of marks, float32[n][2][3]; none where there is no such object."""
    thing = bpy.data.objects.get(name)
    if thing is None:
        return np.empty((0, 2, 3), np.float32)
    out = np.empty(3 * len(thing.data.vertices), np.float32)
    thing.data.vertices.foreach_get("co", out)
    return out.reshape(-1, 2, 3)


def values(name, attribute):
    """An attribute of marks, a row for each line."""
    data = bpy.data.objects[name].data.attributes[attribute].data
    return np.array([element.value for element in data]).reshape(-1, 2)


def touched_vertices(thing):
    group = thing.vertex_groups.get("collided contacts")
    return [v.index for v in thing.data.vertices if group is not None and any(g.group == group.index for g in v.groups)]


def touched_faces(thing):
    attribute = thing.data.attributes.get("collided faces")
    return [] if attribute is None else [i for i, element in enumerate(attribute.data) if element.value]


def drawn(name):
    """Vertices that the modifier makes of lines, at the scene's frame."""
    thing = bpy.data.objects[name]
    return len(thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices)
