#!/usr/bin/env python3
"""The Python examples do what they say, as programs of their own, and so do the snippets of doc/python.md."""

import glob
import os
import re
import subprocess
import sys
import tempfile
import unittest

import numpy
import rosbag
import roslib.packages
import rospy
import rostest

import deformable_sim
from deformable_sim import Simulation

from support import DEADLINE

HERE = os.path.dirname(os.path.abspath(__file__))
SCENE = os.path.join(HERE, 'scenes', 'hanging.yaml')
LIMIT = 6 * DEADLINE


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sim = Simulation(timeout=DEADLINE, wait=DEADLINE)

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.sim.load_scene(SCENE)

    def run_program(self, path, *arguments, environment=None):
        return subprocess.run([sys.executable, path, *arguments], cwd=self.folder.name, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, universal_newlines=True, timeout=LIMIT,
                              env=dict(os.environ, **(environment or {})))

    def run_example(self, name, *arguments, expect=0):
        # As rosrun finds it, which asks back where there are two.
        found = roslib.packages.find_node('deformable_sim', name)
        self.assertEqual(len(found), 1, found)
        done = self.run_program(found[0], *arguments)
        self.assertEqual(done.returncode, expect, done.stdout)
        return done.stdout

    def test_the_nearest_point_is_lifted_and_let_go(self):
        text = self.run_example('grasp_nearest.py', '--body', 'line', '--point', '0.0', '1.0', '0.5', '--height', '0.2',
                                '--seconds', '0.5', '--radius', '0.5')
        node, lifted, force = re.match(r'held node (\d+) of line, lifted it by (\S+) m, .* with (\S+) N', text).groups()
        self.assertGreaterEqual(int(node), 1)
        self.assertAlmostEqual(float(lifted), 0.2, delta=1e-3)
        self.assertGreater(float(force), 0.0)
        self.assertFalse([g for g in self.sim.describe()['grasp'] if g.startswith('example')])

    def test_the_towel_is_folded(self):
        text = self.run_example('fold_towel.py', '--seconds', '1.2', '--rest', '0.4')
        self.assertIn('folded towel', text)
        positions = self.sim.get_state('towel').positions.reshape(17, 17, 3)
        # The corners of the last row lie on those of the first, which they were 0.4 m away from, and not below them.
        apart = positions[16, [0, 16]] - positions[0, [0, 16]]
        self.assertLess(numpy.linalg.norm(apart, axis=1).max(), 0.03)
        self.assertGreater(apart[:, 2].min(), 0.0)
        # What is farthest from those edges is the crease: half of 0.4 m away, less what lies in its bend; two layers.
        crease = positions[:, :, 1].max() - positions[[0, 16], :, 1].max()
        self.assertTrue(0.15 < crease < 0.2, crease)
        self.assertLess(positions[:, :, 2].max(), 0.78)
        self.assertNotIn('grasp', self.sim.describe())

    def test_a_fold_that_fails_says_so(self):
        # No time to carry the corners over: they are let go where they were taken.
        text = self.run_example('fold_towel.py', '--seconds', '0', '--rest', '0', expect=1)
        self.assertIn('not folded', text)

    def episodes(self, name, *arguments):
        folder = os.path.join(self.folder.name, name)
        self.run_example('collect_dataset.py', '--out', folder, '--body', 'sheet', '--episodes', '2', '--steps', '5',
                         '--seconds', '0.05', '--reach', '0.03', *arguments)
        found = sorted(glob.glob(os.path.join(folder, '*')))
        self.assertEqual([os.path.basename(path) for path in found], ['episode_0000.bag', 'episode_0001.bag'])
        return [self.messages_of(path) for path in found]

    @staticmethod
    def messages_of(path):
        topics = {}
        with rosbag.Bag(path) as bag:
            for topic, message, time in bag.read_messages():
                topics.setdefault(topic, []).append((time, message))
        return topics

    def test_a_dataset_has_every_step_once_with_one_stamp(self):
        first = self.episodes('first')
        names = {'/deformable_sim/' + name for name in ('sheet/state', 'sheet/points', 'grasps', 'grasp/gripper/target')}
        for episode in first:
            self.assertEqual(set(episode), names)
            for messages in episode.values():
                # One step after the reset, then five of 0.05 s.
                self.assertEqual([time.to_nsec() for time, _ in messages],
                                 [int(1e6) * ms for ms in (60, 110, 160, 210, 260)])
                for time, message in messages:
                    self.assertEqual(message.header.stamp, time)
            for i in range(5):
                state, cloud, grasps, target = (episode['/deformable_sim/' + name][i][1] for name in
                                                ('sheet/state', 'sheet/points', 'grasps', 'grasp/gripper/target'))
                positions = numpy.array(state.positions).reshape(-1, 3)
                points = deformable_sim.cloud_array(cloud)
                self.assertEqual(points['x'].ravel().tolist(), positions[:, 0].astype(numpy.float32).tolist())
                grasp = next(g for g in grasps.grasps if g.name == 'gripper')
                goal = target.pose.position
                numpy.testing.assert_allclose(positions[grasp.nodes[0]], [goal.x, goal.y, goal.z], atol=0.05)
        again = self.episodes('again')
        for name in names - {'/deformable_sim/sheet/points', '/deformable_sim/grasps'}:
            for one, other in zip(first, again):
                self.assertEqual([getattr(m, 'positions', None) or str(m.pose) for _, m in one[name]],
                                 [getattr(m, 'positions', None) or str(m.pose) for _, m in other[name]])
        self.assertNotEqual(first[0]['/deformable_sim/sheet/state'][0][1].positions,
                            first[1]['/deformable_sim/sheet/state'][0][1].positions)

    def test_without_a_node_each_example_says_what_to_start(self):
        for name in ('grasp_nearest.py', 'fold_towel.py', 'collect_dataset.py'):
            with self.subTest(name):
                text = self.run_example(name, '--node', 'nobody', expect=1)
                self.assertIn('no node offers /nobody/step', text)
                self.assertIn('roslaunch deformable_sim simulation.launch', text)
                self.assertNotIn('Traceback', text)

    def test_the_snippets_of_the_page_run(self):
        # In their order, as one program; a comment `# -> text` gives what the line prints.
        page = open(os.path.join(roslib.packages.get_pkg_dir('deformable_sim'), 'doc', 'python.md'), encoding='utf-8').read()
        blocks = re.findall(r'^```python\n(.*?)^```', page, re.MULTILINE | re.DOTALL)
        self.assertGreater(len(blocks), 3)
        program = os.path.join(self.folder.name, 'page.py')
        with open(program, 'w', encoding='utf-8') as stream:
            stream.write('\n'.join(blocks))
        done = self.run_program(program)
        self.assertEqual(done.returncode, 0, done.stdout)
        expected = re.findall(r'# -> (.*)$', '\n'.join(blocks), re.MULTILINE)
        self.assertGreater(len(expected), 2)
        self.assertEqual(done.stdout.splitlines(), expected)


if __name__ == '__main__':
    rospy.init_node('python_examples_test')
    rostest.rosrun('deformable_sim', 'python_examples', Examples)
