from collided.v1 import collision_service_pb2 as _collision_service_pb2
from collided.v1 import frame_pb2 as _frame_pb2
from collided.v1 import shared_range_pb2 as _shared_range_pb2
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from typing import ClassVar as _ClassVar, Mapping as _Mapping, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class LocalClosed(_message.Message):
    __slots__ = ["code", "field", "message"]
    CODE_FIELD_NUMBER: _ClassVar[int]
    FIELD_FIELD_NUMBER: _ClassVar[int]
    MESSAGE_FIELD_NUMBER: _ClassVar[int]
    code: int
    field: str
    message: str
    def __init__(self, code: _Optional[int] = ..., message: _Optional[str] = ..., field: _Optional[str] = ...) -> None: ...

class LocalOpen(_message.Message):
    __slots__ = ["cuda_ipc_handle", "input_bytes", "open", "output_bytes", "output_cuda_ipc_handle", "token", "version"]
    CUDA_IPC_HANDLE_FIELD_NUMBER: _ClassVar[int]
    INPUT_BYTES_FIELD_NUMBER: _ClassVar[int]
    OPEN_FIELD_NUMBER: _ClassVar[int]
    OUTPUT_BYTES_FIELD_NUMBER: _ClassVar[int]
    OUTPUT_CUDA_IPC_HANDLE_FIELD_NUMBER: _ClassVar[int]
    TOKEN_FIELD_NUMBER: _ClassVar[int]
    VERSION_FIELD_NUMBER: _ClassVar[int]
    cuda_ipc_handle: bytes
    input_bytes: int
    open: _collision_service_pb2.OpenStream
    output_bytes: int
    output_cuda_ipc_handle: bytes
    token: str
    version: int
    def __init__(self, version: _Optional[int] = ..., open: _Optional[_Union[_collision_service_pb2.OpenStream, _Mapping]] = ..., token: _Optional[str] = ..., input_bytes: _Optional[int] = ..., output_bytes: _Optional[int] = ..., cuda_ipc_handle: _Optional[bytes] = ..., output_cuda_ipc_handle: _Optional[bytes] = ...) -> None: ...

class LocalRequest(_message.Message):
    __slots__ = ["frame", "open", "shared_frame"]
    FRAME_FIELD_NUMBER: _ClassVar[int]
    OPEN_FIELD_NUMBER: _ClassVar[int]
    SHARED_FRAME_FIELD_NUMBER: _ClassVar[int]
    frame: _frame_pb2.Frame
    open: LocalOpen
    shared_frame: _shared_range_pb2.SharedRange
    def __init__(self, open: _Optional[_Union[LocalOpen, _Mapping]] = ..., frame: _Optional[_Union[_frame_pb2.Frame, _Mapping]] = ..., shared_frame: _Optional[_Union[_shared_range_pb2.SharedRange, _Mapping]] = ...) -> None: ...

class LocalResponse(_message.Message):
    __slots__ = ["closed", "frame"]
    CLOSED_FIELD_NUMBER: _ClassVar[int]
    FRAME_FIELD_NUMBER: _ClassVar[int]
    closed: LocalClosed
    frame: _collision_service_pb2.StreamFramesResponse
    def __init__(self, frame: _Optional[_Union[_collision_service_pb2.StreamFramesResponse, _Mapping]] = ..., closed: _Optional[_Union[LocalClosed, _Mapping]] = ...) -> None: ...
