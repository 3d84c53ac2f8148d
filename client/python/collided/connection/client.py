"""A connection to a daemon: everything that is asked with one call."""

from __future__ import annotations

import math
import os
import sys
import threading
import time
import uuid
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import grpc
import numpy as np

import collided.leftovers as leftovers
from collided.arrays import UINT32_MAX, is_whole
from collided.choices import check_text
from collided.connection.channel import MAX_ANSWER_BYTES, ask_for_info, end_elsewhere, metadata, open_channel
from collided.connection.connection import Connection
from collided.connection.mesh_elements import MeshElements, read_elements
from collided.connection.options import ConnectOptions, is_local_address
from collided.connection.own_daemon import OwnDaemon, shared_daemon
from collided.errors import (DataLoss, DeadlineExceeded, Error, InvalidArgument, NotFound, ResourceExhausted, Unavailable,
                             error_of_call)
from collided.layout import Layout
from collided.options import SceneOptions, check_seconds
from collided.v1 import batch_pb2, contact_pb2, scene_pb2
from collided.v1 import collision_service_pb2 as api
from collided.v1.collision_service_pb2_grpc import CollisionServiceStub

_TRIANGLES_PER_CHUNK = (1 << 19) // 12  # 512 KiB, well below the limit of any daemon
_UPLOADS_AT_ONCE = 8
_MAX_INLINE_BYTES = 4 << 20  # of triangles in the message that creates a scene
_CREATE_TRIES, _RETRY_SECONDS = 3, 0.2
_MOST_SCENES = 1_000_000  # that a daemon can have


