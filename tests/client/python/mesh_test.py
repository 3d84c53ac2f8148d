#!/usr/bin/env python3
"""Meshes from files and from other libraries' objects; files are those that collidectl writes, too."""

import os
import pathlib
import subprocess
import tempfile
import types
import unittest

from support import COLLIDECTL, FLOOR, ONE, main, np

import collided

QUAD_OBJ = b"""# a comment
mtllib none.mtl
o thing
v 0 0 0
v 1 0 0 0.5 0.5 0.5
v\t1e0 1 +0
vn 0 0 1
vt 0 0
v 0 1 0.1
f 1/1/1 2//1 3/2 -1
f 1 \\
 3 4
l 1 2 3
p 4
p 1 2
"""
QUAD_PLY = b"""ply
format ascii 1.0
comment none
element vertex 4
property double x
property double y
property double z
property uchar red
element face 2
property list uchar int vertex_indices
property int tag
element edge 1
property int vertex1
property int vertex2
end_header
0 0 0 9
1 0 0 9
1 1 0 9
0 1 0.1 9
4 0 1 2 3 7
3 0 2 3 7
0 1
"""
POSITIONS = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.1]]
FANS = [[0, 1, 2], [0, 2, 3], [0, 2, 3]]


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def put(self, name, data):
        (self.folder / name).write_bytes(data)
        return self.folder / name

    def test_obj_has_polygons_lines_and_points(self):
        marked = b"\xef\xbb\xbf" + QUAD_OBJ.removeprefix(b"# a comment\nmtllib none.mtl\no thing\n")  # by an editor
        for data in (QUAD_OBJ, QUAD_OBJ.replace(b"\n", b"\r\n"), marked):
            mesh = collided.Mesh.read(self.put("quad.obj", data))
            self.assertEqual(mesh.vertices.tolist(), POSITIONS)
            self.assertEqual(mesh.triangles.tolist(), FANS)
            self.assertEqual((mesh.edges.tolist(), mesh.points.tolist()), ([[0, 1], [1, 2]], [3, 0, 1]))

    def test_ply_in_every_encoding(self):
        head, body = QUAD_PLY.split(b"end_header\n")
        self.assertEqual(collided.Mesh.read(self.put("a.ply", QUAD_PLY)).triangles.tolist(), FANS)
        for name, order in (("little", "<"), ("big", ">")):
            data = head.replace(b"ascii", f"binary_{name}_endian".encode()) + b"end_header\n"
            vertex = np.dtype(f"{order}f8,{order}f8,{order}f8,u1")
            data += np.array([(*position, 9) for position in POSITIONS], vertex).tobytes()
            for corners in ([0, 1, 2, 3], [0, 2, 3]):
                data += bytes([len(corners)]) + np.array([*corners, 7], order + "i4").tobytes()
            data += np.array([0, 1], order + "i4").tobytes()
            mesh = collided.Mesh.read(self.put(f"{name}.ply", data))
            self.assertEqual((mesh.vertices.tolist(), mesh.triangles.tolist()), (POSITIONS, FANS))

    def test_polygons_of_many_sizes_keep_their_order(self):
        random = np.random.default_rng(1)
        sizes = random.integers(3, 7, 500)
        rows = [" ".join(map(str, [size, *range(size)])) for size in sizes]
        head = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n"
        text = head + f"element face {len(sizes)}\nproperty list uchar uint vertex_index\nend_header\n"
        mesh = collided.Mesh.read(self.put("m.ply", (text + "0 0 0\n" * 6 + "\n".join(rows)).encode()))
        expected = [[0, i, i + 1] for size in sizes for i in range(1, size - 1)]
        self.assertEqual(mesh.triangles.tolist(), expected)

    def test_files_of_collidectl_keep_every_bit(self):
        subprocess.run([COLLIDECTL, "export", "--scene", "funnel", "--scale", "0.3", "--frames", "1", "--out",
                        self.folder / "frames"], check=True, stdout=subprocess.DEVNULL)
        (ply,) = (self.folder / "frames").glob("*.ply")
        mesh = collided.Mesh.read(ply)
        self.assertEqual(mesh.vertices.dtype, np.dtype("<f8"))
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
        lines += [f"f {a} {b} {c}" for a, b, c in (mesh.triangles.astype(int) + 1).tolist()]
        again = collided.Mesh.read(self.put("again.obj", "\n".join(lines).encode()))
        np.testing.assert_array_equal(again.vertices, mesh.vertices)
        np.testing.assert_array_equal(again.triangles, mesh.triangles)

    def test_what_cannot_be_read_is_named(self):
        for name, data, pattern in (
                ("a.stl", b"", r"the extension must be .obj or .ply"),
                ("a.obj", b"v 0 0\n", "fewer than three|not three"), ("a.obj", b"v 0 0 x\n", "not three numbers"),
                ("a.obj", b"v 0 0 inf\n", "line 1: position .* is not finite"),
                ("a.obj", b"v 0 0 0\nf 1 1 9\n", "line 2: vertex index 9 is out of range; there are 1"),
                ("a.obj", b"v 0 0 0\nf 0 1 1\n", "vertex index 0 is out of range"),
                ("a.obj", b"v 0 0 0\nf -2 1 1\n", "vertex index -2 is out of range"),
                ("a.obj", b"v 0 0 0\nf 1 1\n", "has 2 corners; it needs 3"),
                ("a.obj", b"v 0 0 0\nl 1\n", "has 1 vertices; it needs 2"),
                ("a.obj", b"v 0 0 0\nf a b c\n", "an index is not a number"),
                ("a.ply", b"ply\n", "does not begin with a PLY header"), ("a.ply", b"", "does not begin"),
                ("a.ply", QUAD_PLY.replace(b"double x", b"real x"), "line 5 of the header cannot be read"),
                ("a.ply", QUAD_PLY.replace(b"vertex 4", b"vertex 4000000000"), "do not fit in"),
                ("a.ply", QUAD_PLY.replace(b"property double z\n", b""), "lacks one of the properties x, y, z"),
                ("a.ply", QUAD_PLY.replace(b"format ascii 1.0\n", b""), "names no format"),
                ("a.ply", QUAD_PLY[:-22], "cut off|not a number"), ("a.ply", QUAD_PLY.replace(b"3 0 2 3", b"3 0 2 9"), "out of range"),
                ("a.ply", QUAD_PLY.replace(b"4 0 1", b"-4 0 1"), "length -4"),
                ("a.ply", QUAD_PLY.replace(b"uchar int vertex", b"uchar float vertex"), "vertex_indices has a floating-point"),
                ("a.ply", QUAD_PLY.replace(b"uchar int vertex", b"double int vertex"), "vertex_indices has a floating-point"),
                ("a.ply", QUAD_PLY.replace(b"3 0 2 3", b"3 0 1.5 3"), "vertex index 1.5 is not an integer"),
                ("a.ply", QUAD_PLY.replace(b"4 0 1 2 3", b"2 0 1"), "cut off|corners")):
            with self.subTest(pattern, data=data[-20:]), self.assertRaisesRegex(collided.InvalidArgument, pattern):
                collided.Mesh.read(self.put(name, data))
        with self.assertRaises(FileNotFoundError):
            collided.Mesh.read(self.folder / "none.obj")

    def test_what_is_no_file_of_a_size_that_can_be_is_not_waited_for(self):
        os.mkfifo(self.folder / "fifo.obj")
        (self.folder / "endless.ply").symlink_to("/dev/zero")
        with (self.folder / "large.obj").open("wb") as file:
            file.truncate((8 << 30) + 1)  # of holes
        for name, pattern in (("fifo.obj", "fifo.obj: it is not a regular file"), ("endless.ply", "it is not a regular file"),
                              ("large.obj", "it has 8589934593 bytes; the limit is 8589934592")):
            with self.assertRaisesRegex(collided.InvalidArgument, pattern):
                collided.Mesh.read(self.folder / name)


