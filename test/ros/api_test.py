#!/usr/bin/env python3
"""doc/ros_api.md names what the running node has: no more, no less."""

import re
import unittest

import roslib.packages
import rosgraph
import rospy
import rosservice
import rostest

from support import Simulation, nearest, wait_until

NODE = '/deformable_sim'
BODIES = {'sheet', 'line'}
GRASPS = {'pin_sheet_corner_2', 'pin_sheet_corner_3', 'pin_line_end_0'}
CAMERAS = {'eye'}
ATTACHED = set()  # obstacles that follow a frame: robot_test.py has some
EVERY_NODE = {'/rosout', '/use_sim_time', '/clock', NODE + '/get_loggers', NODE + '/set_logger_level'}


def documented(page, heading):
    """{name: type} of the table under a heading, with <body>, <name>, <camera> and <obstacle> filled in."""
    section = page.split('## ' + heading + '\n')[1].split('\n## ')[0]
    rows = {}
    for name, kind in re.findall(r'^\| `([^`]+)` \| (\S+) \|', section, re.MULTILINE):
        name = name.replace('~', NODE + '/')
        if '<camera>' in name:
            rows.update({name.replace('<camera>', camera): kind for camera in CAMERAS})
            continue
        for body in BODIES if '<body>' in name else {''}:
            for grasp in GRASPS if '<name>' in name else {''}:
                for obstacle in ATTACHED if '<obstacle>' in name else {''}:
                    rows[name.replace('<body>', body).replace('<name>', grasp).replace('<obstacle>', obstacle)] = kind
    return rows


class Api(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.page = open(roslib.packages.get_pkg_dir('deformable_sim') + '/doc/ros_api.md').read()
        cls.sim = Simulation()
        cls.master = rosgraph.Master('/api_test')

    def of_node(self, part):
        return {name for name, nodes in self.master.getSystemState()[part] if NODE in nodes} - EVERY_NODE

    def compare(self, part, heading, leave_out=()):
        expected = documented(self.page, heading)
        self.assertGreater(len(expected), 3)
        names = set(expected) - set(leave_out) - EVERY_NODE
        try:
            wait_until(lambda: self.of_node(part) == names, 'topics as documented')
        except AssertionError:
            self.assertEqual(self.of_node(part), names)
        return {name: expected[name] for name in names}

    def test_published_topics(self):
        types = dict(self.master.getTopicTypes())
        for name, kind in self.compare(0, 'Topics published').items():
            self.assertEqual(types[name], kind, name)

    def test_subscribed_topics(self):
        # /tf is listened to once something needs it: ask for an unknown frame.
        self.sim.move_grasp(name='pin_line_end_0', target=nearest(0, 0, 0, frame='nowhere').pose)
        self.compare(1, 'Topics subscribed')

    def test_services(self):
        for name, kind in self.compare(2, 'Services').items():
            self.assertEqual(rosservice.get_service_type(name), kind, name)

    def test_parameters(self):
        section = self.page.split('## Parameters\n')[1].split('\n## ')[0]
        names = set(re.findall(r'^\| `~(\w+)`', section, re.MULTILINE))
        log = open(roslib.packages.get_pkg_dir('deformable_sim') + '/src/ros/parameters.cpp').read()
        self.assertEqual(names, set(re.findall(r'reader\.read(?:_real)?\("(\w+)"', log)))


if __name__ == '__main__':
    rospy.init_node('api_test')
    rostest.rosrun('deformable_sim', 'api', Api)
