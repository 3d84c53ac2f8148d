"""Markers on the time line, at frames with contacts."""

from .names import MARKER


def add(scene, findings):
    for frame in findings.frames:
        contacts, crossings = findings.by_frame[frame]
        words = [f"{count} {name}" for count, name in ((contacts, "contacts"), (crossings, "crossings")) if count]
        scene.timeline_markers.new(MARKER + ", ".join(words), frame=frame)


def remove(scene):
    for marker in [marker for marker in scene.timeline_markers if marker.name.startswith(MARKER)]:
        scene.timeline_markers.remove(marker)
