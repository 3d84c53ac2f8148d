#!/usr/bin/env python3
"""Checks what the modules of the Python package import: folders know only those below them, and few packages of others.

usage: check_python.py ROOT
"""

import ast
import pathlib
import sys

PACKAGE = "client/python/collided"
# What each folder may use besides itself and the protocol's messages (v1); modules of the root by name. The root uses all.
FOLDERS = {
    "meshes": {"arrays", "choices", "errors"},
    "frames": {"arrays", "choices", "errors", "layout", "meshes", "options", "positions"},
    "contacts": {"columns", "errors", "frames", "kinds", "layout"},
    "connection": {"arrays", "choices", "errors", "layout", "leftovers", "options", "programs"},
    "in_process": {"columns", "connection", "errors", "frames", "kinds", "layout", "options", "programs"},
    "transport": {"arrays", "connection", "errors", "frames", "in_process", "positions"},
    "gpu": {"columns", "contacts", "errors", "frames", "in_process", "kinds", "layout", "leftovers", "scene", "transport"},
}
# Packages of others, and where they may be used; numpy everywhere.
OTHERS = {"grpc": ("errors", "connection", "transport"), "google": ("errors", "transport"), "pandas": ("contacts",)}


def imports(text):
    """Names of the modules that a module imports, with their lines; those that are imported for types alone are not told."""
    tree = ast.parse(text)
    guards = [node for node in ast.walk(tree) if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"]
    for guard in guards:
        guard.body.clear()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name, node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield "." * node.level + (node.module or ""), node.lineno


def complaint(folder, name):
    """Why a module of a folder, or a module of the root, may not import `name`; None if it may."""
    if name.startswith("."):
        return "imports are absolute"
    first, *rest = name.split(".")
    if first == "collided":
        other = rest[0] if rest else None
        if folder in FOLDERS and other not in FOLDERS[folder] | {folder, "v1"}:
            return f"{folder} must not know {name}"
        return None
    if first in OTHERS:
        return None if folder in OTHERS[first] else f"{first} belongs to {', '.join(OTHERS[first])}"
    return None if first == "numpy" or first in sys.stdlib_module_names else f"{first} is not a package that it needs"


def bad_imports(root):
    package = pathlib.Path(root) / PACKAGE
    files = sorted(file for file in package.rglob("*.py") if package / "v1" not in file.parents)  # v1 is generated
    found = []
    for file in files:
        folder = file.relative_to(package).parts[0].removesuffix(".py")
        for name, line in imports(file.read_text()):
            why = complaint(folder, name)
            if why:
                found.append(f"{file.relative_to(root)}:{line}: {name}: {why}")
    return found, len(files)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    problems, count = bad_imports(sys.argv[1])
    print("\n".join(problems))
    print(f"{count} files, {len(problems)} problems")
    sys.exit(1 if problems or not count else 0)
