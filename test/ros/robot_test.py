#!/usr/bin/env python3
"""The robot of robot_description: its links, and what they carry, enter with their first transform and move with it."""

import unittest

import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import TransformStamped

from deformable_sim.msg import SimStatus
from support import Simulation, Status, wait_until


def transform(parent, child, z):
    message = TransformStamped()
    message.header.stamp = rospy.Time.now()
    message.header.frame_id = parent
    message.child_frame_id = child
    message.transform.translation.z = z
    message.transform.rotation.w = 1.0
    return message


class Robot(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sim = Simulation()
        cls.tf = tf2_ros.TransformBroadcaster()

    def heights(self):
        """{obstacle: z} after one more step."""
        self.sim.steps(1)
        heights = {}
        for line in self.sim.describe().message.splitlines():
            if line.startswith('obstacle: '):
                heights[line.split()[1]] = float(line.rstrip(')').split()[-1])
        return heights

    def send_until(self, z, condition):
        def sent():
            self.tf.sendTransform([transform('world', 'base', 0.0), transform('base', 'hand', z)])
            return condition(self.heights())

        wait_until(sent, 'the robot at %g m' % z)

    def test_links_enter_with_their_first_transform_and_move_with_it(self):
        status = self.sim.listen('status', SimStatus)
        self.assertEqual(self.heights(), {})
        status.wait(lambda m: any('no transform yet' in w and 'hand' in w for w in m.warnings))
        # The mesh link is left out; the one without a shape is no obstacle.
        self.send_until(0.5, lambda h: set(h) == {'robot.base', 'robot.hand', 'tray'})
        self.send_until(0.7, lambda h: abs(h['robot.hand'] - 0.7) < 1e-6 and abs(h['tray'] - 0.8) < 1e-6)
        self.assertEqual(self.heights()['robot.base'], 0.0)
        count = len(status.messages)
        status.wait(lambda m: not any('no transform yet' in w for w in m.warnings), after=count)
        status.close()

        self.assertTrue(self.sim.reset().success)
        self.send_until(0.6, lambda h: abs(h.get('robot.hand', 0.0) - 0.6) < 1e-6)

    def test_a_link_is_no_obstacle_of_a_user(self):
        answer = self.sim.remove_obstacle('robot.hand')
        self.assertEqual(answer.status.code, Status.INVALID_ARGUMENT)

    def test_a_link_that_does_not_exist_is_refused(self):
        answer = self.sim.load_scene(yaml='bodies:\n  - cloth: {name: a}\nrobot: {links: [elbow]}\n')
        self.assertEqual(answer.status.code, Status.NOT_FOUND)
        self.assertIn('elbow', answer.status.message)
        self.assertIn('hand', answer.status.message)


if __name__ == '__main__':
    rospy.init_node('robot_test')
    rostest.rosrun('deformable_sim', 'robot', Robot)
