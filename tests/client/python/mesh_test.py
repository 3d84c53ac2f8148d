#!/usr/bin/env python3
"""Meshes from files and from other libraries' objects; files are those that collidectl writes, too."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import types
import unittest
from fractions import Fraction

from support import COLLIDECTL, FLOOR, ONE, main, np

import collided

TABLE = pathlib.Path(__file__).resolve().parents[2] / "support" / "mesh_files" / "table.py"
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


READ_MESHES = sys.argv[5]
# Bytes and words that a damaged file has in place of others.
DAMAGE = [*(bytes([byte]) for byte in b"0149-.,\"<>{}[] \n#\0\xff\x0b&/"), b"+-1", b"-0", b"2.5", b"1e999", b"nan", b"1_0", b"0x1",
          b"4294967296", b"9" * 30, b"\xef\xbb\xbf", b"\\\n", b"<!-- c -->", b"\xc3\xa9"]


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def crossed(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def added(vectors):
    return [sum(column) for column in zip(*vectors)]


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

    def table(self):
        """Rows of tests/support/mesh_files/table.py, and the folder with their files."""
        subprocess.run([sys.executable, TABLE, self.folder / "table"], check=True)
        return json.loads((self.folder / "table" / "table.json").read_text()), self.folder / "table"

    def test_every_file_is_read_or_refused_as_the_table_says(self):
        rows, folder = self.table()
        self.assertGreater(len(rows), 300)
        for row in rows:
            with self.subTest(row["name"]):
                path = str(folder / row["name"])
                if "error" in row:
                    with self.assertRaises(collided.InvalidArgument) as refused:
                        collided.Mesh.read(path)
                    more = "; Mesh.of takes what trimesh or meshio read" if row["name"] == "mesh.fbx" else ""
                    self.assertEqual(refused.exception.message, path + row["error"] + more)
                else:
                    self.check(row, collided.Mesh.read(path))

    def check(self, row, mesh):
        counts = {"vertex_count": mesh.vertex_count, **{name: len(getattr(mesh, name)) for name in ("triangles", "edges", "points")}}
        self.assertEqual({name: count for name, count in counts.items() if name in row},
                         {name: count for name, count in row.items() if name in counts})
        if "vertices" in row:
            self.assertEqual(mesh.vertices.tolist(), row["vertices"])
        if "notes" in row:
            self.assertEqual(list(mesh.notes), row["notes"])
        if "twice_area" in row:  # products of the table's integers are exact
            corners = mesh.vertices.astype(float)[mesh.triangles]
            areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            self.assertEqual(areas.sum(axis=0).tolist(), row["twice_area"])
            self.assertTrue((areas @ row["twice_area"] >= 0).all())

    def test_damaged_files_are_read_as_collidectl_reads_them(self):
        random = np.random.default_rng(3)
        names = []
        for file in sorted(self.table()[1].iterdir()):
            data = file.read_bytes()
            if len(data) > 2000 or file.suffix in (".json", ".fbx"):
                continue
            for _ in range(2):
                damaged = bytearray(data[:random.integers(len(data) + 1)] if random.random() < 0.2 else data)
                for at in random.integers(len(damaged) + 1, size=random.integers(1, 3)):
                    damaged[at:at + random.integers(2)] = DAMAGE[random.integers(len(DAMAGE))]
                names.append(self.put(f"damaged_{len(names)}{file.suffix}", damaged))
        said = subprocess.run([READ_MESHES], input="\n".join(map(str, names)), capture_output=True, text=True, check=True).stdout
        read = [self.outcome(name) for name in names]
        self.assertGreater(sum(outcome != "refused" for outcome in read), 50)
        for name, ours, theirs in zip(names, read, said.splitlines(), strict=True):
            with self.subTest(damaged=name.read_bytes()):
                self.assertEqual(ours, theirs)

    @staticmethod
    def outcome(name):
        """Returns the line that tests/client/python/read_meshes.cpp prints."""
        try:
            mesh = collided.Mesh.read(name)
        except collided.InvalidArgument:
            return "refused"
        counts = [mesh.vertex_count, *map(len, (mesh.triangles, mesh.edges, mesh.points, mesh.notes))]
        return ", ".join(f"{count} {what}" for count, what in zip(counts, ("vertices", "triangles", "edges", "points", "notes")))

    def test_a_file_for_which_there_is_no_memory_is_named(self):
        large = self.folder / "large.obj"
        with large.open("wb") as file:
            file.truncate(4 << 30)  # of holes
        read = [sys.executable, "-c", "import sys, collided\ncollided.Mesh.read(sys.argv[1])", large]
        for command in (read, [COLLIDECTL, "detect", large]):
            done = subprocess.run(["prlimit", f"--as={3 << 30}", *command], capture_output=True, text=True, check=False)
            if "AddressSanitizer" not in done.stderr:  # which needs more by itself
                self.assertIn(f"{large}: does not fit in memory", done.stderr)

    def test_polygons_are_split_without_losing_or_adding_area(self):
        """Judged in fractions: the triangles point as the polygon does, and their areas add up to its own."""
        random = np.random.default_rng(5)
        for case in range(60):
            angles = np.sort(random.random(random.integers(4, 14))) * 3.0
            star = np.c_[np.cos(angles), np.sin(angles)] * random.uniform(0.2, 1, (len(angles), 1)).round(3)
            flat = np.insert(star, 0, [0, 0], axis=0)  # seen from its first corner, the polygon has no sides that cross
            plane = random.integers(-3, 4, (2, 3)) + np.array([[4, 0, 0], [0, 5, 0]])
            vertices = (flat @ plane).tolist()
            text = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in vertices)
            mesh = collided.Mesh.read(self.put(f"{case}.obj", (text + "f " + " ".join(str(i + 1) for i in range(len(vertices)))).encode()))
            exact = [[Fraction(x) for x in p] for p in mesh.vertices.tolist()]
            whole = added(crossed(a, b) for a, b in zip(exact, exact[1:] + exact[:1]))
            parts = [crossed(minus(exact[b], exact[a]), minus(exact[c], exact[a])) for a, b, c in mesh.triangles.tolist()]
            self.assertEqual(len(parts), len(vertices) - 2)
            self.assertEqual(added(parts), whole)
            self.assertGreaterEqual(min(sum(x * y for x, y in zip(part, whole)) for part in parts), -Fraction(1, 2 ** 60))

    def test_a_file_that_is_not_there_is_an_os_error(self):
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
