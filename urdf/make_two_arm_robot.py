#!/usr/bin/env python3
"""Writes two_arm_robot.urdf: a torso with two mirrored six-joint arms and parallel grippers.

    python3 urdf/make_two_arm_robot.py [OUTPUT]      (default: two_arm_robot.urdf beside this file)

All shapes are primitives, visual and collision alike, so that the simulation can collide with the links. Lengths in
metres, masses in kilograms. An arm at zero points along +x; positive lift, elbow and wrist pitch bend it downwards.
Gripper frames: x out between the finger tips, y across the fingers.
"""

import math
import os
import sys
from xml.sax.saxutils import quoteattr

BASE_IN_WORLD = (-0.15, 0.0, 0.0)
SHOULDER_IN_BASE = (0.09, 0.24, 1.20)  # left; the right one has -y
UPPER_ARM = 0.42
FOREARM = 0.40
WRIST_TO_GRIPPER = 0.20
FINGER_STROKE = 0.04

MATERIALS = {
    'shell': (0.93, 0.94, 0.95),
    'graphite': (0.20, 0.22, 0.25),
    'accent': (0.05, 0.50, 0.62),
    'rubber': (0.10, 0.10, 0.11),
    'light': (0.55, 0.90, 0.98),
}
ALONG_X = (0.0, math.pi / 2, 0.0)  # turns a primitive's z axis to x
ALONG_Y = (math.pi / 2, 0.0, 0.0)


def numbers(values):
    return ' '.join(format(round(v, 6) + 0.0, 'g') for v in values)


class Shape:
    """A primitive in its link's frame: box (x, y, z), cylinder (radius, length) along z, or sphere (radius,)."""

    def __init__(self, kind, size, material, xyz=(0, 0, 0), rpy=(0, 0, 0), solid=True):
        self.kind, self.size, self.material, self.xyz, self.rpy, self.solid = kind, size, material, xyz, rpy, solid

    def geometry(self):
        if self.kind == 'box':
            return '<box size="%s"/>' % numbers(self.size)
        if self.kind == 'cylinder':
            return '<cylinder radius="%s" length="%s"/>' % tuple(numbers([v]) for v in self.size)
        return '<sphere radius="%s"/>' % numbers(self.size)

    def xml(self, tag):
        material = '<material name="%s"/>' % self.material if tag == 'visual' else ''
        return '    <%s><origin xyz="%s" rpy="%s"/><geometry>%s</geometry>%s</%s>' % (
            tag, numbers(self.xyz), numbers(self.rpy), self.geometry(), material, tag)

    def bounds(self):
        """Edge lengths of the axis-aligned box around it, for right-angled rotations."""
        if self.kind == 'box':
            return self.size
        if self.kind == 'sphere':
            return (2 * self.size[0],) * 3
        d, length = 2 * self.size[0], self.size[1]
        return {ALONG_X: (length, d, d), ALONG_Y: (d, length, d)}.get(self.rpy, (d, d, length))


def link(name, shapes=(), mass=0.0):
    """A link whose inertia is that of a solid box around its first (main) shape."""
    if not shapes:
        return '  <link name="%s"/>' % name
    x, y, z = shapes[0].bounds()
    inertia = [mass / 12 * v for v in (y * y + z * z, x * x + z * z, x * x + y * y)]
    lines = ['  <link name="%s">' % name,
             '    <inertial><origin xyz="%s"/><mass value="%g"/>' % (numbers(shapes[0].xyz), mass),
             '      <inertia ixx="%.6g" iyy="%.6g" izz="%.6g" ixy="0" ixz="0" iyz="0"/></inertial>' % tuple(inertia)]
    lines += [s.xml('visual') for s in shapes]
    lines += [s.xml('collision') for s in shapes if s.solid]
    return '\n'.join(lines + ['  </link>'])


def joint(name, kind, parent, child, xyz=(0, 0, 0), axis=None, limit=None):
    """limit: (lower, upper, effort, velocity) in rad or m, N m or N, rad/s or m/s."""
    lines = ['  <joint name=%s type="%s">' % (quoteattr(name), kind),
             '    <parent link="%s"/><child link="%s"/><origin xyz="%s"/>' % (parent, child, numbers(xyz))]
    if axis:
        lines.append('    <axis xyz="%s"/>' % numbers(axis))
        lines.append('    <limit lower="%g" upper="%g" effort="%g" velocity="%g"/>' % limit)
    return '\n'.join(lines + ['  </joint>'])


def torso():
    return [
        link('world'),
        joint('world_joint', 'fixed', 'world', 'base_link', BASE_IN_WORLD),
        link('base_link', [
            Shape('box', (0.36, 0.50, 0.08), 'graphite', (-0.03, 0, 0.04)),
            Shape('cylinder', (0.11, 0.06), 'accent', (0, 0, 0.11), solid=False),
            Shape('cylinder', (0.09, 0.82), 'shell', (0, 0, 0.49)),
        ], 40.0),
        joint('torso_joint', 'fixed', 'base_link', 'torso_link', (0, 0, 0.90)),
        link('torso_link', [
            Shape('box', (0.18, 0.28, 0.36), 'shell', (0, 0, 0.20)),
            Shape('box', (0.012, 0.16, 0.05), 'accent', (0.09, 0, 0.22), solid=False),
            Shape('cylinder', (0.065, 0.40), 'graphite', (0.04, 0, 0.30), ALONG_Y),
        ], 25.0),
        joint('head_joint', 'fixed', 'torso_link', 'head_link', (0, 0, 0.38)),
        link('head_link', [
            Shape('box', (0.13, 0.19, 0.12), 'shell', (0.02, 0, 0.15)),
            Shape('cylinder', (0.035, 0.10), 'graphite', (0, 0, 0.05)),
            Shape('box', (0.02, 0.16, 0.06), 'graphite', (0.08, 0, 0.155), solid=False),
            Shape('sphere', (0.017,), 'light', (0.088, 0.042, 0.157), solid=False),
            Shape('sphere', (0.017,), 'light', (0.088, -0.042, 0.157), solid=False),
        ], 3.0),
    ]