class Objects(unittest.TestCase):
    def test_what_looks_like_trimesh_meshio_or_a_pair_is_a_mesh(self):
        trimesh = types.SimpleNamespace(vertices=FLOOR, faces=ONE.astype(np.int64))
        cells = {"triangle": ONE, "quad": np.array([[0, 1, 2, 3]]), "line": np.array([[0, 3]]), "vertex": np.array([[2]]),
                 "tetra": np.array([[0, 1, 2, 3]])}
        meshio = types.SimpleNamespace(points=np.array(POSITIONS), cells_dict=cells)
        for source in (trimesh, (FLOOR, ONE), [FLOOR, ONE], {"vertices": FLOOR, "triangles": ONE}):
            mesh = collided.Mesh.of(source, motion="static")
            self.assertEqual((mesh.triangles.tolist(), mesh.vertices.tolist(), mesh.motion), ([[0, 1, 2]], FLOOR.tolist(), "static"))
        mesh = collided.Mesh.of(meshio)
        self.assertEqual(mesh.triangles.tolist(), [[0, 1, 2], [0, 1, 2], [0, 2, 3]])
        self.assertEqual((mesh.edges.tolist(), mesh.points.tolist()), ([[0, 3]], [2]))
        self.assertEqual(collided.Mesh.of(ONE).vertex_count, 3)

    def test_points_of_the_plane_lie_at_zero(self):
        flat = types.SimpleNamespace(points=FLOOR[:, :2], cells_dict={"triangle": ONE})
        self.assertEqual(collided.Mesh.of(flat).vertices.tolist(), FLOOR.tolist())

    def test_a_mesh_keeps_its_vertices_whatever_becomes_of_the_callers(self):
        vertices = FLOOR.copy()
        mesh = collided.Mesh(vertices, ONE)
        vertices[:] = 7
        np.testing.assert_array_equal(mesh.vertices, FLOOR)


if __name__ == "__main__":
    main()
