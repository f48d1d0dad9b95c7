"""Names and contents of the messages between 3D Slicer and kerf (docs/slicer.md). Needs neither Slicer nor numpy. Lengths are mm, in
RAS."""

import math

MAX_NAME_BYTES = 20  # OpenIGTLink cuts longer names off
PLAN_PREFIX = "kerf_plan/"
NERVE_NAME = "nerve"
MIN_PLANE_POINTS = 3


def plane_message_name(name):
    """Returns the name of the message that moves the plane `name` in kerf. With a name of at most 10 bytes, kerf adds the plane if it
    has none; a plane with a longer name must exist in kerf."""
    with_prefix = PLAN_PREFIX + name
    return with_prefix if len(with_prefix.encode()) <= MAX_NAME_BYTES else name


def _cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _unit(a, what):
    length = math.sqrt(sum(x * x for x in a))
    if not length > 0 or not math.isfinite(length):
        raise ValueError(f"the {what} of the plane has no direction")
    return tuple(x / length for x in a)


def plane_matrix(centre, normal, x_axis=None):
    """Returns four rows of the pose of a plane: its centre, its normal as the z axis, and x_axis, made perpendicular to that, as the
    x axis. Without x_axis, or if it is parallel to the normal, an axis of the patient is used. The result is always a rotation and
    a translation, also for a plane in a node with a scaled transform."""
    z = _unit(normal, "normal")
    for wanted in [x_axis, (1, 0, 0), (0, 1, 0)]:
        if wanted is None:
            continue
        along = sum(a * b for a, b in zip(wanted, z))
        x = tuple(a - along * b for a, b in zip(wanted, z))
        if math.sqrt(sum(a * a for a in x)) > 1e-3 * math.sqrt(sum(a * a for a in wanted)):
            break
    x = _unit(x, "x axis")
    y = _cross(z, x)
    if not all(math.isfinite(c) for c in centre):
        raise ValueError("the centre of the plane is not finite")
    return [[x[i], y[i], z[i], float(centre[i])] for i in range(3)] + [[0.0, 0.0, 0.0, 1.0]]


def parse_values(text):
    """Returns the names and values of a text "kerf_values": a line each."""
    values = {}
    for line in text.splitlines():
        name, _, value = line.rpartition(" ")
        try:
            values[name] = float(value)
        except ValueError:
            continue
    return values


def show_values(text):
    """Returns the force, the time and the volume for people; empty if the text has no force."""
    values = parse_values(text)
    if "force_N" not in values:
        return ""
    return (f"Force {values['force_N']:.1f} N     Time {values.get('time_s', 0):.1f} s     "
            f"Volume cut {values.get('cut_mm3', 0):.1f} mm\u00b3")
