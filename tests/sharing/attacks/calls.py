"""Callers with a token who ask for what they should not, or too often, or take nothing of what they get."""

import contextlib
import itertools
import queue
import secrets
import threading

import grpc

from collided.v1 import batch_pb2 as batch
from collided.v1 import collision_service_pb2 as api

from attacks.catalogue import attack
from attacks.tip import FLOOR, points, tip_at, tip_frame, tip_request, tip_spec

SERVICE = "collided.v1.CollisionService"
SECONDS = 5
WORLDS = 500


class Caller:
    """A client with a channel of its own, whose scenes are gone when it leaves."""

    def __init__(self, target, token=None):
        self.channel = grpc.insecure_channel(target.address, [("grpc.use_local_subchannel_pool", 1),
                                                              ("grpc.max_send_message_length", -1)])
        self.metadata = [("authorization", f"Bearer {target.token if token is None else token}")]
        self.scenes = []

    def call(self, method, request=b"", service=SERVICE):
        data = request if isinstance(request, bytes) else request.SerializeToString()
        return self.channel.unary_unary(f"/{service}/{method}")(data, timeout=SECONDS, metadata=self.metadata)

    def stream(self, method, requests, service=SERVICE):
        serialize = lambda request: request if isinstance(request, bytes) else request.SerializeToString()  # noqa: E731
        return self.channel.stream_stream(f"/{service}/{method}", request_serializer=serialize)(
            requests, metadata=self.metadata)

    def create(self):
        scene = api.CreateSceneResponse.FromString(self.call("CreateScene", tip_request())).scene
        self.scenes.append(scene.scene_id)
        return scene

    def close(self):
        for scene in self.scenes:
            with contextlib.suppress(grpc.RpcError):
                self.call("DeleteScene", api.DeleteSceneRequest(scene_id=scene))
        self.channel.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def repeat(caller, told, over, method, request=b"", service=SERVICE):
    while not over.is_set():
        told.attempt(caller.call, method, request, service)


@attack("calls")
def health_flood(target, told, over):
    """Health checks without a pause, and watches of health that nobody ends."""
    with Caller(target) as caller:
        watches = [caller.channel.unary_stream("/grpc.health.v1.Health/Watch")(b"") for _ in range(200)]
        told["watches"] += len(watches)
        repeat(caller, told, over, "Check", service="grpc.health.v1.Health")


@attack("calls")
def reflection_flood(target, told, over):
    """Lists of services by reflection, on many streams, none of which is read."""
    with Caller(target) as caller:
        while not over.wait(0.001):
            call = caller.stream("ServerReflectionInfo", iter([b"\x3a\x00"] * 50), "grpc.reflection.v1.ServerReflection")
            told["streams"] += 1
            over.wait(0.01)
            call.cancel()


@attack("calls")
def unknown_tokens(target, told, over):
    """Calls with tokens that are guessed."""
    with Caller(target) as caller:
        while not over.is_set():
            caller.metadata = [("authorization", f"Bearer {secrets.token_hex(16)}")]
            told.attempt(caller.call, "CreateScene", bytes(1 << 16))


@attack("calls")
def create_and_delete(target, told, over):
    """Scenes that are deleted as soon as they are there."""
    with Caller(target) as caller:
        while not over.is_set():
            scene = told.attempt(caller.create)
            if scene:
                caller.scenes.remove(scene.scene_id)
                told.attempt(caller.call, "DeleteScene", api.DeleteSceneRequest(scene_id=scene.scene_id))


@attack("calls")
def oversize_messages(target, told, over):
    """Messages of 80 MB, above the limit."""
    with Caller(target) as caller:
        repeat(caller, told, over, "CreateScene", bytes(80 << 20))


@attack("calls")
def expanding_messages(target, told, over):
    """Two bytes on the wire that would be a hundred in memory: a scene of a million empty meshes."""
    with Caller(target) as caller:
        spec = b"\x22\x00" * 500_000
        repeat(caller, told, over, "CreateScene", b"\x12" + varint(len(spec)) + spec)


def varint(value):
    data = b""
    while value > 127:
        data, value = data + bytes([128 | value & 127]), value >> 7
    return data + bytes([value])


@attack("calls")
def nan_frames(target, told, over):
    """Positions that are no numbers."""
    with Caller(target) as caller:
        scene = caller.create()
        for frame_id in itertools.count(1):
            if over.is_set():
                return
            frame = tip_frame(frame_id, float("nan"))
            told.attempt(caller.call, "DetectFrame", api.DetectFrameRequest(scene_id=scene.scene_id, frame=frame))


@attack("calls")
def wrong_lengths(target, told, over):
    """Positions of too few, too many and half a vertex."""
    with Caller(target) as caller:
        scene = caller.create()
        for frame_id in itertools.count(1):
            if over.is_set():
                return
            frame = tip_frame(frame_id, 2)
            frame.updates[0].positions = bytes(12 * 3 + (-1, 1, 12, -12, 1 << 20)[frame_id % 5])
            told.attempt(caller.call, "DetectFrame", api.DetectFrameRequest(scene_id=scene.scene_id, frame=frame))


