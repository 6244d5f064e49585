#!/usr/bin/env python3
"""The node plays a scene's script, from the beginning after a reset, and warns of what is refused."""

import unittest

import rostest
import rospy

from deformable_sim.msg import SimStatus
from support import Simulation, node_position


class Script(unittest.TestCase):
    def grasps(self, sim):
        return [line.split()[1] for line in sim.describe().message.splitlines() if line.startswith('grasp: ')]

    def test_it_grasps_moves_releases_and_begins_again(self):
        sim = Simulation()
        status = sim.listen('status', SimStatus)
        for _ in range(2):
            sim.steps(2)
            self.assertEqual(self.grasps(sim), ['pin_rope_end_0'])
            sim.steps(2)
            self.assertEqual(self.grasps(sim), ['pin_rope_end_0', 'hand'])
            self.assertAlmostEqual(node_position(sim.state('rope'), 10)[0], 0.49, 9)
            self.assertIn('5.05)', sim.describe().message)
            sim.steps(2)
            self.assertEqual(self.grasps(sim), ['pin_rope_end_0'])
            sim.steps(1)
            text = 'script[4]: at 0.06 s: '
            status.wait(lambda message: any(text in warning for warning in message.warnings))
            self.assertTrue(sim.reset().success)
            status.wait(lambda message: not any(text in warning for warning in message.warnings))


if __name__ == '__main__':
    rospy.init_node('script_test')
    rostest.rosrun('deformable_sim', 'script', Script)
