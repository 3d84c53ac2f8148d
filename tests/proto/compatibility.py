"""Compares protocols by their descriptors: what breaks clients of a release, and what is newer than it."""

import pathlib
import subprocess
import tempfile

from google.protobuf import descriptor_pb2, descriptor_pool
from google.protobuf.descriptor_pb2 import DescriptorProto, FieldDescriptorProto

try:
    from google.protobuf.message_factory import GetMessageClass as message_class
except ImportError:  # protobuf before 4.22
    from google.protobuf.message_factory import MessageFactory

    message_class = MessageFactory().GetPrototype

OPTIONS = {kind: "collided.v1." + kind + "_added_in" for kind in ("field", "value", "method")}


def read_image(file):
    """The files of a committed image, as protoc --descriptor_set_out --include_imports writes it."""
    return descriptor_pb2.FileDescriptorSet.FromString(pathlib.Path(file).read_bytes())


def compile_protocol(folder):
    """The same of a folder with collided/v1/*.proto."""
    files = sorted(str(file.relative_to(folder)) for file in pathlib.Path(folder).glob("collided/v1/*.proto"))
    with tempfile.NamedTemporaryFile() as out:
        subprocess.run(["protoc", f"-I{folder}", "--include_imports", f"--descriptor_set_out={out.name}", *files], check=True)
        return read_image(out.name)


class Protocol:
    """Messages, enums and methods of an image, by their full names."""

    def __init__(self, image):
        self.image = image
        self.messages, self.enums, self.methods = {}, {}, {}
        for file in image.file:
            if file.package.startswith("google."):
                continue
            self._add(file.package, file.message_type, file.enum_type)
            for service in file.service:
                for method in service.method:
                    self.methods[f"{file.package}.{service.name}.{method.name}"] = method

    def _add(self, scope, messages, enums):
        self.enums |= {f"{scope}.{enum.name}": enum for enum in enums}
        for message in messages:
            name = f"{scope}.{message.name}"
            self.messages[name] = message
            self._add(name, message.nested_type, message.enum_type)

    def elements(self, kinds=("field", "value", "method")):
        """Every field, enum value and method: its full name, its kind and itself."""
        if "field" in kinds:
            yield from ((f"{name}.{f.name}", "field", f) for name, message in self.messages.items() for f in message.field)
        if "value" in kinds:  # named beside its enum
            yield from ((f"{name.rpartition('.')[0]}.{v.name}", "value", v) for name, enum in self.enums.items() for v in enum.value)
        if "method" in kinds:
            yield from ((name, "method", method) for name, method in self.methods.items())


def breaks(before, after):
    """Says what of `after` breaks clients and daemons that were built with `before`, on the wire or in JSON."""
    old, new = Protocol(before), Protocol(after)
    found = []
    for kind in ("messages", "enums", "methods"):
        missing = getattr(old, kind).keys() - getattr(new, kind).keys()
        found += [f"{name} is gone" for name in sorted(missing)]
    for name in old.messages.keys() & new.messages.keys():
        found += _fields_broken(name, old.messages[name], new.messages[name])
    for name in old.enums.keys() & new.enums.keys():
        found += _numbers_broken(name, old.enums[name], new.enums[name], old.enums[name].value, new.enums[name].value)
    for name in old.methods.keys() & new.methods.keys():
        for what in ("input_type", "output_type", "client_streaming", "server_streaming"):
            a, b = getattr(old.methods[name], what), getattr(new.methods[name], what)
            if a != b:
                found.append(f"{name}: {what} was {a}, is {b}")
    return sorted(found)


def _ranges(holder):
    """Reserved numbers, as half-open ranges: those of enums include their ends."""
    more = 0 if isinstance(holder, DescriptorProto) else 1
    return [(each.start, each.end + more) for each in holder.reserved_range]


def _numbers_broken(name, old, new, old_elements, new_elements):
    """Of fields or enum values: those that are gone and not reserved, renamed, or reserved no longer."""
    now = {each.number: each for each in new_elements}
    found = []
    for each in old_elements:
        successor = now.get(each.number)
        if successor is None:
            is_reserved = each.name in new.reserved_name and any(a <= each.number < b for a, b in _ranges(new))
            if not is_reserved:
                found.append(f"{name}.{each.name} = {each.number} is gone and not reserved")
        elif successor.name != each.name:
            found.append(f"{name}: {each.number} was {each.name}, is {successor.name}")
    for start, end in _ranges(old):
        if not any(a <= start and end <= b for a, b in _ranges(new)):
            found.append(f"{name}: {start} to {end - 1} is reserved no longer")
    found += [f"{name}: {word} is reserved no longer" for word in old.reserved_name if word not in new.reserved_name]
    return found


def _oneof(message, field):
    return message.oneof_decl[field.oneof_index].name if field.HasField("oneof_index") else ""


def _fields_broken(name, old, new):
    found = _numbers_broken(name, old, new, old.field, new.field)
    now = {field.number: field for field in new.field}
    for field in old.field:
        successor = now.get(field.number)
        if successor is None or successor.name != field.name:
            continue
        for what in ("type", "type_name", "label", "json_name", "proto3_optional"):
            a, b = getattr(field, what), getattr(successor, what)
            if a != b:
                found.append(f"{name}.{field.name}: {what} was {a}, is {b}")
        if _oneof(old, field) != _oneof(new, successor):
            found.append(f"{name}.{field.name}: oneof was {_oneof(old, field)!r}, is {_oneof(new, successor)!r}")
    return found


def asked(protocol):
    """Messages and enums that a request can hold: over gRPC, and as packets of the local socket."""
    reached, left = set(), [method.input_type[1:] for method in protocol.methods.values()] + ["collided.v1.LocalRequest"]
    while left:
        name = left.pop()
        if name in reached:
            continue
        reached.add(name)
        fields = protocol.messages[name].field if name in protocol.messages else ()
        left += [f.type_name[1:] for f in fields if f.type in (FieldDescriptorProto.TYPE_MESSAGE, FieldDescriptorProto.TYPE_ENUM)]
    return reached


def additions(image):
    """What names the release that brought it (collided/v1/added_in.proto): full names, and the releases."""
    pool = descriptor_pool.DescriptorPool()
    for file in image.file:
        pool.Add(file)
    found = {}
    for name, kind, element in Protocol(image).elements():
        options = message_class(pool.FindMessageTypeByName("google.protobuf." + type(element.options).__name__)).FromString(
            element.options.SerializeToString())
        release = options.Extensions[pool.FindExtensionByName(OPTIONS[kind])]
        if release:
            found[name] = release
    return found


def unnamed(before, after):
    """What requests can have in `after` and not in `before`, without the release that brings it."""
    old, new = Protocol(before), Protocol(after)
    known = {name for name, *_ in old.elements()}
    holders = asked(new)
    found = [name for name, *_ in new.elements(("field",)) if name.rpartition(".")[0] in holders]
    found += [f"{name.rpartition('.')[0]}.{value.name}" for name, enum in new.enums.items() if name in holders for value in enum.value]
    found += list(new.methods)
    return sorted(set(found) - known - additions(after).keys())
