"""A modifier that makes lines visible: tubes with balls at their ends, in one colour."""

import bpy

_SIDES, _BALL = 8, 2


def tubes(name, color, radius, by_frame):
    """A node group. by_frame: of the lines, only those of the current frame."""
    group = bpy.data.node_groups.new(name, "GeometryNodeTree")
    _socket(group, "INPUT", "Geometry", "NodeSocketGeometry")
    _socket(group, "INPUT", "Radius", "NodeSocketFloat", radius)
    _socket(group, "OUTPUT", "Geometry", "NodeSocketGeometry")
    node, link = _maker(group), group.links.new
    begin, end = node("NodeGroupInput"), node("NodeGroupOutput")
    lines = begin.outputs["Geometry"]
    if by_frame:
        lines = _of_the_frame(node, link, lines)
    ball = node("GeometryNodeMeshIcoSphere")
    ball.inputs["Subdivisions"].default_value = _BALL
    balls = node("GeometryNodeInstanceOnPoints")
    curve, circle, tube = (node(f"GeometryNode{kind}") for kind in ("MeshToCurve", "CurvePrimitiveCircle", "CurveToMesh"))
    circle.inputs["Resolution"].default_value = _SIDES
    half = node("ShaderNodeMath")
    half.operation = "MULTIPLY"
    half.inputs[1].default_value = 0.5
    joined, painted = node("GeometryNodeJoinGeometry"), node("GeometryNodeSetMaterial")
    painted.inputs["Material"].default_value = _material(name, color)
    link(begin.outputs["Radius"], ball.inputs["Radius"])
    link(begin.outputs["Radius"], half.inputs[0])
    link(half.outputs[0], circle.inputs["Radius"])
    link(lines, balls.inputs["Points"])
    link(ball.outputs["Mesh"], balls.inputs["Instance"])
    link(lines, curve.inputs["Mesh"])
    link(curve.outputs["Curve"], tube.inputs["Curve"])
    link(circle.outputs["Curve"], tube.inputs["Profile Curve"])
    link(balls.outputs["Instances"], joined.inputs[0])
    link(tube.outputs["Mesh"], joined.inputs[0])
    link(joined.outputs[0], painted.inputs["Geometry"])
    link(painted.outputs["Geometry"], end.inputs["Geometry"])
    return group


def _of_the_frame(node, link, lines):
    """The lines whose attribute `frame` is the scene's frame."""
    frame, now = node("GeometryNodeInputNamedAttribute"), node("GeometryNodeInputSceneTime")
    frame.inputs["Name"].default_value = "frame"
    differs, others = node("FunctionNodeCompare"), node("GeometryNodeDeleteGeometry")
    frame.data_type, differs.data_type, differs.operation = "FLOAT", "FLOAT", "NOT_EQUAL"
    differs.inputs["Epsilon"].default_value = 0.5
    link(_enabled(frame.outputs, "Attribute"), _enabled(differs.inputs, "A"))
    link(now.outputs["Frame"], _enabled(differs.inputs, "B"))
    link(lines, others.inputs["Geometry"])
    link(differs.outputs["Result"], others.inputs["Selection"])
    return others.outputs["Geometry"]


def _enabled(sockets, name):
    """Of the sockets of one name, that of the node's data type."""
    return next(socket for socket in sockets if socket.name == name and socket.enabled)


def _socket(group, side, name, kind, value=None):
    sockets = group.inputs if side == "INPUT" else group.outputs
    socket = sockets.new(kind, name)
    if value is not None:
        socket.default_value = value


def _maker(group):
    """Makes nodes, each to the right of the one before."""
    def node(kind):
        made = group.nodes.new(kind)
        made.location.x = 180 * len(group.nodes)
        return made

    return node


def discard(group):
    """Removes a node group of `tubes`, and its material."""
    materials = [node.inputs["Material"].default_value for node in group.nodes if node.type == "SET_MATERIAL"]
    bpy.data.batch_remove([group, *filter(None, materials)])


def _material(name, color):
    material = bpy.data.materials.new(name)
    material.diffuse_color = color
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    glow, out = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    glow.inputs["Color"].default_value = color
    material.node_tree.links.new(glow.outputs[0], out.inputs["Surface"])
    return material
