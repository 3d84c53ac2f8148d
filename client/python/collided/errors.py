"""The errors of this package: one hierarchy, a class for each code."""

from __future__ import annotations

import grpc
from google.protobuf.message import DecodeError

from collided.v1 import error_details_pb2, frame_pb2


class Error(Exception):
    """A request that was refused, or a daemon that was lost.

    code: name of the google.rpc code, such as "INVALID_ARGUMENT".
    message: the field or argument, its value and the limit.
    field: path of the refused field, such as "frame.updates[0].positions"; may be empty.
    quota: the limit that was reached, its value and what was requested; may be empty.
    retry_after: seconds after which the same request may succeed; None if waiting does not help.
    frame_id: the frame that was refused; 0 if it was no frame.
    """

    code = "UNKNOWN"

    def __init__(self, message: str, *, field: str = "", quota: str = "", retry_after: float | None = None,
                 frame_id: int = 0) -> None:
        super().__init__(message)
        self.message = message
        self.field = field
        self.quota = quota
        self.retry_after = retry_after
        self.frame_id = frame_id

    def __str__(self) -> str:
        return f"{self.code}: {self.message}"

    @property
    def is_connection_lost(self) -> bool:
        """Whether the connection or the daemon was lost, rather than a request refused: reconnect and resume."""
        return isinstance(self, (Unavailable, Cancelled, Internal))


class Cancelled(Error):
    """The client cancelled; if nobody asked for it, the connection broke."""

    code = "CANCELLED"


class InvalidArgument(Error, ValueError):
    """A value that cannot be used. Raised before anything is sent where the package can tell."""

    code = "INVALID_ARGUMENT"


class DeadlineExceeded(Error, TimeoutError):
    """No answer in time. A frame stays in flight: receive it later."""

    code = "DEADLINE_EXCEEDED"


class NotFound(Error, LookupError):
    """No such scene of this client."""

    code = "NOT_FOUND"


class AlreadyExists(Error):
    """The request id made another scene."""

    code = "ALREADY_EXISTS"


class PermissionDenied(Error, PermissionError):
    """A wrong resume token, or a user who may not be trusted."""

    code = "PERMISSION_DENIED"


class ResourceExhausted(Error):
    """Past a limit or a memory budget."""

    code = "RESOURCE_EXHAUSTED"


class FailedPrecondition(Error):
    """Not now: the message says what has to come first."""

    code = "FAILED_PRECONDITION"


class Aborted(Error):
    """Another stream took the scene over."""

    code = "ABORTED"


class Unimplemented(Error, NotImplementedError):
    """The daemon does not have it."""

    code = "UNIMPLEMENTED"


class Internal(Error):
    """A defect, or a connection that broke."""

    code = "INTERNAL"


class Unavailable(Error, ConnectionError):
    """Nobody answers, or the daemon stops."""

    code = "UNAVAILABLE"


class DataLoss(Error):
    """An answer that does not make sense."""

    code = "DATA_LOSS"


class Unauthenticated(Error, PermissionError):
    """No token or certificate, or an unknown one."""

    code = "UNAUTHENTICATED"


_CLASSES = {1: Cancelled, 3: InvalidArgument, 4: DeadlineExceeded, 5: NotFound, 6: AlreadyExists, 7: PermissionDenied,
            8: ResourceExhausted, 9: FailedPrecondition, 10: Aborted, 12: Unimplemented, 13: Internal, 14: Unavailable,
            15: DataLoss, 16: Unauthenticated}


def error_of(code: int, message: str, *, field: str = "", quota: str = "", retry_after: float | None = None,
             frame_id: int = 0) -> Error:
    """The error of a google.rpc code."""
    return _CLASSES.get(code, Error)(message, field=field, quota=quota, retry_after=retry_after, frame_id=frame_id)


def error_of_frame(refused: frame_pb2.FrameError, frame_id: int) -> Error:
    """Why a frame was refused."""
    return error_of(refused.code, refused.message, field=refused.field, retry_after=refused.retry_after_seconds or None,
                    frame_id=frame_id)


def error_of_call(error: grpc.RpcError) -> Error:
    """The error of a call that gRPC ended, with the details that the daemon sent."""
    code = error.code() if hasattr(error, "code") else grpc.StatusCode.UNKNOWN
    metadata = (error.trailing_metadata() if hasattr(error, "trailing_metadata") else None) or ()
    packed = next((value for key, value in metadata if key == "grpc-status-details-bin"), b"")
    field, quota, retry_after = _details(packed)
    return error_of(code.value[0], _naming_option(error.details() or str(code)), field=field, quota=quota, retry_after=retry_after)


def _naming_option(message: str) -> str:
    """gRPC refuses what is far above the daemon's limit by itself, and does not know which option sets it."""
    return message + (" (the daemon's option max-message-mb)" if message.startswith("Received message larger than max") else "")


def _details(packed: bytes) -> tuple[str, str, float | None]:
    """Field, quota and seconds to wait."""
    field, quota, retry_after = "", "", None
    try:
        status = error_details_pb2.RpcStatus.FromString(packed)
    except DecodeError:  # details that cannot be read are none
        return field, quota, retry_after
    for detail in status.details:
        kind = detail.type_url.rpartition("/")[2]
        if kind == "google.rpc.BadRequest":
            bad = error_details_pb2.BadRequest.FromString(detail.value)
            field = bad.field_violations[0].field if bad.field_violations else ""
        elif kind == "google.rpc.QuotaFailure":
            failure = error_details_pb2.QuotaFailure.FromString(detail.value)
            quota = "; ".join(f"{v.subject}: {v.description}" for v in failure.violations)
        elif kind == "google.rpc.RetryInfo":
            delay = error_details_pb2.RetryInfo.FromString(detail.value).retry_delay
            retry_after = delay.seconds + delay.nanos * 1e-9
    return field, quota, retry_after


def code_of(error: Error) -> int:
    """The google.rpc code of an error; 2 (UNKNOWN) if it has none."""
    return next((code for code, kind in _CLASSES.items() if type(error) is kind), 2)
