#!/usr/bin/env python3
"""Eight simulations under one master: each has its own names, commands and bits; a dataset is collected from all at once."""

import os
import subprocess
import sys
import tempfile
import threading
import unittest

import roslib.packages
import rosbag
import rospy
import rostest
from deformable_sim import Environment, Grasp, MoveTo, Simulation, feature

COUNT = 8
STEPS = 10


def height(k):
    return 0.6 + 0.05 * k


class Many(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sims = [Simulation('sim_%d/deformable_sim' % k, timeout=60.0, wait=60.0) for k in range(COUNT)]

    def episode(self, k, digests, errors):
        """Lifts the end of the rope to a height of its own."""
        try:
            environment = Environment(self.sims[k], steps=5, grippers=['hand'])
            environment.reset()
            action = {'hand': [Grasp('line', feature('end_1')), MoveTo((0.25, 1.0, height(k)))]}
            for _ in range(STEPS):
                observation = environment.step(action)[0]
                digests[k].append(observation.digest())
                action = None
            self.assertAlmostEqual(observation.states['line'].positions[-1][2], height(k), delta=1e-9)
        except Exception as error:
            errors.append((k, error))

    def run_all(self):
        digests, errors = [[] for _ in range(COUNT)], []
        threads = [threading.Thread(target=self.episode, args=(k, digests, errors)) for k in range(COUNT)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(60.0)
        self.assertEqual(errors, [])
        return digests

    def test_each_does_its_own_and_the_same_each_time(self):
        first, second = self.run_all(), self.run_all()
        self.assertEqual([len(digests) for digests in first], [STEPS] * COUNT)
        self.assertEqual(first, second)
        self.assertEqual(len({digests[-1] for digests in first}), COUNT, 'two have had the same commands')

    def test_a_dataset_of_all(self):
        script = os.path.join(roslib.packages.get_pkg_dir('deformable_sim'), 'examples/python/collect_dataset.py')
        with tempfile.TemporaryDirectory() as folder:
            collectors = [subprocess.Popen(
                [sys.executable, script, '--node', 'sim_%d/deformable_sim' % k, '--out', os.path.join(folder, str(k)), '--body', 'line',
                 '--episodes', '1', '--steps', '3', '--seed', str(k), '__name:=collector_%d' % k]) for k in range(COUNT)]
            self.assertEqual([collector.wait(120.0) for collector in collectors], [0] * COUNT)
            for k in range(COUNT):
                with rosbag.Bag(os.path.join(folder, str(k), 'episode_%04d.bag' % k)) as bag:
                    topics = {topic: info.message_count for topic, info in bag.get_type_and_topic_info().topics.items()}
                self.assertEqual(len(topics), 4)
                for topic, count in topics.items():
                    self.assertTrue(topic.startswith('/sim_%d/deformable_sim/' % k), topic)
                    self.assertEqual(count, 3)


if __name__ == '__main__':
    rospy.init_node('many_test')
    rostest.rosrun('deformable_sim', 'many', Many)
