"""Holds the conversations that are recorded: each function is one, with the Python package or the command line.

All inputs are small and have a few contacts of each kind. Engines are named where the answer would depend on measured times.
"""

import pathlib
import subprocess
import tempfile
import uuid

import collided
import grpc
import numpy as np
from collided.v1 import batch_pb2, frame_pb2, scene_pb2
from collided.v1 import collision_service_pb2 as api
from collided.v1.collision_service_pb2_grpc import CollisionServiceStub

ALL = ("elements", "stencil", "toi", "distance", "weights", "normal", "flags")
LEVELS = ("candidates", "fast", "guarded", "certified", "exact")
STEADY = {"broad_phase": "lbvh", "backend": "cpu"}
FLOOR = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0]], "<f4")
TIP = np.array([[1, 1, 1], [1.25, 1, 9], [1, 1.25, 9]], "<f4")


def grid(cells, z=0.0):
    """A square of 4 by 4, with a bend, so that nothing is parallel."""
    y, x = np.mgrid[:cells + 1, :cells + 1] * (4 / cells)
    vertices = np.stack([x, y, z + 0.11 * np.sin(2.3 * x + 1.7 * y)], axis=2).reshape(-1, 3)
    corner = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).reshape(-1, 1)
    return vertices, np.concatenate([corner + [0, 1, cells + 1], corner + [1, cells + 2, cells + 1]], axis=1).reshape(-1, 3)


def two_sheets(dtype="<f8"):
    (low, faces), (high, _) = grid(4), grid(4, 0.5)
    return {"low": collided.Mesh(low.astype(dtype), faces, motion="static"), "high": collided.Mesh((high + [0.13, 0.07, 0]).astype(dtype), faces)}


def fallen(depth, dtype="<f8"):
    high = grid(4, 0.5)[0] + [0.13, 0.07, 0]
    return (high - [0, 0, depth]).astype(dtype)


def tip_meshes():
    return {"floor": collided.Mesh(FLOOR, [[0, 1, 2]], motion="static"), "tip": collided.Mesh(TIP, [[0, 1, 2]])}


def stepped(server, transport, meshes, frames, **options):
    with collided.Session(meshes, server=server, transport=transport, **STEADY, **options) as session:
        for positions, frame in frames:
            try:
                session.step(positions, **frame)
            except collided.Error:
                pass


def daemon_and_scenes(server):
    """Facts about the daemon, its health, a scene's life, an estimate, pages."""
    with grpc.insecure_channel(server) as channel:
        channel.unary_unary("/grpc.health.v1.Health/Check")(b"")
        channel.unary_unary("/grpc.health.v1.Health/Check")(b"\x0a\x1ccollided.v1.CollisionService")
    with collided.Client(server) as client:
        assert client.info.version
        client.estimate(two_sheets(), fields=ALL, **STEADY)
        with collided.Scene(two_sheets(), server=client, display_name="recorded", **STEADY) as scene:
            scene.refresh()
            client.scenes()
            client.get_mesh(scene.id, 1)


def upload(server):
    """Triangles by UploadMesh, in two chunks."""
    vertices, faces = grid(4)
    with collided.Client(server) as client:
        stub = CollisionServiceStub(client.connect().channel)
        spec = scene_pb2.SceneSpec(mode=scene_pb2.DETECTION_MODE_DCD, thickness=0.01, backend=scene_pb2.BACKEND_CPU)
        spec.meshes.add(name="sheet", vertex_count=len(vertices), triangle_count=len(faces))
        scene = stub.CreateScene(api.CreateSceneRequest(request_id=uuid.uuid4().hex, spec=spec)).scene
        half, data = len(faces) // 2, faces.astype("<u4")
        chunks = [api.UploadMeshRequest(scene_id=scene.scene_id, mesh=0, triangles=data[:half].tobytes()),
                  api.UploadMeshRequest(triangles=data[half:].tobytes())]
        stub.UploadMesh(iter(chunks))
        client.get_mesh(scene.scene_id, 0)
        client.delete_scene(scene.scene_id)


