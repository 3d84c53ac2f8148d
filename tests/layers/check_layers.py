#!/usr/bin/env python3
"""Who may include whom, and whether each header compiles alone.

usage: check_layers.py includes ROOT
       check_layers.py headers ROOT COMPILER INCLUDE_DIR...
"""

import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys

SOURCES = {".hpp", ".cpp", ".cuh", ".cu"}
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')
CUDA = re.compile(r"^(cuda|cub/|thrust/|nvtx3/|nvToolsExt|device_launch_parameters|cooperative_groups|curand|nvml)")
STANDARD = re.compile(r"^(c?[a-z_0-9]+|(math|stdint|stddef|string|float|immintrin)\.h)$")
MESSAGES = re.compile(r"\.pb\.h$")


GRPC = re.compile(r"^(grpc|grpcpp|google/protobuf)/")

# The server's rooms, from the bottom up, and those that each may include besides itself. What is at the server's root
# includes them all; of that, they know only SERVER_COMMON.
SERVER_COMMON = {"server/errors.hpp", "server/shorten.hpp"}
SERVER_ROOMS = {
    "config": set(),
    "net": set(),
    "ops": {"net"},
    "auth": {"config", "ops"},
    "limits": {"ops", "auth"},
    "scenes": {"config", "ops", "auth", "limits"},
    "convert": {"config", "auth", "scenes"},
    "frames": {"config", "ops", "limits", "scenes", "convert"},
    "transport/local": {"net", "ops", "auth", "scenes", "convert", "frames"},
    "transport/grpc": {"ops", "auth", "limits", "scenes", "convert", "frames"},
    "service": {"config", "ops", "auth", "limits", "scenes", "convert", "transport/grpc"},
    "builtin": {"ops", "auth", "limits", "convert", "transport/grpc"},
}
SPEAKS_MESSAGES = re.compile(r"(convert|transport|service|builtin)/|frames/(answer|decode|intake|messages)\.")
SPEAKS_GRPC = re.compile(r"(convert|frames|transport|service|builtin)/|auth/credentials\.|[^/]+$")


def may_see_messages(path):
    return path.startswith("client/") or SPEAKS_MESSAGES.match(path.removeprefix("server/"))


def server_room(path):
    """The room of a file of the server; none for its root."""
    room = path.removeprefix("server/").rpartition("/")[0]
    return room if room else None


def server_complaint(path, target):
    """Why the file of the server at `path` may not include `target`."""
    room = server_room(path)
    if GRPC.match(target) and not SPEAKS_GRPC.match(path.removeprefix("server/")):
        return "gRPC and protobuf begin at server/convert, but for server/auth/credentials"
    if target.startswith("gpu/") and target not in ("gpu/detector.hpp", "gpu/types.hpp"):
        return "the server knows the engine by gpu/detector.hpp alone"
    if target.startswith("client/"):
        return "the server must not know the client"
    if room is None or not target.startswith("server/") or target in SERVER_COMMON:
        return None
    if room not in SERVER_ROOMS:
        return f"server/{room} is no room that tests/layers knows"
    other = server_room(target)
    if other != room and other not in SERVER_ROOMS[room]:
        return f"server/{room} must not know server/{other or ''}"
    return None


def engine_part(path):
    """octree, broad, narrow, exec, math or exact for a file of that folder, pipeline for gpu/pipeline*, else none."""
    match = re.match(r"gpu/(octree|broad|narrow|exec|math|exact)/|gpu/(pipeline)", path)
    return match and (match[1] or match[2])


# What each part of the engine must not include.
STAGES = {"octree", "broad", "narrow"}
FORBIDDEN = {part: STAGES - {part} | {"pipeline", "exact"} for part in STAGES}
FORBIDDEN |= {part: STAGES | {"pipeline", "exact"} for part in ("exec", "math")}
FORBIDDEN["exact"] = STAGES | {"pipeline"}

# What the rest of the engine may see of gpu/exact; GMP stays behind these headers.
EXACT_API = {"gpu/exact/exact.hpp", "gpu/exact/decision.hpp", "gpu/exact/poll.hpp"}


def complaint(path, quote, target):
    """Why the file at `path` may not include `target`; None if it may."""
    layer = path.split("/")[0]
    if target in ("gmp.h", "gmpxx.h"):
        if not path.startswith("gpu/exact/") or path in EXACT_API:
            return "GMP belongs to gpu/exact, but not to what others include of it"
        return None
    if (MESSAGES.search(target) or target.startswith("proto/")) and not may_see_messages(path):
        return "the protocol belongs to client and to where the server converts or speaks it"
    if CUDA.match(target) and quote == "<":
        if not re.match(r"gpu/(exec/.*\.cuh|.*\.cu)$", path):
            return "CUDA headers belong to gpu/exec/*.cuh and *.cu"
        return None
    if layer == "gpu":
        if quote == '"' and not target.startswith("gpu/"):
            return "the engine includes only itself, rooted at the repository"
        if quote == "<" and not (STANDARD.match(target) or target.startswith(("tbb/", "oneapi/tbb/"))):
            return "the engine uses only the standard library, TBB and CUDA"
        if engine_part(target) in FORBIDDEN.get(engine_part(path), ()):
            return f"{engine_part(path)} must not know {engine_part(target)}"
        if engine_part(path) == "exact" and engine_part(target) == "exec" and target != "gpu/exec/host_device.hpp":
            return "of exec, the exact decisions know host_device.hpp alone"
        if engine_part(target) == "exact" and engine_part(path) != "exact" and target not in EXACT_API:
            return "of gpu/exact, others know exact.hpp, decision.hpp and poll.hpp alone"
    if layer == "server":
        return server_complaint(path, target)
    if layer == "proto" and not STANDARD.match(target):
        return "the protocol's constants need the standard library alone"
    if layer == "client" and target.startswith(("gpu/", "server/")):
        return "the client knows the protocol alone"
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


def bad_headers(root, compiler, include_dirs):
    """Headers that do not compile as the only include of a file."""
    options = ["-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", "-x", "c++", '-DCOLLIDED_VERSION="0"',
               f"-I{root}", *(f"-isystem{d}" for d in include_dirs), "-"]

    def compile_alone(header):
        text = f'#include "{header.relative_to(root).as_posix()}"\n'
        run = subprocess.run([compiler, *options], input=text, capture_output=True, text=True, cwd=root)
        return run.stderr if run.returncode else None

    headers = [file for file in sources(root) if file.suffix == ".hpp"]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return [error for error in pool.map(compile_alone, headers) if error], len(headers)


def main(arguments):
    if len(arguments) == 2 and arguments[0] == "includes":
        root = pathlib.Path(arguments[1])
        problems, count = bad_includes(root), len(list(sources(root)))
    elif len(arguments) >= 3 and arguments[0] == "headers":
        problems, count = bad_headers(pathlib.Path(arguments[1]), arguments[2], arguments[3:])
    else:
        sys.exit(__doc__)
    print("\n".join(problems))
    print(f"{count} files, {len(problems)} problems")
    return 1 if problems or not count else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