class Client:
    """A connection, made when it is first needed, and made again when it is lost. May be used by several threads.

    server: "host:port" or "unix:/path"; None: $COLLIDED_SERVER, or a daemon that this process starts for itself.
    daemon: an OwnDaemon to use instead of the one that this process shares.
    options: those of ConnectOptions, such as token="..." and tls_ca="ca.pem".

    Calls raise Error: Unavailable if no daemon answers, DeadlineExceeded after `deadline` seconds, and what the daemon
    refuses with.
    """

    def __init__(self, server: str | None = None, *, daemon: OwnDaemon | None = None, **options: Any) -> None:
        self.options = ConnectOptions(**options)
        if server is not None:
            _check_address(server)
        self._server = server or (None if daemon else os.environ.get("COLLIDED_SERVER")) or None
        self._own = None if self._server else daemon or shared_daemon()
        if self._server:
            self.options.check(self._server)
        self._lock = threading.Lock()
        self._connection: Connection | None = None

    @property
    def address(self) -> str:
        """Of the daemon. Starts one where none was named."""
        return self._server if self._own is None else self._own.address  # type: ignore[return-value]

    @property
    def info(self) -> api.GetServerInfoResponse:
        """Version, devices and limits of the daemon, as of this connection."""
        info = self.connect().info
        assert info is not None
        return info

    def estimate(self, meshes: Any, **options: Any) -> api.EstimateSceneResponse:
        """What a scene would cost, before it is made: memory, bytes of its frames, stages. Arguments of Scene."""
        asked = SceneOptions(**options)
        spec = self._known_spec(Layout.of(meshes, asked.exclude), asked)
        return self.call("EstimateScene", api.EstimateSceneRequest(spec=spec))

    def scenes(self) -> list[scene_pb2.Scene]:
        """All scenes of this client, by id. All pages together take `deadline` seconds at most."""
        out: list[scene_pb2.Scene] = []
        token, until = "", time.monotonic() + self.options.deadline
        while True:
            page = self.call("ListScenes", api.ListScenesRequest(page_token=token), timeout=self._left(until))
            for scene in page.scenes:
                if out and scene.scene_id <= out[-1].scene_id:
                    raise DataLoss(f"scenes names {scene.scene_id!r} after {out[-1].scene_id!r}; ids must ascend")
                out.append(scene)
            token = page.next_page_token
            if not token:
                return out
            if not page.scenes or len(out) >= _MOST_SCENES:
                raise DataLoss(f"next_page_token is {token[:40]!r} after a page of {len(page.scenes)} scenes, {len(out)} in all")

    def _left(self, until: float) -> float:
        """Seconds until then, for a call that is one of several. Raises DeadlineExceeded."""
        left = until - time.monotonic()
        if left <= 0:
            raise DeadlineExceeded(f"the daemon at {self.place} did not send all pages within {self.options.deadline:g} s "
                                   "(deadline)")
        return left

    def get_scene(self, scene_id: str) -> scene_pb2.Scene:
        """State and memory of a scene; restarts its lease. NotFound."""
        check_text(scene_id, "scene_id")
        return self.call("GetScene", api.GetSceneRequest(scene_id=scene_id), scene_id).scene

    def get_mesh(self, scene_id: str, mesh: int) -> MeshElements:
        """What a mesh of a scene is made of now, whoever created it. mesh: its index in the scene's spec.

        NotFound; InvalidArgument for a mesh that the scene does not have; Aborted if edits keep changing it.
        """
        check_text(scene_id, "scene_id")
        if not is_whole(mesh, UINT32_MAX):
            raise InvalidArgument(f"mesh is {mesh!r}; it must be an index from 0", field="mesh")

        until = time.monotonic() + self.options.deadline

        def page_from(element: int) -> api.GetMeshResponse:
            # An upload has a second more for each 512 KiB, too.
            timeout = min(self._left(until + element / _TRIANGLES_PER_CHUNK), self.options.deadline)
            request = api.GetMeshRequest(scene_id=scene_id, mesh=mesh, first_element=element)
            return self.call("GetMesh", request, scene_id, timeout)

        return read_elements(page_from)

    def delete_scene(self, scene_id: str) -> None:
        """Frees a scene's memory. NotFound."""
        check_text(scene_id, "scene_id")
        self.call("DeleteScene", api.DeleteSceneRequest(scene_id=scene_id), scene_id)

    def try_delete(self, scene_id: str) -> None:
        """Frees a scene's memory where that can be; else its lease ends it."""
        try:
            self.delete_scene(scene_id)
        except Error:
            pass

    def ask_to_delete(self, scene_id: str) -> grpc.Future | None:
        """Frees a scene's memory, without waiting for the answer; on the connection that is open, if one is."""
        connection = self._connection  # another thread may hold the lock
        if connection is None or connection.info is None:
            return None
        try:
            return CollisionServiceStub(connection.channel).DeleteScene.future(
                api.DeleteSceneRequest(scene_id=scene_id), timeout=leftovers.CALL_SECONDS,
                metadata=metadata(self.options, scene_id))
        except ValueError:  # of gRPC, where another thread has closed the channel meanwhile
            return None

    def end_scene(self, scene_id: str) -> None:
        """As `delete_scene`, but for a scene or a daemon that is gone, or does not answer: the lease ends it there."""
        try:
            self.delete_scene(scene_id)
        except Error as error:
            if not (error.is_connection_lost or isinstance(error, (NotFound, DeadlineExceeded))):
                raise

    def has_scene(self, scene_id: str) -> bool:
        """Whether the daemon, or the one that a proxy takes this client to, has it."""
        try:
            self.get_scene(scene_id)
        except NotFound:
            return False
        return True

    def create_scene(self, layout: Layout, options: SceneOptions, lease_seconds: float,
                     tries: int = _CREATE_TRIES) -> scene_pb2.Scene:
        """Retries if the answer is lost, without ever creating two scenes on a daemon."""
        check_seconds(lease_seconds, "lease_seconds")
        request = api.CreateSceneRequest(request_id=uuid.uuid4().hex, spec=self._known_spec(layout, options),
                                         lease_seconds=lease_seconds)
        uploads = self._put_inline(request.spec, layout)
        return self._upload_all(self._create("CreateScene", request, tries), uploads)

    def create_scenes(self, layout: Layout, options: SceneOptions, count: int, lease_seconds: float) -> scene_pb2.Scene:
        """The same for a set of `count` scenes of one spec."""
        if not is_whole(count, UINT32_MAX):
            raise InvalidArgument(f"count is {count!r}; it must be from 1 to 65536", field="count")
        check_seconds(lease_seconds, "lease_seconds")
        request = batch_pb2.CreateScenesRequest(request_id=uuid.uuid4().hex, spec=self._known_spec(layout, options),
                                                count=int(count), lease_seconds=lease_seconds)
        uploads = self._put_inline(request.spec, layout)
        return self._upload_all(self._create("CreateScenes", request), uploads)

    def _known_spec(self, layout: Layout, options: SceneOptions) -> scene_pb2.SceneSpec:
        """The spec of a scene, without its triangles. All fields of contacts, which are the default, are those that the daemon knows."""
        spec = full_spec(layout, options)
        features = self.connect().features
        assert features is not None
        if options.has_all_fields:
            spec.fields[:] = [field for field in spec.fields
                              if not features.lack(f"collided.v1.{contact_pb2.ContactField.Name(field)}")]
        return spec

    def _put_inline(self, spec: scene_pb2.SceneSpec, layout: Layout) -> dict[int, np.ndarray]:
        """Puts triangles into the spec, those of the smallest meshes first. Those of the others, by mesh, which need a call
        each: proto/README.md has the rule."""
        left = min(_MAX_INLINE_BYTES, self.info.limits.max_message_bytes // 2 - spec.ByteSize())
        uploads = {}
        for index, mesh in sorted(layout.present(), key=lambda each: each[1].triangles.nbytes):
            if mesh.triangles.nbytes <= left:
                spec.meshes[index].triangles = mesh.triangles.tobytes()
                left -= mesh.triangles.nbytes
            elif len(mesh.triangles):
                uploads[index] = mesh.triangles
        return uploads

    def _upload_all(self, scene: scene_pb2.Scene, uploads: dict[int, np.ndarray]) -> scene_pb2.Scene:
        if not uploads:
            return scene
        try:
            with self._channel_of_a_call() as channel:
                return self._upload_together(scene.scene_id, uploads, channel)
        except Error:
            self.try_delete(scene.scene_id)
            raise
        except BaseException:  # an interrupt, after which nothing waits
            self.ask_to_delete(scene.scene_id)
            raise

    def _upload_together(self, scene_id: str, uploads: dict[int, np.ndarray], channel: grpc.Channel) -> scene_pb2.Scene:
        """Several at a time, as each takes a round trip. Returns the scene once it has all meshes."""
        left, flying, at_once = deque(uploads), deque[tuple[int, bool, Any]](), _UPLOADS_AT_ONCE
        ready = scene_pb2.Scene()
        try:
            while left or flying:
                while left and len(flying) < at_once:
                    mesh = left.popleft()
                    flying.append((mesh, at_once == 1, self._upload(scene_id, mesh, uploads[mesh], channel)))
                mesh, is_alone, call = flying.popleft()
                try:
                    scene = call.result().scene
                except grpc.RpcError as error:
                    why = error_of_call(error)
                    if is_alone or not isinstance(why, ResourceExhausted):
                        raise why from None
                    at_once = 1  # a client may have few calls open, or little memory: this one goes again, once the others have ended
                    left.appendleft(mesh)
                else:
                    ready = scene if scene.state == scene_pb2.SCENE_STATE_READY else ready
        finally:
            for *_, call in flying:
                call.cancel()
        return ready

    def connect(self, patience: float = math.inf) -> Connection:
        """The connection, made if there is none. Raises Unavailable if no daemon answers in time.

        patience: seconds, if they are to be fewer than those of the options; the next call then goes on with the attempt.
        """
        with self._lock:
            return self._connected(patience)

    def _connected(self, patience: float = math.inf) -> Connection:
        connection = self._connection
        if connection is None or (connection.info is None and connection.address != self.address):
            self._forget()
            address = self.address
            self.options.check(address)
            connection = self._connection = Connection(address, self.options)
        try:
            connection.ask(min(patience, self.options.patience))
        except Error:
            if patience >= self.options.patience:
                self._forget()
            raise
        return connection

    def _forget(self) -> None:
        connection, self._connection = self._connection, None
        if connection is not None:
            connection.retire()

    def separate_channel(self, endpoint: str = "", max_answer_bytes: int = MAX_ANSWER_BYTES) -> grpc.Channel:
        """A connection of its own, to the scene's endpoint if it has one, for answers of so many bytes."""
        address = endpoint or self.address
        self.options.check(address)
        return open_channel(address, self.options, max_answer_bytes)

    @contextmanager
    def stream_channel(self, scene: scene_pb2.Scene, seconds: float = math.inf) -> Iterator[grpc.Channel]:
        """A connection for one stream of the scene, once a daemon answers at its endpoint. Waits for that as `patience` says, but
        no longer than so many seconds, because gRPC itself ends a stream whose connection is refused for a moment. An error that
        ends the context closes the connection."""
        channel = self.separate_channel(scene.endpoint)
        try:
            ask_for_info(channel, scene.endpoint or self.address, self.options, min(self.options.patience, seconds),
                         scene.scene_id)
            yield channel
        except BaseException:
            end_elsewhere(channel.close)
            raise

    def local_socket(self, endpoint: str) -> str:
        """Returns the path of the daemon's local socket, if it has one and may be on this host; else an empty string. A loopback
        address may be a forwarded port: only connecting shows whether the path leads to this daemon."""
        is_here = sys.platform == "linux" and not endpoint and is_local_address(self.address)
        return self.info.local_socket if is_here else ""

    def reconnect(self) -> None:
        """Forgets the connection, unless it is still being made: the daemon may be another one now."""
        with self._lock:
            if self._connection is not None and self._connection.info is not None:
                self._forget()

    def close(self) -> None:
        """Ends the connection, once other threads' calls are done. The client connects again if it is used again."""
        leftovers.settle(leftovers.EXIT_SECONDS)  # scenes may be deleted over this connection
        with self._lock:
            self._forget()

    @contextmanager
    def _channel_of_a_call(self) -> Iterator[grpc.Channel]:
        with self._lock:
            connection = self._connected()
            connection.begin_call()
        try:
            yield connection.channel
        finally:
            connection.end_call()

    def call(self, method: str, request: Any, scene_id: str = "", timeout: float | None = None,
             channel: grpc.Channel | None = None) -> Any:
        """One call, on another channel than the client's if one is given. method: its name."""
        if channel is None:
            with self._channel_of_a_call() as own:
                return self.call(method, request, scene_id, timeout, own)
        self.check_known(request, method=method)
        try:
            call = getattr(CollisionServiceStub(channel), method)
            return call(request, timeout=timeout or self.options.deadline, metadata=metadata(self.options, scene_id))
        except grpc.RpcError as error:
            raise error_of_call(error) from None
        except ValueError:  # of gRPC, where another thread has closed the channel meanwhile
            raise Unavailable("the connection was closed during the call") from None

    def check_known(self, request: Any, path: str = "", method: str = "") -> None:
        """Raises Unimplemented if the daemon is too old for a message, whose path in a request is `path`, or for a method."""
        connection = self._connection  # another thread may hold the lock
        if connection is not None and connection.features is not None:
            if method:
                connection.features.check_method(method)
            connection.features.check(request, path)

    def _create(self, method: str, request: Any, tries: int = _CREATE_TRIES) -> scene_pb2.Scene:
        for tried in range(1, tries + 1):
            try:
                answer = self.call(method, request)
                scene = answer.scenes if method == "CreateScenes" else answer.scene
                if not scene.scene_id:
                    raise DataLoss(f"the daemon's answer to {method} has no scene")
                return scene
            except Unavailable:
                if tried == tries:
                    raise
                time.sleep(_RETRY_SECONDS * tried)
            except ResourceExhausted:
                if tried == tries or not leftovers.settle():
                    raise
        raise AssertionError

    def _upload(self, scene_id: str, mesh: int, triangles: Any, channel: grpc.Channel) -> Any:
        """Begins an upload. Returns a grpc.Future of its answer."""
        starts = range(0, len(triangles), _TRIANGLES_PER_CHUNK)
        chunks = (api.UploadMeshRequest(scene_id=scene_id, mesh=mesh,
                                        triangles=triangles[at:at + _TRIANGLES_PER_CHUNK].tobytes()) for at in starts)
        return CollisionServiceStub(channel).UploadMesh.future(chunks, timeout=self.options.deadline + len(starts),
                                                               metadata=metadata(self.options, scene_id))

    def __repr__(self) -> str:
        return f"<Client of {self.place}>"

    @property
    def place(self) -> str:
        """The daemon's address, for people. Starts no daemon."""
        return self._server or "a daemon of this process"

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _check_address(server: Any) -> None:
    check_text(server, "server")
    if not server or "\0" in server:
        raise InvalidArgument(f"server is {server!r}; it must be 'host:port' or 'unix:/path'", field="server")


def full_spec(layout: Layout, options: SceneOptions) -> scene_pb2.SceneSpec:
    """The spec of a scene, without its triangles."""
    spec = options.spec()
    spec.position_format = options.format(layout).number
    spec.meshes.extend(mesh.spec(with_triangles=False) for _, mesh in layout.present())
    if options.has_all_fields and _can_tell_pairs(spec):
        spec.fields.append(contact_pb2.CONTACT_FIELD_PAIR_STATES)
    spec.excluded_meshes.extend(scene_pb2.MeshPair(first=a, second=b) for a, b in sorted(layout.excluded))
    return spec


def _can_tell_pairs(spec: scene_pb2.SceneSpec) -> bool:
    """Returns True if a scene can have states of pairs. The daemon refuses to be asked for them in other scenes."""
    has_states = (spec.mode != scene_pb2.DETECTION_MODE_CCD and spec.accuracy != scene_pb2.ACCURACY_CANDIDATES
                  and spec.position_format != scene_pb2.POSITION_FORMAT_Q16)
    return has_states and any(mesh.solid for mesh in spec.meshes)
