"""Callers who make the daemon work without frames that step: it builds, checks, estimates, looks up and shows."""

import contextlib
import itertools
import struct
import threading

import grpc
import numpy as np

from collided.v1 import batch_pb2 as batch
from collided.v1 import collision_service_pb2 as api
from collided.v1 import frame_pb2, scene_pb2

from attacks.calls import SERVICE, Caller, in_threads
from attacks.catalogue import attack
from attacks.tip import TRIANGLE, tip_spec

WORLDS = 65_536  # of a set at most
MESHES = 16_384  # of a scene at most
WAITING = 64  # calls of one connection
AT_ONCE = 16


def ccd_spec():
    return scene_pb2.SceneSpec(mode=scene_pb2.DETECTION_MODE_CCD, position_format=scene_pb2.POSITION_FORMAT_F32)


def separate_spec(triangles):
    """Triangles that share no vertex."""
    spec = ccd_spec()
    spec.meshes.add(name="hostile", vertex_count=3 * triangles, triangles=np.arange(3 * triangles, dtype="<u4").tobytes())
    return spec


def many_meshes_spec():
    spec = ccd_spec()
    for i in range(MESHES):
        spec.meshes.add(name=f"mesh {i}", vertex_count=3, triangles=TRIANGLE)
    return spec


def keep_waiting(caller, told, over, method, request):
    """Keeps WAITING calls open; nobody parses their answers."""
    call = caller.channel.unary_unary(f"/{SERVICE}/{method}")
    places = threading.Semaphore(WAITING)

    def done(future):
        told.met[future.code().name] += 1
        places.release()

    while not over.is_set():
        if places.acquire(timeout=0.1):
            told["calls"] += 1
            call.future(request, metadata=caller.metadata).add_done_callback(done)


def created(caller, spec):
    made = caller.call("CreateScene", api.CreateSceneRequest(spec=spec))
    scene = api.CreateSceneResponse.FromString(made).scene.scene_id
    caller.scenes.append(scene)
    return scene


@attack("work")
def look_ups(target, told, over):
    """Look-ups of a scene of 16,384 meshes, 64 calls at any time."""
    with Caller(target) as caller:
        scene = created(caller, many_meshes_spec())
        keep_waiting(caller, told, over, "GetScene", api.GetSceneRequest(scene_id=scene).SerializeToString())


def side_by_side(triangles):
    """Positions of triangles that do not touch."""
    corners = np.array([[0, 0, 0], [0.5, 0, 0], [0, 0.5, 0]])
    return (corners + np.arange(triangles)[:, None, None] * [1, 0, 0]).astype("<f4").tobytes()


@attack("work")
def eager_watchers(target, told, over):
    """Thirty-two watchers of a scene of 60,000 vertices, who see all of it with every frame and read it at once."""
    triangles = 20_000
    with Caller(target) as caller:
        scene, positions = created(caller, separate_spec(triangles)), side_by_side(triangles)
        request = api.WatchSceneRequest(scene_id=scene, position_meshes=[0]).SerializeToString()
        watches = [caller.channel.unary_stream(f"/{SERVICE}/WatchScene")(request, metadata=caller.metadata) for _ in range(32)]

        def watch(messages):
            with contextlib.suppress(grpc.RpcError):
                for _ in messages:
                    told["seen"] += 1

        readers = [threading.Thread(target=watch, args=(messages,), daemon=True) for messages in watches]
        for reader in readers:
            reader.start()
        for frame_id in itertools.count(1):
            if over.is_set():
                break
            frame = frame_pb2.Frame(frame_id=frame_id)
            frame.updates.add(mesh=0, positions=positions)
            told.attempt(caller.call, "DetectFrame", api.DetectFrameRequest(scene_id=scene, frame=frame))
        for messages in watches:
            messages.cancel()


@attack("work")
def nan_worlds(target, told, over):
    """Sets of 65,536 worlds whose positions are no numbers, four at once."""
    with Caller(target) as caller:
        nothing = struct.pack("<f", float("nan")) * (18 * WORLDS)

        def ask():
            while not (made := told.attempt(caller.call, "CreateScenes", batch.CreateScenesRequest(spec=tip_spec(), count=WORLDS))):
                if over.is_set():
                    return
            scene = batch.CreateScenesResponse.FromString(made).scenes.scene_id
            caller.scenes.append(scene)
            for frame_id in itertools.count(1):
                if over.is_set():
                    return
                frame = batch.SetFrame(scene_id=scene, frame_id=frame_id, positions=nothing)
                told.attempt(caller.call, "DetectBatch", batch.DetectBatchRequest(frames=[frame], max_answer_bytes=16 << 20))

        in_threads(4, ask)


@attack("work")
def estimates(target, told, over):
    """Estimates of a scene of 16,384 meshes, 64 calls at any time."""
    with Caller(target) as caller:
        request = api.EstimateSceneRequest(spec=many_meshes_spec()).SerializeToString()
        keep_waiting(caller, told, over, "EstimateScene", request)


@attack("work")
def builds(target, told, over):
    """Scenes of 100,000 triangles built in all places that the client has left, again and again."""
    with Caller(target) as caller:
        request = api.CreateSceneRequest(spec=separate_spec(100_000)).SerializeToString()

        def build():
            while not over.is_set():
                if made := told.attempt(caller.call, "CreateScene", request):
                    scene = api.CreateSceneResponse.FromString(made).scene.scene_id
                    told.attempt(caller.call, "DeleteScene", api.DeleteSceneRequest(scene_id=scene))

        in_threads(AT_ONCE, build)
