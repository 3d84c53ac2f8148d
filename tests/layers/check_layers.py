#!/usr/bin/env python3
"""Checks include dependencies, that each header compiles alone, and that a README says what each folder is for.

usage: check_layers.py includes ROOT
       check_layers.py folders ROOT
       check_layers.py headers ROOT COMPILER INCLUDE_DIR...

A header that is the first include of another header is compiled alone with that. Sources do not count: they have
precompiled headers, which would hide what is missing.
"""

import collections
import concurrent.futures
import functools
import os
import pathlib
import re
import subprocess
import sys
import tempfile

SOURCES = {".hpp", ".cpp", ".cuh", ".cu"}
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')
CUDA = re.compile(r"^(cuda|cub/|thrust/|nvtx3/|nvToolsExt|device_launch_parameters|cooperative_groups|curand|nvml)")
STANDARD = re.compile(r"^(c?[a-z_0-9]+|(math|stdint|stddef|string|float|immintrin)\.h)$")
CONDITION = re.compile(r"^\s*#\s*if")
END_OF_CONDITION = re.compile(r"^\s*#\s*endif")
# Rough guesses: parsing costs a header's bytes, which of others' headers are not counted; precompiling costs as much as
# parsing several times, and more.
SYSTEM_COST, LIBRARY_COST, PRECOMPILING, WRITING = 20_000, 500_000, 3, 300_000
SYSTEM = re.compile(r"^(sys/.*|[a-z_0-9]+(\.h)?)$")
NO_SOURCE = {"results", "data", "changes", "recordings", "node_modules", "dist", "__pycache__"}
MESSAGES = re.compile(r"\.pb\.h$")


GRPC = re.compile(r"^(grpc|grpcpp|google/protobuf)/")

# The server's folders, from the bottom up, and those that each may include besides itself. Files at the server's root
# include them all; of these, the folders know only SERVER_COMMON.
SERVER_COMMON = {"server/errors.hpp", "server/shorten.hpp"}
SERVER_FOLDERS = {
    "refusals": set(),
    "config/file": set(),
    "config": {"config/file"},
    "net/sockets": set(),
    "net": {"net/sockets"},
    "ops/supervisor": set(),
    "ops": {"net", "net/sockets"},
    "auth": {"config/file", "config", "ops"},
    "devices": {"config", "ops", "auth"},
    "limits": {"ops", "auth", "devices"},
    "scenes/scene": {"refusals", "config", "ops", "auth", "devices"},
    "scenes": {"refusals", "config", "ops", "auth", "limits", "devices", "scenes/scene"},
    "convert": {"refusals", "config", "auth", "devices", "scenes", "scenes/scene"},
    "sets": {"refusals", "scenes", "convert"},
    "frames": {"refusals", "config", "ops", "limits", "scenes", "scenes/scene", "convert", "sets"},
    "transport/local": {"refusals", "net/sockets", "ops", "auth", "scenes", "convert", "frames"},
    "transport/in_process": {"refusals", "ops", "auth", "scenes", "convert", "frames"},
    "transport/grpc": {"refusals", "ops", "auth", "limits", "scenes", "convert", "frames"},
    "batch": {"refusals", "ops", "auth", "limits", "scenes", "convert", "sets", "frames", "transport/grpc"},
    "service": {"refusals", "config", "ops", "auth", "limits", "devices", "scenes", "scenes/scene", "convert", "frames", "transport/grpc", "batch"},
    "builtin": {"refusals", "ops", "auth", "limits", "convert", "transport/grpc"},
}
# These headers are the engine for its users.
ENGINE_API = {"gpu/detector.hpp", "gpu/types.hpp", "gpu/stencil.hpp"}
SPEAKS_MESSAGES = re.compile(r"(refusals|convert|sets|transport|batch|service|builtin)/|frames/(answer|decode|intake|messages|watched)\.")
SPEAKS_GRPC = re.compile(r"(refusals|convert|sets|frames|transport|batch|service|builtin)/|auth/credentials\.|[^/]+$")


def may_see_messages(path):
    return path.startswith(("client/", "proto/")) or SPEAKS_MESSAGES.match(path.removeprefix("server/"))


