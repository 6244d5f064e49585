#!/usr/bin/env python3
"""The two-armed robot: its description, and whether it reaches the waypoints of the shipped motions."""

import copy
import glob
import os
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

import rospkg
import rospy
import rostest
import yaml
from catkin.find_in_workspaces import find_in_workspaces

PACKAGE = rospkg.RosPack().get_path('deformable_sim')
URDF = os.path.join(PACKAGE, 'urdf', 'two_arm_robot.urdf')
MOTION = os.path.join(PACKAGE, 'config', 'demo', 'towel_fold.yaml')


def executable():
    for directory in find_in_workspaces(['libexec'], 'deformable_sim'):
        if os.access(os.path.join(directory, 'robot_demo'), os.X_OK):
            return os.path.join(directory, 'robot_demo')
    raise AssertionError('robot_demo is not built')


def check(motion, name):
    """Runs `robot_demo --check` on a motion, under a node name of its own. Returns (exit code, output)."""
    if motion is not None:
        rospy.set_param('/%s/motion' % name, motion)
    done = subprocess.run([executable(), '--check', '__name:=' + name], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, universal_newlines=True, timeout=60)
    return done.returncode, done.stdout


def joints_up_from(tip, joints):
    """Moving joints between a link and the root. `joints` by their child link."""
    names = []
    while tip in joints:
        joint = joints[tip]
        if joint.get('type') != 'fixed':
            names.append(joint.get('name'))
        tip = joint.find('parent').get('link')
    return names


class TwoArmRobot(unittest.TestCase):

    def setUp(self):
        with open(MOTION) as f:
            self.motion = yaml.safe_load(f)
        robot = ElementTree.parse(URDF).getroot()
        self.links = robot.findall('link')
        self.joints = {j.find('child').get('link'): j for j in robot.findall('joint')}

    def test_each_arm_has_six_joints_with_limits_and_two_fingers(self):
        for side in ('left', 'right'):
            self.assertGreaterEqual(len(joints_up_from(side + '_gripper', self.joints)), 6)
            fingers = [j for j in self.joints.values()
                       if j.get('type') == 'prismatic' and j.find('parent').get('link') == side + '_hand_link']
            self.assertEqual(2, len(fingers))
        for joint in self.joints.values():
            if joint.get('type') != 'fixed':
                limit = joint.find('limit')
                self.assertLess(float(limit.get('lower')), float(limit.get('upper')))
                self.assertGreater(float(limit.get('velocity')), 0)

    def test_every_collision_shape_is_a_primitive(self):
        shapes = [c.find('geometry')[0].tag for link in self.links for c in link.findall('collision')]
        self.assertTrue(shapes)
        self.assertLessEqual(set(shapes), {'box', 'cylinder', 'sphere'})

    def test_every_inertia_is_that_of_a_real_body(self):
        # Principal moments of any body: a <= b + c.
        inertias = [link.find('inertial/inertia') for link in self.links if link.find('visual') is not None]
        self.assertTrue(inertias)
        for inertia in inertias:
            a, b, c = sorted(float(inertia.get(k)) for k in ('ixx', 'iyy', 'izz'))
            self.assertGreater(a, 0)
            self.assertLessEqual(c, (a + b) * (1 + 1e-5))  # six digits are written

    def test_the_description_is_what_its_script_writes(self):
        script = os.path.join(PACKAGE, 'urdf', 'make_two_arm_robot.py')
        with tempfile.NamedTemporaryFile('r', suffix='.urdf') as f:
            subprocess.run([sys.executable, script, f.name], check=True)
            with open(URDF) as shipped:
                self.assertEqual(f.read(), shipped.read())

    def test_the_arms_reach_every_waypoint_of_the_shipped_motions(self):
        files = glob.glob(os.path.join(PACKAGE, 'config', 'demo', '*.yaml'))
        self.assertTrue(files)
        for k, path in enumerate(sorted(files)):
            with open(path) as f:
                code, output = check(yaml.safe_load(f), 'shipped_%d' % k)
            self.assertEqual(0, code, path + ': ' + output)
            self.assertIn('reachable', output)

    def refused(self, name, motion, *reasons):
        code, output = check(motion, name)
        self.assertEqual(2, code, output)
        for reason in reasons:
            self.assertIn(reason, output)

    def changed(self):
        return copy.deepcopy(self.motion)

    def test_a_waypoint_out_of_reach_is_refused_by_name(self):
        motion = self.changed()
        motion['steps'][2]['left']['position'] = [3.0, 0.2, 0.8]
        self.refused('far', motion, "steps[2] 'reached'", "arm 'left'", 'cannot reach')

    def test_a_motion_beyond_the_speed_of_a_joint_is_refused(self):
        motion = self.changed()
        motion['steps'][1]['duration'] = 0.1
        self.refused('fast', motion, 'steps[1]', 'rad/s of joint', 'limit')

    def test_an_opening_beyond_the_stroke_of_the_fingers_is_refused(self):
        motion = self.changed()
        motion['steps'][1]['right']['opening'] = 0.5
        self.refused('wide', motion, "arm 'right'", 'opening', 'right_finger_1_joint')

    def test_an_unknown_key_is_refused_with_the_allowed_ones(self):
        motion = self.changed()
        motion['steps'][1]['left']['height'] = 1.0
        self.refused('unknown', motion, "steps[1].left: unknown key 'height'", 'opening, position, rpy')

    def test_a_number_that_is_none_is_refused(self):
        for name, value in (('word', 'high'), ('nan', float('nan'))):
            motion = self.changed()
            motion['steps'][1]['left']['position'] = [0.3, value, 0.8]
            self.refused(name, motion, 'steps[1].left.position: must be a finite number')

    def test_a_missing_motion_is_refused(self):
        self.refused('nothing', None, '~motion is missing')


if __name__ == '__main__':
    rostest.rosrun('deformable_sim', 'robot_demo', TwoArmRobot)
