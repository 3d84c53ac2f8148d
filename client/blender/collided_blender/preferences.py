"""What is the user's, not the scene's: where the daemon is, and what it is told about who asks."""

import bpy
from bpy.props import StringProperty


class Preferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    server: StringProperty(
        name="Server", description="Address of a daemon, host:port or unix:/path. Empty: $COLLIDED_SERVER, or a daemon that "
        "Blender starts for itself")
    program: StringProperty(
        name="Daemon", subtype="FILE_PATH",
        description="Program that Blender starts where no server is named. Empty: $COLLIDED_DAEMON, or collided on PATH")
    token_file: StringProperty(name="Token File", subtype="FILE_PATH", description="File with a bearer token for the server")
    tls_ca: StringProperty(
        name="TLS CA", subtype="FILE_PATH", description="PEM file with the certificates to trust. Empty: no TLS")
    tls_certificate: StringProperty(name="TLS Certificate", subtype="FILE_PATH",
                                    description="PEM file with a certificate of your own")
    tls_key: StringProperty(name="TLS Key", subtype="FILE_PATH", description="PEM file with its key")

    def draw(self, _context):
        column = self.layout.column()
        column.use_property_split = True
        for name in ("server", "program", "token_file", "tls_ca", "tls_certificate", "tls_key"):
            column.prop(self, name)


def preferences(context):
    return context.preferences.addons[__package__].preferences