def server_folder(path):
    """The folder of a file of the server; none for its root."""
    folder = path.removeprefix("server/").rpartition("/")[0]
    return folder if folder else None


def server_complaint(path, target):
    """Why the file of the server at `path` may not include `target`."""
    folder = server_folder(path)
    if GRPC.match(target) and not SPEAKS_GRPC.match(path.removeprefix("server/")):
        return "gRPC and protobuf begin at server/convert, except for server/refusals and server/auth/credentials"
    if target.startswith("gpu/") and target not in (*ENGINE_API, QUOTA):
        return "the server knows the engine by gpu/detector.hpp and gpu/stencil.hpp, and its quotas by gpu/sharded_quota.hpp"
    if target.startswith("client/"):
        return "the server must not know the client"
    if folder is None or not target.startswith("server/") or target in SERVER_COMMON:
        return None
    if folder not in SERVER_FOLDERS:
        return f"server/{folder} is not a folder that tests/layers knows"
    other = server_folder(target)
    if other != folder and other not in SERVER_FOLDERS[folder]:
        return f"server/{folder} must not know server/{other or ''}"
    return None


# The engine's folders, and those that each may include besides itself: data flows from the later to the earlier.
FOLDERS = {"base": set(), "exact": {"base"}, "exec": {"base"}, "contacts": {"base", "exec"}}
FOLDERS |= {folder: {"base", "exec", "contacts"} for folder in ("positions", "boxes", "narrow")}
FOLDERS["search"] = {"base", "exec", "contacts", "boxes"}
FOLDERS["tables"] = {"base", "contacts", "exec", "search"}
FOLDERS["state"] = {"base", "exec", "contacts", "boxes", "search", "narrow"}
FOLDERS["engines"] = {"base", "exec", "contacts", "boxes", "narrow", "state"}
FOLDERS["solids"] = {"base", "exec", "contacts", "boxes", "narrow", "engines", "exact"}
FOLDERS["step"] = FOLDERS["state"] | {"state", "engines", "exact", "solids"}
FOLDERS["scene"] = FOLDERS["step"] | {"positions", "step", "tables"}
# What a step's counters and plan hold of an engine's.
COUNTED_OF_ENGINES = {f"gpu/engines/octree/{name}.hpp" for name in ("levels", "octree_plan", "subdivision")}
# The specification of a scene, and the top.
TYPES, ROOF = "gpu/types.hpp", "gpu/detector.hpp"
# What a scene on several devices tells its caller's limits.
QUOTA = "gpu/sharded_quota.hpp"
CONTACTS = "gpu/contact_set.hpp"
UNDER_THE_ROOF = {"gpu/detector.cpp"}


def folder_of(path):
    """The engine's folder that a file is in; None for those at its root."""
    match = re.match(r"gpu/([^/]+)/", path)
    return match and match[1]


def names_of(headers):
    return ", ".join(sorted(header.removeprefix("gpu/") for header in headers))


def engine_complaint(path, target):
    """Why a file of the engine may not include another one of it."""
    folder, other = folder_of(path), folder_of(target)
    if target == ROOF:
        known = folder == "scene" or path in UNDER_THE_ROOF
        return None if known else "gpu/detector.hpp is the roof: what is below knows gpu/types.hpp"
    if target == QUOTA:
        return None if folder == "scene" else "scene alone tells quotas of shards"
    if target == CONTACTS:
        return "base knows no contacts" if folder == "base" else None
    if target == TYPES:
        return f"{folder} knows no scene" if folder in ("base", "exact") else None
    if folder is None:
        return None
    if folder not in FOLDERS:
        return f"{folder} is not a folder that tests/layers knows"
    if folder == "state" and target in COUNTED_OF_ENGINES:
        return None
    if other != folder and other not in FOLDERS[folder]:
        return f"{folder} must not know {other}"
    if folder == "exact" and other == "base" and target not in EXACT_BASE:
        return "of base, the exact decisions know these alone: " + names_of(EXACT_BASE)
    if other == "exact" and folder != "exact" and target not in EXACT_API:
        return "of gpu/exact, others know these alone: " + names_of(EXACT_API)
    if path.startswith(EXACT_FIXED) and other == "exact" and not target.startswith(EXACT_FIXED):
        return "gpu/exact/fixed runs on every backend and knows nothing of the rest of gpu/exact"
    return None


