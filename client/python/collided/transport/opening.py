"""Opens a stream: through shared memory where that can be, else over gRPC."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any

from collided.arrays import is_whole
from collided.connection.channel import metadata
from collided.connection.client import Client
from collided.errors import (DataLoss, DeadlineExceeded, Error, FailedPrecondition, InvalidArgument, NotFound,
                             ResourceExhausted, Unimplemented)
from collided.in_process.client import LocalClient
from collided.in_process.transport import EngineTransport
from collided.transport.base import Transport
from collided.transport.call_transport import CallTransport
from collided.transport.grpc_transport import GrpcTransport
from collided.transport.local_transport import LocalTransport
from collided.transport.peer import NEEDS_LINUX, LocalPeer
from collided.transport.region import Region, region_layout
from collided.v1 import collision_service_pb2 as api
from collided.v1 import scene_pb2

_DEFAULT_WINDOW = 2
MOST_FRAMES = 1024  # that any daemon lets be in flight
_TRANSPORTS = ("auto", "shared_memory", "grpc", "calls")


@dataclass(frozen=True, kw_only=True)
class StreamOptions:
    """How a stream is opened; Session says what each is."""

    window: int
    delivery: Any
    transport: str
    output_bytes: int
    edit_bytes: int
    daemon_user: int | None

    def __post_init__(self) -> None:
        if not isinstance(self.transport, str) or self.transport not in _TRANSPORTS:
            raise InvalidArgument(f"transport is {self.transport!r}; it must be one of {', '.join(_TRANSPORTS)}",
                                  field="transport")
        for name, limit in (("window", 2**32 - 1), ("output_bytes", 2**63), ("edit_bytes", 2**63)):
            value: Any = getattr(self, name)
            if not is_whole(value, limit):
                raise InvalidArgument(f"{name} is {value!r}; it must be from 0 to {limit}", field=name)
        user: Any = self.daemon_user
        if user is not None and not is_whole(user, 2**32 - 1):
            raise InvalidArgument(f"daemon_user is {user!r}; it must be a user's number, or None", field="daemon_user")


def open_transport(client: Client, scene: scene_pb2.Scene, options: StreamOptions,
                   resume: bool, seconds: float) -> tuple[Transport, api.StreamOpened, str]:
    """A stream of the scene, the daemon's answer, and why it is not through shared memory where that was tried. seconds: for the
    answer."""
    opening = api.OpenStream(scene_id=scene.scene_id, window=options.window, delivery=options.delivery,
                             resume_token=scene.resume_token if resume else "")
    client.check_known(opening, "open")
    refusal = ""
    if isinstance(client, LocalClient):
        _check_local(options)
        engine = EngineTransport(client, scene, resume)
        return engine, opened_by(engine, opening, client, seconds), ""
    if options.transport == "calls":
        calls = CallTransport(client)
        return calls, opened_by(calls, opening, client, seconds), ""
    if options.transport != "grpc":
        try:
            local = _local(client, scene, options, opening)
            if local is not None:
                return local, opened_by(local, opening, client, seconds), ""
        except Error as error:
            if options.transport == "shared_memory":
                raise
            refusal = error.message  # if gRPC fails as well, its error is raised
    with client.stream_channel(scene, seconds) as channel:
        transport = GrpcTransport(channel, metadata(client.options, scene.scene_id), client.info.limits.max_message_bytes)
        return transport, opened_by(transport, opening, client, seconds), refusal


def _check_local(options: StreamOptions) -> None:
    """Raises Unimplemented for what an engine in the process does not have."""
    if options.transport != "auto":
        raise Unimplemented(f"transport is {options.transport!r}, but server is 'local', and nothing is sent", field="transport")
    if options.delivery == api.DELIVERY_POLICY_LATEST_WINS:
        raise Unimplemented("delivery is 'latest_wins', but server is 'local', which answers every frame", field="delivery")
    if options.window > MOST_FRAMES:
        raise ResourceExhausted(f"window is {options.window}; the limit is {MOST_FRAMES}", field="window")


def _local(client: Client, scene: scene_pb2.Scene, options: StreamOptions,
           opening: api.OpenStream) -> LocalTransport | None:
    """None if the daemon has no local socket, or is on another host."""
    if options.transport == "auto" and not client.local_socket(scene.endpoint):
        return None
    path = local_socket(client, scene)
    limit = client.info.limits.max_window
    window = options.window or min(_DEFAULT_WINDOW, limit)
    if not 1 <= window <= limit:
        raise ResourceExhausted(f"window is {window}; the daemon's limit is {limit}", field="window")
    opening.window = window
    known = client.get_scene(scene.scene_id)
    # Of each frame in flight, and of those before and after the last one that was answered; if the daemon allows as much.
    lasting = window + 2 if 2 * window + 2 <= limit else 0
    return LocalTransport(LocalPeer(path, client.address, options.daemon_user, client.options),
                          Region(region_layout(known, window, options.output_bytes, options.edit_bytes, lasting)))


def local_socket(client: Client, scene: scene_pb2.Scene) -> str:
    """Path of the local socket of the scene's daemon. Raises FailedPrecondition if it has none that this client can use."""
    path = client.local_socket(scene.endpoint)
    if not path:
        raise FailedPrecondition(NEEDS_LINUX if sys.platform != "linux" else "the daemon has no local socket here (--local-socket)",
                                 field="transport")
    return path


def opened_by(transport: Transport, opening: api.OpenStream, client: Client, seconds: float) -> api.StreamOpened:
    """The daemon's first answer. Raises DeadlineExceeded if none comes within so many seconds, and FailedPrecondition if the local
    socket is another daemon's, as it can be where the client's address is a forwarded port."""
    try:
        transport.open(opening)
        response = transport.read(seconds)
        if response is None:
            raise DeadlineExceeded(f"the daemon at {client.place} did not open the stream within {seconds:.3g} s (deadline)")
        if not response.HasField("opened"):
            raise DataLoss("the daemon's first answer does not open the stream")
        opened, most = response.opened, opening.window or MOST_FRAMES
        if opened.scene.scene_id != opening.scene_id:
            raise DataLoss(f"the daemon opened scene {opened.scene.scene_id!r} instead of {opening.scene_id!r}")
        if not 1 <= opened.window <= most:
            raise DataLoss(f"opened.window is {opened.window}; it must be from 1 to {most}")
        return opened
    except BaseException as error:
        transport.close()
        if transport.is_local and isinstance(error, NotFound) and client.has_scene(opening.scene_id):
            raise FailedPrecondition(f"the local socket {client.info.local_socket} belongs to another daemon than the one at "
                                     f"{client.place}; gRPC reaches it (transport='grpc')", field="transport") from None
        raise
