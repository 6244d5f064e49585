#!/usr/bin/env python3
"""Two nodes side by side; one of them is the clock of the system."""

import unittest

import rospy
import rostest
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import PointCloud2

from support import Listener, Simulation, Status


class TwoNodes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.left = Simulation('left')
        cls.right = Simulation('right')

    def test_clock_is_the_simulated_time_of_its_node_and_jumps_back_with_it(self):
        clock = Listener('/clock', Clock)
        for steps in (5, 20):
            time = self.left.steps(steps)
            clock.wait(lambda m: abs(m.clock.to_sec() - time) < 1e-9)
        seen = len(clock.messages)
        self.assertTrue(self.left.reset().success)
        clock.wait(lambda m: m.clock.to_sec() == 0.0, after=seen)
        self.assertAlmostEqual(self.left.steps(3), 0.03, delta=1e-12)
        clock.wait(lambda m: abs(m.clock.to_sec() - 0.03) < 1e-9, after=seen)
        clock.close()

    def test_two_nodes_do_not_touch_each_other(self):
        self.left.reset()
        self.right.reset()
        self.right.steps(4)
        self.assertEqual(self.left.description('time'), '0 s')
        cloud = self.right.listen('napkin/points', PointCloud2)
        cloud.wait(lambda m: m.header.frame_id == 'map')
        cloud.close()
        self.assertEqual(self.left.get_state('napkin').status.code, Status.NOT_FOUND)
        self.assertEqual(self.right.get_state('napkin').status.code, Status.OK)

    def test_the_steps_made_are_the_same_with_and_without_subscribers(self):
        self.left.reset()
        self.left.steps(20)
        alone = self.left.state('sheet')
        self.left.reset()
        cloud = self.left.listen('points', PointCloud2)
        self.left.steps(20)
        watched = self.left.state('sheet')
        cloud.close()
        self.assertEqual((alone.positions, alone.velocities), (watched.positions, watched.velocities))


if __name__ == '__main__':
    # Not on simulated time: deadlines here are wall time.
    rospy.init_node('clock_test')
    rostest.rosrun('deformable_sim', 'clock', TwoNodes)