# What the rest of the engine may see of gpu/exact; GMP stays behind these headers.
EXACT_FIXED = "gpu/exact/fixed/"
EXACT_API = {f"gpu/exact/{name}.hpp" for name in (
    "closest_features", "crossings", "decision", "exact", "nearest", "overlap", "poll", "rays", "volumes", "fixed/decide",
    "fixed/parting", "fixed/ray_triangle")}
EXACT_BASE = {f"gpu/base/{name}.hpp" for name in (
    "box", "closest_features", "contact_distance", "host_device", "rounding", "twofold", "vec3")}

# The one folder above client/cpp and server, and what it may know of the server.
IN_PROCESS = "client/in_process/"
SERVER_IN_PROCESS = {"server/in_process.hpp"}

# What reads the protocol's own descriptors.
ADDITIONS = "proto/additions"
# The engine for programs of any language: it is linked with the engine alone.
C_LIBRARY = "client/c/"

# Inside the client: who must not include what, and why.
CLIENT_RULES = [
    (r"client/scenes/", r"client/(?!scenes/)", "scenes know only themselves"),
    (r"client/cpp/", r"client/(?!cpp/)", "the C++ library knows only itself and the protocol"),
    (r"client/cpp/(?!frame_stream_state)\w+\.hpp$", r"client/cpp/(transport|session)/", "public headers show nothing inside"),
    (r"client/cpp/transport/", r"client/cpp/(client|frame_stream|session)", "transports know no stream"),
    (r"client/cli/manual/", r"client/(?!cli/manual/)", "what is made from options knows nothing of what they are for"),
    (r"client/cli/manual/(?!describe)", r"CLI/", "describe() is the only one that knows CLI11"),
    (r"client/c/", r"client/(?!c/)|(grpc|grpcpp|google)/|collided/v1/", "the C library is the engine alone, without gRPC and protobuf"),
    (r"client/(?!c/)", r"client/c/", "the C library is for programs of others"),
    (r"client/in_process/", r"client/(?!in_process/|cpp/)", "the engine in a process is a part of the C++ library"),
    (r"client/(?!in_process/)", r"client/in_process/", "what is linked with the client alone knows no engine"),
    (r"client/in_process/local\.hpp$", r"server/|client/cpp/transport/", "public headers show nothing inside"),
    (r"client/app/", r"client/(cli|measure)/", "what commands and measurements share knows neither"),
    (r"client/cli/\w+/", r"client/(cli/\w+\.hpp$|measure/)", "what commands do knows no command and no measurement"),
    (r"client/measure/", r"client/cli/", "measurements know no command"),
    (r"client/(measure|app/(daemon|input|output|report)|cli/(batch|dataset|live|picture|recording|web))/", r"CLI/|client/app/options/(?!values|usage_error)",
     "what options have chosen is in options/values.hpp; CLI11 takes longer to compile than all else"),
    (r"client/(?!cli/web/page_server\.cpp)(app|cli)/", r"boost/(asio|beast)", "Boost.Beast, slow to compile, stays in web/page_server.cpp"),
]


