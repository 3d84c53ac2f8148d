"""gRPC channels to one address, with its credentials."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import grpc

import collided.leftovers as leftovers
from collided.connection.options import ConnectOptions, is_local_address
from collided.errors import DeadlineExceeded, Unavailable, error_of_call
from collided.v1 import collision_service_pb2 as api
from collided.v1.collision_service_pb2_grpc import CollisionServiceStub

MAX_ANSWER_BYTES = 4 << 20
_SHORTEST = 0.01  # seconds in which gRPC begins to connect at all
_CONNECTION = (("grpc.keepalive_time_ms", 10_000), ("grpc.keepalive_timeout_ms", 5_000),
               ("grpc.keepalive_permit_without_calls", 1), ("grpc.http2.max_pings_without_data", 0),
               # A daemon that was started again is found soon.
               ("grpc.initial_reconnect_backoff_ms", 100), ("grpc.max_reconnect_backoff_ms", 1_000))


def open_channel(address: str, options: ConnectOptions, max_answer_bytes: int = MAX_ANSWER_BYTES) -> grpc.Channel:
    """A channel of its own, which connects with its first call."""
    settings: list[tuple[str, Any]] = [
        ("grpc.max_receive_message_length", max_answer_bytes), ("grpc.max_send_message_length", -1),
        # Otherwise gRPC shares connections within a process, and failed attempts of one delay the others.
        ("grpc.use_local_subchannel_pool", 1), *_CONNECTION]
    if is_local_address(address):
        settings.append(("grpc.enable_http_proxy", 0))
    if options.tls_server_name:
        settings.append(("grpc.ssl_target_name_override", options.tls_server_name))
    credentials = options.credentials()
    if credentials is None:
        return grpc.insecure_channel(address, settings)
    return grpc.secure_channel(address, credentials, settings)


def ask_for_info(channel: grpc.Channel, address: str, options: ConnectOptions, patience: float,
                 scene_id: str = "") -> api.GetServerInfoResponse:
    """Facts about the daemon. Raises Unavailable, with the reason if gRPC tells, if none answers in time."""
    patience = max(patience, _SHORTEST)
    ask = CollisionServiceStub(channel).GetServerInfo
    carried = metadata(options, scene_id)
    try:
        return ask(api.GetServerInfoRequest(), timeout=patience, metadata=carried, wait_for_ready=True)
    except grpc.RpcError as error:
        known = error_of_call(error)
    if not isinstance(known, (DeadlineExceeded, Unavailable)):
        raise known
    try:  # a call that does not wait is told why
        return ask(api.GetServerInfoRequest(), timeout=min(1.0, patience), metadata=carried)
    except grpc.RpcError as error:
        raise Unavailable(f"no daemon answers at {address} within {patience:g} s (patience): "
                          f"{error_of_call(error).message}") from None


def end_elsewhere(end: Callable[[], None]) -> None:
    """Ends a call or a channel in a thread where no interrupt comes. Waits for that, but not for ever."""
    leftovers.do_elsewhere(end)


def metadata(options: ConnectOptions, scene_id: str = "") -> list[tuple[str, str]]:
    """What every call carries: the token, and the scene for proxies that route by it. What no daemon names a scene by cannot
    be carried: it is left to the daemon not to find."""
    out = [("authorization", f"Bearer {options.token}")] if options.token else []
    is_name = all("!" <= character <= "~" for character in scene_id)
    return [*out, ("scene-id", scene_id)] if scene_id and is_name else out