def ccd_at(level, transport, dtype):
    def converse(server):
        frames = [(fallen(0, dtype), {}), (fallen(0.3, dtype), {}), (fallen(0.7, dtype), {"trial": True}), (fallen(0.6, dtype), {})]
        stepped(server, transport, two_sheets(dtype), frames, accuracy=level, fields=ALL)
    return converse


def dcd_at(level, transport):
    def converse(server):
        kinds = ("vt", "ee", "tt") if level != "candidates" else ("vt", "ee")
        frames = [(fallen(0), {}), (fallen(0.45), {}), (fallen(0.52), {})]
        stepped(server, transport, two_sheets(), frames, accuracy=level, mode="dcd", thickness=0.02, kinds=kinds, fields=ALL)
    return converse


def crossings(transport):
    """Triangles that cross, at two levels, and after a move that ends it."""
    def converse(server):
        frames = [({"tip": TIP - np.float32([0, 0, depth])}, {"accuracy": level}) for level in ("fast", "exact") for depth in (0, 1.5, 1.75, 0.5)]
        stepped(server, transport, tip_meshes(), frames, mode="dcd", thickness=0.02, kinds=("vt", "ee", "tt"), fields=ALL)
    return converse


def stepping(transport):
    """Reports, advances, line searches, sparse updates, other levels and modes for a frame."""
    def converse(server):
        frames = [(fallen(0), {}), (fallen(0.8), {"report": "earliest_only", "trial": True}),
                  (fallen(0.8), {"report": "any_hit", "trial": True}), (fallen(0.8), {"advance": True}),
                  (fallen(0.2), {"accuracy": "exact", "delta": 1e-6, "ignore_separating": True}), (fallen(0.9), {"trial": True}),
                  (None, {"from_last_fraction": 0.125}), (None, {"mode": "dcd"}),
                  ({"high": collided.Sparse([8, 20], fallen(0.7)[[8, 20]])}, {})]
        stepped(server, transport, two_sheets(), frames, mode="dcd_and_ccd", thickness=0.02, min_separation=1e-3, fields=ALL)
    return converse


def poses(transport):
    """A rigid body on its way, by transforms."""
    def converse(server):
        body, faces = grid(3, 1.0)
        meshes = {"floor": collided.Mesh(*grid(3), motion="static"), "body": collided.Mesh(body, faces, motion="rigid")}

        def pose(angle, z):
            c, s = np.cos(angle), np.sin(angle)
            return collided.Rigid(np.array([[c, -s, 0, 0.1], [s, c, 0, 0], [0, 0, 1, z]]))

        frames = [({"body": pose(0, 0)}, {}), ({"body": pose(0, -0.5)}, {}), ({"body": pose(0.2, -1.1)}, {})]
        stepped(server, transport, meshes, frames, fields=ALL)
    return converse


def edits(transport):
    """Meshes added, replaced and removed; loose edges and points; pairs that are excluded and included again."""
    def converse(server):
        hair = collided.Mesh(np.array([[1, 1, 1.5], [1.3, 1.2, 1.2], [1.7, 1.1, 1.4]]), edges=[[0, 1], [1, 2]])
        drops = collided.Mesh(np.array([[2.1, 2.2, 1.6], [2.6, 2.1, 1.4]]), points=[0, 1])
        frames = [(fallen(0), {}),
                  ({"hair": hair.vertices, "high": fallen(0.1)}, {"edit": collided.Edit({"hair": hair}, exclude=[("low", "high")])}),
                  ({"hair": hair.vertices - [0, 0, 2], "high": fallen(0.7)}, {}),
                  ({"drops": drops.vertices}, {"edit": collided.Edit({"hair": None, "drops": drops}, include=[("low", "high")])}),
                  ({"drops": drops.vertices - [0, 0, 2.5]}, {})]
        stepped(server, transport, two_sheets(), frames, fields=ALL)
    return converse


def resumed(server):
    """A stream that is opened again with the scene's token."""
    with collided.Client(server) as client, collided.Scene(tip_meshes(), server=client, **STEADY) as scene:
        stub = CollisionServiceStub(client.connect().channel)
        for token in ("", scene.message.resume_token):
            opening = api.OpenStream(scene_id=scene.id, window=2, resume_token=token)
            next(stub.StreamFrames(iter([api.StreamFramesRequest(open=opening)])))