def complaint(path, quote, target):
    """Why the file at `path` may not include `target`; None if it may."""
    layer = path.split("/")[0]
    if target in ("gmp.h", "gmpxx.h"):
        if not path.startswith("gpu/exact/") or path.startswith(EXACT_FIXED) or path in EXACT_API:
            return "GMP belongs to gpu/exact, but not to what others include of it"
        return None
    if (MESSAGES.search(target) or target.startswith("proto/")) and not may_see_messages(path):
        return "the protocol belongs to client and to where the server converts or speaks it"
    if CUDA.match(target) and quote == "<":
        if not re.match(r"gpu/((exec|search)/cuda/.*\.cuh|.*\.cu)$", path):
            return "CUDA headers belong to gpu/exec/cuda, gpu/search/cuda and *.cu"
        return None
    if layer == "gpu":
        if quote == '"' and not target.startswith("gpu/"):
            return "the engine includes only itself, rooted at the repository"
        if target == "dlfcn.h" and path == "gpu/exec/cuda/driver.cuh":
            return None  # a machine may have no driver
        if quote == "<" and not (STANDARD.match(target) or target.startswith(("tbb/", "oneapi/tbb/"))):
            return "the engine uses only the standard library, TBB and CUDA"
        if quote == '"':
            return engine_complaint(path, target)
    if layer == "server":
        return server_complaint(path, target)
    if layer == "proto" and not STANDARD.match(target) and not path.startswith(ADDITIONS):
        return "the protocol's constants need the standard library alone"
    if layer == "client" and target.startswith(("gpu/", "server/")):
        if path.startswith(C_LIBRARY):
            return None if target in ENGINE_API else "client/c knows the engine by its public headers alone"
        if not path.startswith(IN_PROCESS):
            return "the client knows the protocol alone"
        if target not in SERVER_IN_PROCESS:
            return "client/in_process knows the server by server/in_process.hpp alone"
    for includer, included, why in CLIENT_RULES:
        if re.match(includer, path) and re.match(included, target):
            return why
    return None


def sources(root):
    for layer in ("gpu", "proto", "server", "client"):
        for file in sorted((root / layer).rglob("*")):
            if file.suffix in SOURCES and "node_modules" not in file.parts:
                yield file


def bad_includes(root):
    found = []
    for file in sources(root):
        path = file.relative_to(root).as_posix()
        for number, line in enumerate(file.read_text().splitlines(), 1):
            match = INCLUDE.match(line)
            why = match and complaint(path, match[1], match[2])
            if why:
                found.append(f"{path}:{number}: {match[2]}: {why}")
    return found


def generated_folders(root):
    """Folders of files that .gitattributes marks as generated."""
    lines = (root / ".gitattributes").read_text().splitlines()
    return {line.split()[0].strip("/").rpartition("/")[0] for line in lines if line.endswith(" linguist-generated")}


def nameless_folders(root):
    """Folders of source code that have no README and that no README above them names, as in `search/cpu/` or `cpu/`.

    A folder of tests that mirrors one of these is what the tree says it is.
    """
    found, folders, generated = [], 0, generated_folders(root)
    for layer in ("proto", "gpu", "server", "client", "tests", "deploy"):
        for folder, subfolders, files in os.walk(root / layer):
            subfolders[:] = [name for name in subfolders if name not in NO_SOURCE]
            path = pathlib.Path(folder)
            name = path.relative_to(root).as_posix()
            if not files or name in generated:
                continue
            folders += 1
            if "README.md" not in files and not is_named(root, path):
                found.append(f"{name}: no README.md above it says what it is for")
    return sorted(found), folders


@functools.lru_cache(maxsize=None)
def page(file):
    return file.read_text() if file.is_file() else ""


def is_named(root, folder):
    path = folder.relative_to(root)
    if path.parts[0] == "tests" and root.joinpath(*path.parts[1:]).is_dir():
        return True
    named = re.compile(rf"[`(/]{re.escape(folder.name)}/")
    return any(named.search(page(above / "README.md")) for above in folder.parents if above.is_relative_to(root))


def own_includes(root, file):
    """Lists what `file` includes outside of conditions: its name and, if it is ours, its file."""
    found, depth = [], 0
    for line in file.read_text().splitlines():
        if CONDITION.match(line):
            depth += 1
        elif END_OF_CONDITION.match(line):
            depth -= 1
        match = INCLUDE.match(line)
        if match and depth == 0:
            places = (folder / match[2] for folder in (root, file.parent))
            found.append((match[2], next((place for place in places if match[1] == '"' and place.is_file()), None)))
    return found