def arm(side):
    """side: 'left' or 'right'. Joints: shoulder pan (z) and lift (y), elbow (y), wrist pitch (y) and yaw (z),
    hand roll (x)."""
    sign = 1 if side == 'left' else -1
    n = lambda name: side + '_' + name
    pan_limit = (-1.2, 1.2, 90.0, 2.5)
    parts = [
        joint(n('shoulder_pan_joint'), 'revolute', 'base_link', n('shoulder_link'),
              (SHOULDER_IN_BASE[0], sign * SHOULDER_IN_BASE[1], SHOULDER_IN_BASE[2]), (0, 0, 1), pan_limit),
        link(n('shoulder_link'), [
            Shape('cylinder', (0.068, 0.15), 'shell'),
            Shape('cylinder', (0.070, 0.02), 'accent', (0, 0, 0.06), solid=False),
        ], 4.0),
        joint(n('shoulder_lift_joint'), 'revolute', n('shoulder_link'), n('upper_arm_link'), (0, 0, 0), (0, 1, 0),
              (-2.2, 1.6, 90.0, 2.5)),
        link(n('upper_arm_link'), [
            Shape('cylinder', (0.050, UPPER_ARM - 0.05), 'shell', (UPPER_ARM / 2 + 0.015, 0, 0), ALONG_X),
            Shape('cylinder', (0.058, 0.165), 'graphite', (0, 0, 0), ALONG_Y, solid=False),
            Shape('cylinder', (0.053, 0.025), 'accent', (0.13, 0, 0), ALONG_X, solid=False),
        ], 3.0),
        joint(n('elbow_joint'), 'revolute', n('upper_arm_link'), n('forearm_link'), (UPPER_ARM, 0, 0), (0, 1, 0),
              (0.0, 2.7, 60.0, 3.0)),
        link(n('forearm_link'), [
            Shape('cylinder', (0.054, 0.13), 'graphite', (0, 0, 0), ALONG_Y),
            Shape('cylinder', (0.042, FOREARM - 0.07), 'shell', (FOREARM / 2 - 0.01, 0, 0), ALONG_X),
            Shape('cylinder', (0.045, 0.02), 'accent', (0.12, 0, 0), ALONG_X, solid=False),
        ], 3.0),
        joint(n('wrist_pitch_joint'), 'revolute', n('forearm_link'), n('wrist_pitch_link'), (FOREARM, 0, 0), (0, 1, 0),
              (-2.4, 2.4, 20.0, 4.0)),
        link(n('wrist_pitch_link'), [
            Shape('cylinder', (0.036, 0.096), 'graphite', (0, 0, 0), ALONG_Y),
        ], 0.7),
        joint(n('wrist_yaw_joint'), 'revolute', n('wrist_pitch_link'), n('wrist_yaw_link'), (0, 0, 0), (0, 0, 1),
              (-1.5, 1.5, 20.0, 4.0)),
        link(n('wrist_yaw_link'), [
            Shape('cylinder', (0.030, 0.080), 'graphite', (0.012, 0, 0)),
        ], 0.5),
        joint(n('hand_roll_joint'), 'revolute', n('wrist_yaw_link'), n('hand_link'), (0.035, 0, 0), (1, 0, 0),
              (-2.9, 2.9, 10.0, 5.0)),
        link(n('hand_link'), [
            Shape('box', (0.045, 0.115, 0.046), 'shell', (0.050, 0, 0)),
            Shape('cylinder', (0.030, 0.035), 'accent', (0.015, 0, 0), ALONG_X),
        ], 0.6),
        joint(n('gripper_joint'), 'fixed', n('hand_link'), n('gripper'), (WRIST_TO_GRIPPER - 0.035, 0, 0)),
        link(n('gripper')),
    ]
    for number, direction in ((1, 1), (2, -1)):
        finger = n('finger_%d_link' % number)
        parts += [
            joint(n('finger_%d_joint' % number), 'prismatic', n('hand_link'), finger, (0.072, 0, 0), (0, direction, 0),
                  (0.0, FINGER_STROKE, 40.0, 0.2)),
            link(finger, [
                Shape('box', (0.094, 0.009, 0.018), 'graphite', (0.047, direction * 0.0055, 0)),
                Shape('box', (0.022, 0.004, 0.019), 'accent', (0.0855, direction * 0.0085, 0), solid=False),
            ], 0.05),
        ]
    return parts


def robot():
    lines = ['<?xml version="1.0"?>', '<!-- Written by make_two_arm_robot.py; edit that and run it again. -->',
             '<robot name="two_arm_robot">']
    lines += ['  <material name="%s"><color rgba="%s 1"/></material>' % (m, numbers(c)) for m, c in MATERIALS.items()]
    lines += torso() + arm('left') + arm('right') + ['</robot>', '']
    return '\n'.join(lines)


if __name__ == '__main__':
    beside = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'two_arm_robot.urdf')
    output = sys.argv[1] if len(sys.argv) > 1 else beside
    with open(output, 'w') as f:
        f.write(robot())
