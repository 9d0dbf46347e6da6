"""The difference of two rotations."""

import math


def quaternion(vector_deg):
    angle = math.radians(math.hypot(*vector_deg))
    scale = math.sin(angle / 2) / angle if angle > 0 else 0.5
    return (math.cos(angle / 2), *(math.radians(x) * scale for x in vector_deg))


def product(p, q):
    a, b, c, d = p
    w, x, y, z = q
    return (a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x, a * z + b * y - c * x + d * w)


def difference_deg(first_deg, second_deg):
    """Returns the rotation vector, deg, that leads from the second to the first, from the left."""
    w, *xyz = product(quaternion(first_deg), quaternion([-x for x in second_deg]))
    sine = math.hypot(*xyz)
    if sine == 0:
        return [0.0, 0.0, 0.0]
    angle = 2 * math.atan2(math.copysign(sine, w), abs(w))
    return [math.degrees(angle) * x / sine for x in xyz]
