"""The protocol's pages, from protoc's descriptors, which hold the comments of the .proto files.

Everything needs a comment: what has none is an error that names it.
"""

import pathlib
import subprocess
import tempfile

from google.protobuf import descriptor_pb2

import prose

Field = descriptor_pb2.FieldDescriptorProto
# Numbers of the lists in descriptor.proto, of which the paths of comments consist.
FILE_MESSAGES, FILE_ENUMS, FILE_SERVICES, FILE_OPTIONS = 4, 5, 6, 7
MESSAGE_FIELDS, MESSAGE_MESSAGES, MESSAGE_ENUMS = 2, 3, 4
VALUES = METHODS = 2


def descriptors(root):
    """The files of proto/collided/v1."""
    files = sorted((root / "proto/collided/v1").glob("*.proto"))
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder, "set")
        subprocess.run(["protoc", f"-I{root / 'proto'}", f"--descriptor_set_out={out}", "--include_source_info", *files],
                       check=True)
        return descriptor_pb2.FileDescriptorSet.FromString(out.read_bytes()).file


class Page:
    """One .proto file. `missing` names what has no comment."""

    def __init__(self, file):
        self.file = file
        self.package = file.package
        self.lines, self.missing, self.names = [], [], []
        self._comments = {tuple(location.path): location.leading_comments or location.trailing_comments
                          for location in file.source_code_info.location}
        name = pathlib.Path(file.name).name
        self._title(name, "=")
        for i, service in enumerate(file.service):
            self._service(service, (FILE_SERVICES, i))
        for i, message in enumerate(file.message_type):
            self._message(message, (FILE_MESSAGES, i), self.package)
        for i, enum in enumerate(file.enum_type):
            self._enum(enum, (FILE_ENUMS, i), self.package)
        for i, option in enumerate(file.extension):
            head = f"``{option.name}`` = {option.number}: {type_of(option, None)}, of {ref(option.extendee)}"
            self._entry(head, (FILE_OPTIONS, i), f"{self.package}.{option.name}")

    def text(self):
        return "\n".join(self.lines) + "\n"

    def _title(self, text, mark):
        self.lines += [text, mark * len(text), ""]

    def _section(self, name, what):
        self.names.append(name)
        self.lines += [f".. _{name}:", ""]
        self._title(f"{what} {name.removeprefix(self.package + '.')}", "-")

    def _comment(self, path, name, indent=""):
        text = self._comments.get(path, "")
        if not text.strip():
            self.missing.append(name)
        text = "\n".join(line.removeprefix(" ") for line in text.splitlines())
        self.lines += [indent + line if line else "" for line in prose.lines_of(text, has_items=False)] or [""]

    def _entry(self, head, path, name):
        self.names.append(name)
        self.lines.append(head)
        self._comment(path, name, "    ")

    def _service(self, service, path):
        name = f"{self.package}.{service.name}"
        self._section(name, "service")
        self._comment(path, name)
        for i, method in enumerate(service.method):
            takes, gives = (("stream " if streams else "") for streams in (method.client_streaming, method.server_streaming))
            head = f"``{method.name}`` ({takes}{ref(method.input_type)}) → {gives}{ref(method.output_type)}"
            self._entry(head, (*path, METHODS, i), f"{name}.{method.name}")

    def _message(self, message, path, scope):
        name = f"{scope}.{message.name}"
        self._section(name, "message")
        self._comment(path, name)
        for i, field in enumerate(message.field):
            self._entry(f"``{field.name}`` = {field.number}: {type_of(field, message)}", (*path, MESSAGE_FIELDS, i),
                        f"{name}.{field.name}")
        for i, nested in enumerate(message.nested_type):
            if not nested.options.map_entry:
                self._message(nested, (*path, MESSAGE_MESSAGES, i), name)
        for i, enum in enumerate(message.enum_type):
            self._enum(enum, (*path, MESSAGE_ENUMS, i), name)

    def _enum(self, enum, path, scope):
        name = f"{scope}.{enum.name}"
        self._section(name, "enum")
        self._comment(path, name)
        for i, value in enumerate(enum.value):
            self._entry(f"``{value.name}`` = {value.number}", (*path, VALUES, i), f"{name}.{value.name}")


def ref(full_name):
    """A link to a message or enum of the package; the name of another one."""
    name = full_name.removeprefix(".")
    short = name.removeprefix("collided.v1.")
    return f":ref:`{short} <{name}>`" if short != name else f"``{name}``"


def type_of(field, message):
    kind = Field.Type.Name(field.type).removeprefix("TYPE_").lower()
    text = ref(field.type_name) if field.type_name else kind
    for nested in message.nested_type if message else ():
        if nested.options.map_entry and field.type_name.endswith("." + nested.name):
            return f"map of {type_of(nested.field[0], nested)} to {type_of(nested.field[1], nested)}"
    if field.label == Field.LABEL_REPEATED:
        return f"repeated {text}"
    if field.proto3_optional:
        return f"optional {text}"
    if field.HasField("oneof_index"):
        return f"{text}, one of ``{message.oneof_decl[field.oneof_index].name}``"
    return text


def pages(root):
    """{name of a .proto file: its Page}"""
    return {pathlib.Path(file.name).stem: Page(file) for file in sorted(descriptors(root), key=lambda file: file.name)}