class Headers:
    """Knows the headers of a tree that must compile alone, and what each includes, directly or not."""

    def __init__(self, root):
        self.root, self.includes, self.reached = root, {}, {}
        headers = [file for file in sources(root) if file.suffix == ".hpp"]
        # What a header includes first is compiled alone with it.
        first = {includes[0][0] for header in headers if (includes := self.included_by(header))}
        self.alone = [header for header in headers if self.name(header) not in first]

    def name(self, header):
        return header.relative_to(self.root).as_posix()

    def included_by(self, header):
        if header not in self.includes:
            self.includes[header] = own_includes(self.root, header)
        return self.includes[header]

    def closure(self, header):
        """Returns the names of all headers that `header` includes, with an estimate of what each costs to parse."""
        if header not in self.reached:
            self.reached[header] = {}  # of a header that includes itself
            reached = {}
            for name, file in self.included_by(header):
                if file:
                    reached |= self.closure(file) | {self.name(file): file.stat().st_size}
                else:
                    reached[name] = self.cost(name)
            self.reached[header] = reached
        return self.reached[header]

    def cost(self, name):
        """Estimates the cost of parsing a header with all that it includes."""
        file = self.root / name
        if not file.is_file():
            return SYSTEM_COST if SYSTEM.match(name) else LIBRARY_COST
        return file.stat().st_size + sum(self.closure(file).values())

    def bases(self):
        """Chooses a precompiled header for headers of `alone`: one of those that they include.

        It hides nothing that such a header lacks. One of ours is compiled alone when it is precompiled.
        """
        users = collections.defaultdict(list)
        for header in self.alone:
            for name in self.closure(header):
                users[name].append(header)
        costs = {name: self.cost(name) for name in users}
        best, saved = {}, collections.Counter()

        def gain(name):
            return sum(max(0, costs[name] - saved[header]) for header in users[name]) - PRECOMPILING * costs[name] - WRITING

        while users:
            name = max(sorted(users), key=gain)
            if gain(name) <= 0:
                break
            for header in users.pop(name):
                if costs[name] > saved[header]:
                    best[header], saved[header] = name, costs[name]
        return best


def bad_headers(root, compiler, include_dirs):
    """Finds headers that do not compile as the only include of a file. Includes must come first in each of them."""
    options = ["-std=c++20", "-Wall", "-Wextra", "-Werror", "-Winvalid-pch", '-DCOLLIDED_VERSION="0"', f"-I{root}",
               *(f"-isystem{d}" for d in include_dirs)]
    headers = Headers(root)
    bases = headers.bases()
    chosen = sorted(set(bases.values()))

    def compiled(arguments, text):
        run = subprocess.run([compiler, *options, *arguments], input=text, capture_output=True, text=True, cwd=root)
        return run.stderr if run.returncode else None

    def including(name):
        file = root / name
        return f'#include "{name}"\n' if file.is_file() else f"#include <{name}>\n"

    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        wrappers = {name: pathlib.Path(folder, f"{number}.hpp") for number, name in enumerate(chosen)}

        def precompile(name):
            wrappers[name].write_text(including(name))
            return compiled(["-x", "c++-header", str(wrappers[name]), "-o", f"{wrappers[name]}.gch"], "")

        def compile_alone(header):
            base = bases.get(header)
            below = ["-include", str(wrappers[base])] if base in usable else []
            return compiled(["-fsyntax-only", *below, "-x", "c++", "-"], including(headers.name(header)))

        errors = list(pool.map(precompile, chosen))
        usable = {name for name, error in zip(chosen, errors) if not error}
        rest = [header for header in headers.alone if headers.name(header) not in wrappers]
        errors += pool.map(compile_alone, rest)
    return [error for error in errors if error], len(headers.alone)


def main(arguments):
    if len(arguments) == 2 and arguments[0] == "includes":
        root = pathlib.Path(arguments[1])
        problems, count = bad_includes(root), len(list(sources(root)))
    elif len(arguments) == 2 and arguments[0] == "folders":
        problems, count = nameless_folders(pathlib.Path(arguments[1]))
    elif len(arguments) >= 3 and arguments[0] == "headers":
        problems, count = bad_headers(pathlib.Path(arguments[1]), arguments[2], arguments[3:])
    else:
        sys.exit(__doc__)
    print("\n".join(problems))
    print(f"{count} {'folders' if arguments[0] == 'folders' else 'files'}, {len(problems)} problems")
    return 1 if problems or not count else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
