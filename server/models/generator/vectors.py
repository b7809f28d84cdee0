"""Vectors as tuples of three floats, rotations as tuples of three rows, poses as (R, p)."""

import math

IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scaled(a, s):
    return (a[0] * s, a[1] * s, a[2] * s)


def along(a, direction, s):
    """a + s * direction."""
    return (a[0] + s * direction[0], a[1] + s * direction[1], a[2] + s * direction[2])


def mix(a, b, t):
    return (a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2]))


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def norm(a):
    return math.sqrt(dot(a, a))


def distance(a, b):
    return norm(sub(a, b))


def unit(a):
    return scaled(a, 1.0 / norm(a))


def tangent(direction, normal):
    """The unit vector of `direction` without its part along the unit vector `normal`."""
    return unit(along(direction, normal, -dot(direction, normal)))


def rotate(R, v):
    return (dot(R[0], v), dot(R[1], v), dot(R[2], v))


def rotate_back(R, v):
    return (
        R[0][0] * v[0] + R[1][0] * v[1] + R[2][0] * v[2],
        R[0][1] * v[0] + R[1][1] * v[1] + R[2][1] * v[2],
        R[0][2] * v[0] + R[1][2] * v[1] + R[2][2] * v[2],
    )


def columns(x, y, z):
    """The rotation whose columns are x, y, z."""
    return ((x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2]))


def product(A, B):
    return tuple(rotate_back(B, row) for row in A)


def turn(axis, angle):
    """Rotation by `angle` (rad) about the unit vector `axis` (Rodrigues)."""
    c, s = math.cos(angle), math.sin(angle)
    x, y, z = axis
    k = 1.0 - c
    return (
        (c + x * x * k, x * y * k - z * s, x * z * k + y * s),
        (y * x * k + z * s, c + y * y * k, y * z * k - x * s),
        (z * x * k - y * s, z * y * k + x * s, c + z * z * k),
    )


def turn_by(w):
    """Rotation by the rotation vector w."""
    angle = norm(w)
    return IDENTITY if angle < 1e-15 else turn(scaled(w, 1.0 / angle), angle)


def frame(z, x_hint):
    """The rotation whose z column is along `z` and whose x column is as near to `x_hint` as it
    can be."""
    z = unit(z)
    x = tangent(x_hint, z)
    return columns(x, cross(z, x), z)


def roll_pitch_yaw(R):
    """Angles of URDF's rpy: R = Rz(yaw) Ry(pitch) Rx(roll)."""
    if abs(R[2][0]) > 1.0 - 1e-12:
        pitch = math.copysign(math.pi / 2.0, -R[2][0])
        return (math.atan2(-R[1][2], R[1][1]), pitch, 0.0)
    return (
        math.atan2(R[2][1], R[2][2]),
        math.asin(-R[2][0]),
        math.atan2(R[1][0], R[0][0]),
    )


def compose(X, Y):
    """X * Y for poses."""
    return (product(X[0], Y[0]), add(rotate(X[0], Y[1]), X[1]))


def apply(X, p):
    return add(rotate(X[0], p), X[1])
