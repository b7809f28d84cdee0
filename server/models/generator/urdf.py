"""Writes a hand as URDF: metres, radians, six decimals."""

from . import vectors as v


def number(x, decimals=6):
    """Fixed decimals without a negative zero."""
    text = f"{x:.{decimals}f}"
    return text[1:] if text.startswith("-") and not text.strip("-0.") else text


def numbers(values):
    return " ".join(number(x) for x in values)


def metres(p):
    return numbers(x * 1e-3 for x in p)


def origin_element(pose):
    return f'<origin xyz="{metres(pose[1])}" rpy="{numbers(v.roll_pitch_yaw(pose[0]))}"/>'


def geometry_element(shape):
    if shape.kind == "box":
        return f'<box size="{metres(shape.size)}"/>'
    if shape.kind == "cylinder":
        radius, length = (number(x * 1e-3) for x in shape.size)
        return f'<cylinder radius="{radius}" length="{length}"/>'
    return f'<sphere radius="{number(shape.size[0] * 1e-3)}"/>'


def link_lines(link):
    yield f'  <link name="{link.name}">'
    for role in ("visual", "collision"):
        for shape in link.shapes:
            yield f"    <{role}>"
            yield f"      {origin_element(shape.pose)}"
            yield f"      <geometry>{geometry_element(shape)}</geometry>"
            yield f"    </{role}>"
    yield "  </link>"


def joint_lines(joint):
    yield f'  <joint name="{joint.name}" type="revolute">'
    yield f'    <parent link="{joint.parent}"/>'
    yield f'    <child link="{joint.child}"/>'
    yield f"    {origin_element(joint.pose)}"
    yield f'    <axis xyz="{numbers(joint.axis)}"/>'
    yield (f'    <limit lower="{number(joint.lower)}" upper="{number(joint.upper)}" '
           f'effort="{number(joint.effort, 3)}" velocity="{number(joint.velocity, 3)}"/>')
    yield "  </joint>"


def urdf_text(hand):
    lines = ['<?xml version="1.0"?>', f"<!-- {hand.summary} Written by make_library.py. -->",
             f'<robot name="{hand.name}">']
    for link in hand.links:
        if link.joint is not None:
            lines.extend(joint_lines(link.joint))
        lines.extend(link_lines(link))
    lines.append("</robot>")
    return "\n".join(lines) + "\n"
