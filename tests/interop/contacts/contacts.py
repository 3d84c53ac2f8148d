#!/usr/bin/env python3
"""The scene of contacts_test.py with plain stubs. usage: contacts.py ADDRESS, with the stubs on PYTHONPATH."""

import queue
import sys

import grpc
import numpy as np
from collided.v1 import collision_service_pb2 as api
from collided.v1 import collision_service_pb2_grpc as rpc
from collided.v1 import contact_pb2, frame_pb2, scene_pb2

SIDE = 17
FIELDS = ("elements", "stencils", "toi", "distance", "weights", "normals", "flags", "features")


def sheet(shift, height, a, b):
    """A sheet of bumps; every coordinate is exact."""
    j, i = np.divmod(np.arange(SIDE * SIDE), SIDE)
    return np.stack([0.25 * i + shift, 0.25 * j + shift, height + (a * i + b * j) % 32 / 64], axis=1)


def triangles():
    j, i = np.divmod(np.arange((SIDE - 1) ** 2), SIDE - 1)
    v = j * SIDE + i
    return np.stack([v, v + 1, v + SIDE, v + 1, v + SIDE + 1, v + SIDE], axis=1).astype("<u4").tobytes()


def frames():
    for frame in range(5):
        update = frame_pb2.MeshUpdate(mesh=1)
        upper = sheet(0.125, 2 - frame, 11, 5)
        if frame == 4:  # every third vertex alone, back through the lower sheet
            update.sparse.indices = np.arange(0, SIDE * SIDE, 3, "<u4").tobytes()
            upper = upper[::3] + [0, 0, 3]
        update.positions = upper.tobytes()
        lower = frame_pb2.MeshUpdate(mesh=0, positions=sheet(0, 0, 7, 13).tobytes())
        if frame == 2:
            yield frame_pb2.Frame(updates=[update], trial=True, advance=True, limits=True,
                                  advance_mode=frame_pb2.ADVANCE_MODE_PER_VERTEX)
        yield frame_pb2.Frame(updates=[lower, update] if frame == 0 else [update])
        yield frame_pb2.Frame(mode=scene_pb2.DETECTION_MODE_DCD)


def put(chunks, kind):
    chunks = [chunk for chunk in chunks if chunk.kind == kind]
    sys.stdout.buffer.write(np.array(sum(chunk.count for chunk in chunks), "<u4").tobytes())
    for field in FIELDS:
        sys.stdout.buffer.write(b"".join(getattr(chunk, field) for chunk in chunks))


def main(address):
    stub = rpc.CollisionServiceStub(grpc.insecure_channel(address))
    names = {"lower": scene_pb2.MESH_MOTION_STATIC, "upper": scene_pb2.MESH_MOTION_DEFORMABLE}
    meshes = [scene_pb2.MeshSpec(name=name, vertex_count=SIDE * SIDE, triangles=triangles(), motion=motion)
              for name, motion in names.items()]
    spec = scene_pb2.SceneSpec(mode=scene_pb2.DETECTION_MODE_DCD_AND_CCD, thickness=0.25,
                               position_format=scene_pb2.POSITION_FORMAT_F64, fields=range(1, 9), meshes=meshes)
    scene = stub.CreateScene(api.CreateSceneRequest(spec=spec), timeout=30).scene
    requests = queue.Queue()
    responses = stub.StreamFrames(iter(requests.get, None), timeout=60)
    requests.put(api.StreamFramesRequest(open=api.OpenStream(scene_id=scene.scene_id)))
    next(responses)
    for number, frame in enumerate(frames(), 1):
        frame.frame_id = number
        requests.put(api.StreamFramesRequest(frame=frame))
        wanted, chunks = "limits" if frame.limits else "contacts", []
        while (kind := (response := next(responses)).WhichOneof("response")) != "done":
            chunks += [getattr(response, kind)] if kind == wanted else []
        chunks += getattr(response.done, wanted)
        put(chunks, contact_pb2.CONTACT_KIND_VERTEX_TRIANGLE)
        put(chunks, contact_pb2.CONTACT_KIND_EDGE_EDGE)
    requests.put(None)


if __name__ == "__main__":
    main(sys.argv[1])
