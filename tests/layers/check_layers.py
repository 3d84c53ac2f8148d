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


def may_see_messages(path):
    return path.startswith("client/") or re.match(r"server/(service|convert|builtin|local)/", path)


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

# Inside the client: who must not include what, and why.
CLIENT_RULES = [
    (r"client/scenes/", r"client/(?!scenes/)", "scenes know only themselves"),
    (r"client/cpp/", r"client/(?!cpp/)", "the C++ library knows only itself and the protocol"),
    (r"client/cpp/(?!frame_stream_state)\w+\.hpp$", r"client/cpp/transport/", "public headers show no transport"),
    (r"client/cpp/transport/", r"client/cpp/(client|frame_stream)", "transports know no stream"),
    (r"client/cli/\w+/", r"client/(cli/\w+\.hpp$|measure/)", "what commands share knows no command and no measurement"),
    (r"client/measure/", r"client/cli/\w+\.hpp$", "measurements know no command"),
]


def complaint(path, quote, target):
    """Why the file at `path` may not include `target`; None if it may."""
    layer = path.split("/")[0]
    if target in ("gmp.h", "gmpxx.h"):
        if not path.startswith("gpu/exact/") or path in EXACT_API:
            return "GMP belongs to gpu/exact, but not to what others include of it"
        return None
    if MESSAGES.search(target) and not may_see_messages(path):
        return "protocol messages belong to client, server/service, server/convert, server/builtin and server/local"
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
        if target.startswith("gpu/") and target != "gpu/detector.hpp":
            return "the server knows the engine by gpu/detector.hpp alone"
        if target.startswith("client/"):
            return "the server must not know the client"
    if layer == "client" and target.startswith(("gpu/", "server/")):
        return "the client knows the protocol alone"
    for includer, included, why in CLIENT_RULES:
        if re.match(includer, path) and re.match(included, target):
            return why
    return None


def sources(root):
    for layer in ("gpu", "server", "client"):
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