def calls(server):
    """Frames by DetectFrame."""
    stepped(server, "calls", tip_meshes(), [(TIP, {}), (TIP - np.float32([0, 0, 2]), {})], fields=ALL)


def sets(server):
    """Sets of scenes, by DetectBatch and over a stream."""
    heights = np.arange(3)[:, None, None] * np.array([0, 0, 0.5], "<f4")
    with collided.SceneBatch(tip_meshes(), 3, server=server, backend="cpu", fields=ALL) as batch:
        batch.step(TIP + heights)
        batch.step(TIP + heights - np.float32([0, 0, 1.6]))
    with collided.Client(server) as client:
        spec = scene_pb2.SceneSpec(mode=scene_pb2.DETECTION_MODE_CCD, backend=scene_pb2.BACKEND_CPU)
        for name, motion in (("floor", scene_pb2.MESH_MOTION_STATIC), ("tip", scene_pb2.MESH_MOTION_DEFORMABLE)):
            spec.meshes.add(name=name, motion=motion, vertex_count=3, triangles=np.arange(3, dtype="<u4").tobytes())
        made = client.call("CreateScenes", batch_pb2.CreateScenesRequest(request_id=uuid.uuid4().hex, spec=spec, count=2)).scenes
        for number, depth in ((1, 0), (2, 2)):
            positions = b"".join(FLOOR.tobytes() * (number == 1) + (TIP - np.float32([0, 0, depth])).tobytes() for _ in range(2))
            frame = batch_pb2.SetFrame(scene_id=made.scene_id, frame_id=number, positions=positions)
            client.call("DetectBatch", batch_pb2.DetectBatchRequest(frames=[frame]))
        client.delete_scene(made.scene_id)


def watch(server):
    """A watcher of a scene's frames, with contacts and positions."""
    with collided.Client(server) as client, collided.Scene(two_sheets(), server=client, fields=ALL, **STEADY) as scene:
        watcher = scene.watch(max_contacts_per_kind=3, meshes=["high"], vertex_stride=5)
        with scene.session(transport="grpc") as session:
            for depth in (0, 0.6):
                session.step(fallen(depth))
                next(iter(watcher))
        watcher.close()


def bad_inputs(server):
    """Refusals of each kind: codes and fields are compared."""
    with collided.Client(server) as client:
        def refused(method, request):
            try:
                client.call(method, request)
            except collided.Error:
                return
            raise AssertionError(f"{method} was not refused")

        triangle, ccd = np.arange(3, dtype="<u4").tobytes(), scene_pb2.DETECTION_MODE_CCD
        mesh = scene_pb2.MeshSpec(name="a", vertex_count=3, triangles=triangle)
        for spec in (scene_pb2.SceneSpec(meshes=[mesh]), scene_pb2.SceneSpec(mode=ccd), scene_pb2.SceneSpec(mode=77, meshes=[mesh]),
                     scene_pb2.SceneSpec(mode=ccd, meshes=[mesh, mesh]), scene_pb2.SceneSpec(mode=ccd, meshes=[mesh], thickness=-1),
                     scene_pb2.SceneSpec(mode=ccd, meshes=[mesh], accuracy=9), scene_pb2.SceneSpec(mode=ccd, meshes=[mesh], kinds=[0]),
                     scene_pb2.SceneSpec(mode=ccd, meshes=[scene_pb2.MeshSpec(name="a", vertex_count=2, triangles=triangle)]),
                     scene_pb2.SceneSpec(mode=ccd, meshes=[mesh], memory_budget_bytes=1),
                     scene_pb2.SceneSpec(mode=ccd, meshes=[mesh], device="cuda:77")):
            refused("CreateScene", api.CreateSceneRequest(spec=spec))
            refused("EstimateScene", api.EstimateSceneRequest(spec=spec))
        for method, request in (("GetScene", api.GetSceneRequest(scene_id="nowhere")), ("DeleteScene", api.DeleteSceneRequest()),
                                ("GetMesh", api.GetMeshRequest(scene_id="nowhere")), ("ListScenes", api.ListScenesRequest(page_size=7777)),
                                ("DetectBatch", batch_pb2.DetectBatchRequest()), ("DetectFrame", api.DetectFrameRequest(scene_id="nowhere"))):
            refused(method, request)
        with collided.Scene(tip_meshes(), server=client, **STEADY) as scene:
            refused("GetMesh", api.GetMeshRequest(scene_id=scene.id, mesh=9))
            whole = [frame_pb2.MeshUpdate(mesh=i, positions=p.tobytes()) for i, p in enumerate((FLOOR, TIP))]
            bad = TIP.copy()
            bad[1, 2] = np.nan
            requests = [api.StreamFramesRequest(open=api.OpenStream(scene_id=scene.id, window=1))]
            for frame in (frame_pb2.Frame(frame_id=1, updates=whole[:1]), frame_pb2.Frame(frame_id=0, updates=whole),
                          frame_pb2.Frame(frame_id=1, updates=[whole[0], frame_pb2.MeshUpdate(mesh=1, positions=bad.tobytes())]),
                          frame_pb2.Frame(frame_id=1, updates=[whole[0], frame_pb2.MeshUpdate(mesh=5)]), frame_pb2.Frame(frame_id=1, accuracy=99, updates=whole),
                          frame_pb2.Frame(frame_id=1, updates=whole), frame_pb2.Frame(frame_id=1), frame_pb2.Frame(frame_id=2, advance=True, accuracy=2),
                          frame_pb2.Frame(frame_id=2, updates=[frame_pb2.MeshUpdate(mesh=1, positions=b"1234")])):
                requests.append(api.StreamFramesRequest(frame=frame))
            _in_turn(client, requests)
            _in_turn(client, [api.StreamFramesRequest(frame=frame_pb2.Frame(frame_id=3))])
            _in_turn(client, [api.StreamFramesRequest(open=api.OpenStream(scene_id="nowhere"))])
            _in_turn(client, [api.StreamFramesRequest(open=api.OpenStream(scene_id=scene.id, window=99999))])


