"""Reads and writes conversations: messages in both directions, in the order in which they passed the recorder.

An event belongs to a call, which is a gRPC call or a connection to the local socket, and is one of
    begin: the method, or "local"; metadata that matters
    send, receive: a message, as its bytes on the wire; in `memory` the bytes that it names in the memory that both sides share
    half_close: the client sends no more
    end: the status of a gRPC call: its code, and the field that its details name; of a connection nothing

A file has an event a line, as JSON. Bytes are base64.
"""

import base64
import json
import pathlib

from google.protobuf import descriptor_pb2, descriptor_pool
from google.protobuf.descriptor import FieldDescriptor

try:
    from google.protobuf.message_factory import GetMessageClass as message_class
except ImportError:  # protobuf before 4.22
    from google.protobuf.message_factory import MessageFactory

    message_class = MessageFactory().GetPrototype

HERE = pathlib.Path(__file__).resolve().parent
PROTO = HERE.parents[1] / "proto"
LOCAL = "local"
SHARED_RANGE = "collided.v1.SharedRange"
HEALTH = """
name: "health" package: "grpc.health.v1" syntax: "proto3"
message_type { name: "HealthCheckRequest" field { name: "service" number: 1 label: LABEL_OPTIONAL type: TYPE_STRING } }
message_type { name: "HealthCheckResponse" field { name: "status" number: 1 label: LABEL_OPTIONAL type: TYPE_INT32 } }
service { name: "Health"
  method { name: "Check" input_type: ".grpc.health.v1.HealthCheckRequest" output_type: ".grpc.health.v1.HealthCheckResponse" } }
"""


def pack(data):
    return base64.b64encode(data).decode()


def unpack(text):
    return base64.b64decode(text)


def write(file, events):
    file.write_text("".join(json.dumps(event, separators=(",", ":")) + "\n" for event in events))


def read(file):
    return [json.loads(line) for line in file.read_text().splitlines()]


class Messages:
    """The message classes of a release, by its image in proto/releases: newer fields are unknown to them."""

    def __init__(self, release):
        from google.protobuf import text_format

        self._pool = descriptor_pool.DescriptorPool()
        image = descriptor_pb2.FileDescriptorSet.FromString((PROTO / f"releases/{release}.binpb").read_bytes())
        health = text_format.Parse(HEALTH, descriptor_pb2.FileDescriptorProto())
        for file in (*image.file, health):
            self._pool.Add(file)

    def __getitem__(self, name):
        return message_class(self._pool.FindMessageTypeByName(name))

    def of_call(self, method):
        """The classes of a call's requests and answers."""
        if method == LOCAL:
            return self["collided.v1.LocalRequest"], self["collided.v1.LocalResponse"]
        service, _, name = method[1:].partition("/")
        found = self._pool.FindServiceByName(service).FindMethodByName(name)
        return message_class(found.input_type), message_class(found.output_type)


def is_message(field):
    return field.type == FieldDescriptor.TYPE_MESSAGE


def is_repeated(field):
    if hasattr(field, "is_repeated"):  # labels are deprecated in protobuf 6 and later
        return field.is_repeated
    return field.label == FieldDescriptor.LABEL_REPEATED


def shared_ranges(message):
    """Every range that a message names, in the order of its fields."""
    if message.DESCRIPTOR.full_name == SHARED_RANGE:
        yield message
        return
    for field, value in message.ListFields():
        if is_message(field):
            for each in value if is_repeated(field) else (value,):
                yield from shared_ranges(each)
