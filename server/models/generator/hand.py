"""A hand as data: links made of primitives, joints, contact sites; and its kinematics.

Lengths are millimetres and angles radians while a hand is authored; `urdf.py` writes metres.
Frame H: origin at the base of the palm, fingers along +z, palm facing +x, a right hand, so that
the thumb is on the +y side. Every link's frame sits at its joint.
"""

from . import vectors as v

ORIGIN = (v.IDENTITY, (0.0, 0.0, 0.0))
FLEXION = (0.0, 1.0, 0.0)  # turns +z (along the finger) towards +x (the palm's side)


class Shape:
    """A box (size = x, y, z), cylinder (radius, length; along its z) or sphere (radius,)."""

    def __init__(self, kind, size, pose):
        self.kind = kind
        self.size = size
        self.pose = pose


class Link:
    def __init__(self, name):
        self.name = name
        self.shapes = []
        self.joint = None

    def add_box(self, centre, size, R=v.IDENTITY):
        self.shapes.append(Shape("box", size, (R, centre)))

    def add_sphere(self, centre, radius):
        self.shapes.append(Shape("sphere", (radius,), (v.IDENTITY, centre)))

    def add_cylinder(self, a, b, radius):
        axis = v.sub(b, a)
        hint = (1.0, 0.0, 0.0) if abs(v.unit(axis)[0]) < 0.9 else (0.0, 1.0, 0.0)
        pose = (v.frame(axis, hint), v.mix(a, b, 0.5))
        self.shapes.append(Shape("cylinder", (radius, v.norm(axis)), pose))

    def add_capsule(self, a, b, radius):
        self.add_cylinder(a, b, radius)
        self.add_sphere(a, radius)
        self.add_sphere(b, radius)


class Joint:
    """A revolute joint; `pose` is the child link's frame in its parent at q = 0."""

    def __init__(self, name, parent, child, pose, axis, lower, upper, effort, velocity):
        self.name = name
        self.parent = parent
        self.child = child
        self.pose = pose
        self.axis = axis
        self.lower = lower
        self.upper = upper
        self.effort = effort  # N m
        self.velocity = velocity  # rad/s


class Site:
    """A place for a patch on a link's surface: point, outward normal, direction to the wrist."""

    def __init__(self, name, link, point, normal, direction):
        self.name = name
        self.link = link
        self.point = point
        self.normal = normal
        self.direction = direction


class Hand:
    def __init__(self, name, summary, root):
        self.name = name
        self.summary = summary
        self.links = [Link(root)]
        self.sites = []
        self._by_name = {root: self.links[0]}

    @property
    def root(self):
        return self.links[0]

    @property
    def joints(self):
        return [link.joint for link in self.links[1:]]

    def link(self, name):
        return self._by_name[name]

    def site(self, name):
        return next(site for site in self.sites if site.name == name)

    def add_link(self, name, parent, joint, place, axis, limits, effort, velocity):
        """A link behind a new joint. `place` is a position in the parent, or a pose."""
        pose = place if isinstance(place[0], tuple) else (v.IDENTITY, place)
        link = Link(name)
        link.joint = Joint(joint, parent, name, pose, axis, *limits, effort, velocity)
        self.links.append(link)
        self._by_name[name] = link
        return link

    def add_pad(self, name, link, centre, radius, tilt=0.0):
        """A site on the flexion side of a round fingertip, `tilt` rad from there to the tip.

        Without tilt it lies on a cylinder of that radius about the link's z axis, with tilt on
        the sphere around `centre` that closes it.
        """
        normal = v.rotate(v.turn(FLEXION, -tilt), (1.0, 0.0, 0.0))
        direction = v.rotate(v.turn(FLEXION, -tilt), (0.0, 0.0, -1.0))
        self.sites.append(Site(name, link, v.along(centre, normal, radius), normal, direction))

    def add_palm_site(self, point):
        """A site on a face of the root link that looks along +x."""
        self.sites.append(
            Site("palm", self.root.name, point, (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)))

    def link_poses(self, X_WH, q):
        """Pose of every link in W by name; `q` in the order of `joints`."""
        poses = {self.root.name: X_WH}
        for joint, angle in zip(self.joints, q):
            R, p = v.compose(poses[joint.parent], joint.pose)
            poses[joint.child] = (v.product(R, v.turn(joint.axis, angle)), p)
        return poses
