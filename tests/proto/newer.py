"""A protocol that is newer than every daemon: this one, with what release 99.0.0 brings to requests.

Clients that are built with it are sent to the daemon of today, which is older than they are.
"""

import re
import shutil

RELEASE = "99.0.0"
IMPORT = 'import "collided/v1/added_in.proto";'
FIELD, VALUE, METHOD = (f'({kind}_added_in) = "{RELEASE}"' for kind in ("field", "value", "method"))
GAINED = {
    "contact": [("CONTACT_KIND_TRIANGLE_TRIANGLE = 3;", rf"\g<0> CONTACT_KIND_POINT_POINT = 99 [{VALUE}];")],
    "scene": [(r"^message SceneSpec \{", rf"\g<0> bool mirrored = 99 [{FIELD}];"),
              (r"^message MeshSpec \{", rf"\g<0> uint32 layers = 99 [{FIELD}];"),
              ("REPORT_ANY_HIT = 3;", rf"\g<0> REPORT_DEEPEST = 99 [{VALUE}];")],
    "frame": [(r"^message Frame \{", rf"\g<0> double friction = 99 [{FIELD}];"),
              (r"^message MeshUpdate \{", rf"\g<0> bytes velocities = 99 [{FIELD}];")],
    "collision_service": [(r"^  rpc GetMesh\(",
                           rf"  rpc MoveScene(GetMeshRequest) returns (GetMeshResponse) {{ option {METHOD}; }}" "\n" r"\g<0>"),
                          (r"^(  rpc UploadMesh.*);", rf"\1 {{ option {METHOD}; }}"),
                          (r"^(  rpc WatchScene.*);", rf"\1 {{ option {METHOD}; }}"),
                          ("DELIVERY_POLICY_LATEST_WINS = 2;", rf"\g<0> DELIVERY_POLICY_NEWEST = 99 [{VALUE}];"),
                          (r"^message OpenStream \{", rf"\g<0> bool is_mirrored = 99 [{FIELD}];")],
}
NAMES = {f"collided.v1.{name}" for name in (
    "CONTACT_KIND_POINT_POINT", "SceneSpec.mirrored", "MeshSpec.layers", "REPORT_DEEPEST", "Frame.friction",
    "MeshUpdate.velocities", "CollisionService.MoveScene", "CollisionService.UploadMesh", "CollisionService.WatchScene",
    "DELIVERY_POLICY_NEWEST", "OpenStream.is_mirrored")}


def write_protocol(repository, folder):
    """Writes folder/collided/v1/*.proto."""
    shutil.copytree(repository / "proto/collided", folder / "collided", dirs_exist_ok=True)
    for name, changes in GAINED.items():
        file = folder / f"collided/v1/{name}.proto"
        text = file.read_text()
        if IMPORT not in text:
            text = text.replace("package collided.v1;", f"package collided.v1;\n{IMPORT}", 1)
        for pattern, replacement in changes:
            text, count = re.subn(pattern, replacement, text, count=1, flags=re.MULTILINE)
            assert count == 1, pattern
        file.write_text(text)
