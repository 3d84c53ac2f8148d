"""What a scene shows of findings: objects of lines, a vertex group and an attribute, markers on the time line.

All of it has names that begin with PREFIX, is found again by them, and stays in the file without the add-on.
"""

from . import lines, markers, touched


def mark(search, by_frame):
    """Replaces what earlier findings left. by_frame: each is shown in its frame alone. Returns names of objects in which no
    vertices and faces could be marked."""
    scene = search.scene
    clear(scene)
    lines.show(scene, search.findings, search.size, by_frame)
    if by_frame:
        markers.add(scene, search.findings)
    return touched.mark(search)


def clear(scene):
    """Removes all marks of a scene."""
    lines.remove(scene)
    markers.remove(scene)
    touched.remove(scene)
