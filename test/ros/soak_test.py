#!/usr/bin/env python3
"""A short part of ./run study soak: every disturbance once, each bound held, with a master of its own."""

import os
import subprocess
import sys
import tempfile
import unittest

import roslib.packages
import rostest

HOURS = '0.1'


class Soak(unittest.TestCase):
    def test_a_node_holds_every_bound_while_parts_of_the_system_fail(self):
        script = os.path.join(roslib.packages.get_pkg_dir('deformable_sim'), 'scripts/soak')
        node = roslib.packages.find_node('deformable_sim', 'sim_node')[0]
        with tempfile.TemporaryDirectory() as out:
            run = subprocess.run([sys.executable, script, '--node', node, '--hours', HOURS, '--seed', '5', '--quiet', '--out', out],
                                 capture_output=True, text=True)
            self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
            self.assertIn('1 x master restarted', run.stdout)
            with open(os.path.join(out, 'samples.csv'), encoding='utf-8') as samples:
                self.assertGreater(len(samples.readlines()), 1)


if __name__ == '__main__':
    rostest.rosrun('deformable_sim', 'soak', Soak)
