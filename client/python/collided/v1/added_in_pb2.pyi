from google.protobuf import descriptor_pb2 as _descriptor_pb2
from google.protobuf import descriptor as _descriptor
from typing import ClassVar as _ClassVar

DESCRIPTOR: _descriptor.FileDescriptor
FIELD_ADDED_IN_FIELD_NUMBER: _ClassVar[int]
METHOD_ADDED_IN_FIELD_NUMBER: _ClassVar[int]
VALUE_ADDED_IN_FIELD_NUMBER: _ClassVar[int]
field_added_in: _descriptor.FieldDescriptor
method_added_in: _descriptor.FieldDescriptor
value_added_in: _descriptor.FieldDescriptor