@attack("calls")
def guessed_resume_tokens(target, told, over):
    """Streams opened with resume tokens that are guessed."""
    with Caller(target) as caller:
        scene = caller.create()
        while not over.is_set():
            opening = api.StreamFramesRequest(open=api.OpenStream(scene_id=scene.scene_id,
                                                                  resume_token=secrets.token_hex(16)))
            told.attempt(list, caller.stream("StreamFrames", iter([opening])))


@attack("calls")
def guessed_pages(target, told, over):
    """Pages and scenes of others, by tokens and ids that are guessed."""
    with Caller(target) as caller:
        while not over.is_set():
            told.attempt(caller.call, "ListScenes", api.ListScenesRequest(page_token=secrets.token_hex(40)))
            told.attempt(caller.call, "GetScene", api.GetSceneRequest(scene_id=secrets.token_hex(16)))


@attack("calls")
def batch_flood(target, told, over):
    """DetectBatch of many worlds, eight calls at once."""
    with Caller(target) as caller:
        request = batch.CreateScenesRequest(spec=tip_spec(), count=WORLDS)
        scene = batch.CreateScenesResponse.FromString(caller.call("CreateScenes", request)).scenes
        caller.scenes.append(scene.scene_id)
        ids, floor = itertools.count(1), points(*FLOOR)
        start = floor + tip_at(1)

        def ask():
            while not over.is_set():
                frame = batch.SetFrame(scene_id=scene.scene_id, frame_id=next(ids), start_positions=start * WORLDS,
                                       positions=(floor + tip_at(-1)) * WORLDS)
                told.attempt(caller.call, "DetectBatch", batch.DetectBatchRequest(frames=[frame], max_answer_bytes=8 << 20))

        in_threads(8, ask)


def in_threads(count, function):
    threads = [threading.Thread(target=function) for _ in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def requests_until(over):
    """No request, until then."""
    over.wait()
    yield from ()


@attack("silent calls")
def streams_without_opening(target, told, over):
    """Two hundred streams without a first message."""
    with Caller(target) as caller:
        calls = [caller.stream("StreamFrames", requests_until(over)) for _ in range(200)]
        told["streams"] += len(calls)
        over.wait()


@attack("silent calls")
def uploads_without_chunks(target, told, over):
    """A hundred uploads of which nothing comes."""
    with Caller(target) as caller:
        calls = [caller.channel.stream_unary(f"/{SERVICE}/UploadMesh").future(requests_until(over), metadata=caller.metadata)
                 for _ in range(100)]
        told["uploads"] += len(calls)
        over.wait()


@attack("silent calls")
def frames_without_reading(target, told, over):
    """Streams of frames whose answers nobody reads."""
    with Caller(target) as caller:
        def requests(scene):
            yield api.StreamFramesRequest(open=api.OpenStream(scene_id=scene.scene_id, window=16))
            for frame_id in itertools.count(1):
                if over.is_set():
                    return
                told["frames"] += 1
                yield api.StreamFramesRequest(frame=tip_frame(frame_id, 2))

        calls = [caller.stream("StreamFrames", requests(caller.create())) for _ in range(8)]
        over.wait()
        for call in calls:
            call.cancel()


@attack("silent calls")
def slow_watchers(target, told, over):
    """Fifty watchers that read nothing of a scene whose frames do not stop."""
    with Caller(target) as caller:
        scene = caller.create()
        request = api.WatchSceneRequest(scene_id=scene.scene_id, max_contacts_per_kind=8192).SerializeToString()
        watches = [caller.channel.unary_stream(f"/{SERVICE}/WatchScene")(request, metadata=caller.metadata) for _ in range(50)]
        told["watches"] += len(watches)
        for frame_id in itertools.count(1):
            if over.is_set():
                return
            told.attempt(caller.call, "DetectFrame",
                         api.DetectFrameRequest(scene_id=scene.scene_id, frame=tip_frame(frame_id, 2)))


@attack("silent calls")
def slow_reader(target, told, over):
    """A reader that takes one answer in a tenth of a second, of as many frames as its window has."""
    with Caller(target) as caller:
        scene, frames = caller.create(), queue.Queue()
        frames.put(api.StreamFramesRequest(open=api.OpenStream(scene_id=scene.scene_id, window=16)))
        for frame_id in range(1, 2000):
            frames.put(api.StreamFramesRequest(frame=tip_frame(frame_id, 2)))
        call = caller.stream("StreamFrames", iter(frames.get, None))
        while not over.wait(0.1):
            next(call)
            told["answers"] += 1
        call.cancel()
        frames.put(None)


@attack("limits")
def scenes_without_end(target, told, over):
    """Scenes until there may be no more, which are kept."""
    with Caller(target) as caller:
        while not over.wait(0.01):
            told.attempt(caller.create)