def _in_turn(client, requests):
    """Each message once the last one was answered."""
    import queue

    waiting = queue.SimpleQueue()
    answers = CollisionServiceStub(client.connect().channel).StreamFrames(iter(waiting.get, None), timeout=10)
    try:
        for request in requests:
            waiting.put(request)
            while (kind := next(answers).WhichOneof("response")) == "contacts":
                pass
            assert kind in ("opened", "done", "error"), kind
    except grpc.RpcError:
        pass
    finally:
        waiting.put(None)
    try:
        list(answers)
    except grpc.RpcError:
        pass


def command_line(program):
    """The client in C++, as the command line uses it: over the local socket."""
    def converse(server):
        with tempfile.TemporaryDirectory() as folder:
            files = []
            for name, depth in (("0", 0), ("1", 0.7)):
                (low, faces), high = grid(4), grid(4, 0.5)[0] + [0.13, 0.07, -depth]
                vertices, count = np.concatenate([low, high]), len(low)
                lines = [f"v {x} {y} {z}" for x, y, z in vertices.tolist()]
                lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in np.concatenate([faces, faces + count]).tolist()]
                files.append(pathlib.Path(folder) / f"{name}.obj")
                files[-1].write_text("\n".join(lines) + "\n")
            for options in (["--frames", *files], ["--self", files[1]], ["--frames", *files, "--accuracy", "exact"]):
                subprocess.run([program, "detect", *options, "--server", server, "--engine", "lbvh", "--json"], check=False,
                               stdout=subprocess.DEVNULL)
            subprocess.run([program, "info", "--server", server], check=True, stdout=subprocess.DEVNULL)
    return converse


def all_conversations(program):
    """By the name of their file. program: collidectl."""
    found = {"daemon_and_scenes": daemon_and_scenes, "upload": upload, "resumed": resumed, "calls": calls, "sets": sets, "watch": watch,
             "bad_inputs": bad_inputs, "command_line": command_line(program)}
    for transport, short in (("grpc", "grpc"), ("shared_memory", "local")):
        for level in LEVELS:
            found[f"ccd_{level}_{short}"] = ccd_at(level, transport, "<f4" if transport == "grpc" else "<f8")
            found[f"dcd_{level}_{short}"] = dcd_at(level, transport)
        for make in (crossings, stepping, poses, edits):
            found[f"{make.__name__}_{short}"] = make(transport)
    return found
