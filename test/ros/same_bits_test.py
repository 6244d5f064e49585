#!/usr/bin/env python3
"""The same bits headless and in the node, with and without listeners, with one thread and two, with pauses and gaps."""

import csv
import hashlib
import os
import struct
import subprocess
import tempfile
import time
import unittest

import roslib.packages
import rospy
import rostest

from deformable_sim.msg import GraspState, GraspStateArray
from real_time_test import MovingFrame
from support import DEADLINE, Listener, SimStatus, Simulation, Status, feature, wait_until

STEPS = 12
GAP = 5.0  # s, wall


def digest(states):
    """Of the positions and velocities of all bodies, to the last bit."""
    sums = hashlib.sha256()
    for state in states:
        sums.update(struct.pack('<%dd' % len(state), *state))
    return sums.hexdigest()


class SameBits(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        package = roslib.packages.get_pkg_dir('deformable_sim')
        cls.executable, cls.headless = (roslib.packages.find_node('deformable_sim', name)[0]
                                        for name in ('sim_node', 'simulate'))
        cls.scenes = os.path.join(package, 'test/ros/scenes')

    def setUp(self):
        self.node = None

    def tearDown(self):
        self.stop()

    def start(self, scene, *parameters):
        self.node = subprocess.Popen(
            [self.executable, '_scene:=' + os.path.join(self.scenes, scene), '__name:=twin', *parameters],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.sim = Simulation('twin')

    def stop(self):
        if self.node:
            self.node.terminate()
            self.node.wait(DEADLINE)
        self.node = None

    def of_node(self, bodies):
        states = [self.sim.state(body) for body in bodies]
        return digest([list(s.positions) + list(s.velocities) for s in states])

    def of_headless(self, scene, seconds, threads, bodies):
        """Frames have 17 digits: every double as it is."""
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([self.headless, os.path.join(self.scenes, scene), '--seconds', repr(seconds), '--threads',
                            str(threads), '--out', folder, '--every', repr(seconds), '--format', 'csv', '--quiet'],
                           check=True, stdout=subprocess.DEVNULL)
            states = []
            for body in bodies:
                last = sorted(name for name in os.listdir(folder) if name.startswith(body + '_'))[-1]
                with open(os.path.join(folder, last), encoding='ascii') as stream:
                    rows = [[float(value) for value in row[1:]] for row in list(csv.reader(stream))[1:]]
                states.append([x for row in rows for x in row[:3]] + [v for row in rows for v in row[3:]])
            return digest(states)

    def listen_to_everything(self):
        topics = [name for name, _ in rospy.get_published_topics('/twin')]
        self.assertIn('/twin/sheet/points', topics)
        return [Listener(name, rospy.AnyMsg) for name in topics]

    def test_headless_and_in_the_node_whoever_listens_with_one_thread_and_two(self):
        bodies = ('sheet', 'flag', 'line')
        results = {}
        for threads in (1, 2):
            results['headless, %d' % threads] = self.of_headless('shared_out.yaml', STEPS * 0.005, threads, bodies)
            for listened in (False, True):
                self.start('shared_out.yaml', '_clock:=on_demand', '_threads:=%d' % threads)
                listeners = self.listen_to_everything() if listened else []
                self.sim.steps(STEPS)
                results['node, %d, %s' % (threads, listened)] = self.of_node(bodies)
                if threads > 1 and len(os.sched_getaffinity(0)) > 1:
                    self.assertIn('on 2 threads', self.sim.describe().message)
                for listener in listeners:
                    if '/sheet/' in listener.topic:
                        listener.wait()
                    listener.close()
                self.stop()
        self.assertEqual(len(set(results.values())), 1, results)

    def test_as_fast_as_possible_with_listeners(self):
        self.start('hanging.yaml', '_clock:=as_fast_as_possible', '_start_paused:=true')
        listeners = self.listen_to_everything()
        self.assertTrue(self.sim.pause(False).success)
        wait_until(lambda: int(self.sim.description('steps')) > 50, 'some steps')
        self.compare_with_headless()
        for listener in listeners:
            listener.close()

    def compare_with_headless(self):
        """F37, F36: paused wherever it is, the node is where a run without pauses, messages or clock is then."""
        self.assertTrue(self.sim.pause(True).success)
        reached = float(self.sim.description('steps')) * 0.01
        bodies = ('sheet', 'line')
        self.assertEqual(self.of_node(bodies), self.of_headless('hanging.yaml', reached, 1, bodies))

    def test_a_pause_of_five_seconds_changes_nothing(self):
        self.start('hanging.yaml')
        status = self.sim.listen('status', SimStatus)
        status.wait(lambda m: m.time > 0.2)
        self.assertTrue(self.sim.pause(True).success)
        stood = self.sim.description('steps')
        end = time.monotonic() + GAP
        wait_until(lambda: time.monotonic() > end, 'a gap')
        self.assertEqual(self.sim.description('steps'), stood)
        self.assertTrue(self.sim.pause(False).success)
        status.wait(lambda m: m.time > 0.01 * int(stood) + 0.3)
        self.compare_with_headless()

    def test_a_gap_of_five_seconds_in_tf_changes_nothing_for_a_hand_that_stands(self):
        self.start('hanging.yaml')
        corner = self.sim.state('sheet').positions[0:3]
        hand = MovingFrame('hand', corner)
        answer = self.sim.grasp(name='held', body='sheet', selection=feature('corner_0'), follow_frame='hand')
        self.assertEqual(answer.status.code, Status.OK, answer.status.message)
        grasps = self.sim.listen('grasps', GraspStateArray)

        def held_as(state):
            return lambda m: any(g.name == 'held' and g.state == state for g in m.grasps)

        grasps.wait(held_as(GraspState.HOLDING))
        self.assertTrue(self.sim.pause(True).success)
        self.assertEqual(self.sim.save_state(name='before').status.code, Status.OK)
        first = int(self.sim.description('steps'))
        self.assertTrue(self.sim.pause(False).success)

        hand.stop()
        grasps.wait(held_as(GraspState.WAITING_FOR_FRAME), after=len(grasps.messages))
        wait_until(lambda: int(self.sim.description('steps')) > first + GAP / 0.01, 'a gap')
        hand = MovingFrame('hand', corner)
        grasps.wait(held_as(GraspState.HOLDING), after=len(grasps.messages))
        self.assertTrue(self.sim.pause(True).success)
        last = int(self.sim.description('steps'))
        after_gap = self.of_node(('sheet', 'line'))

        self.assertEqual(self.sim.restore_state(name='before').status.code, Status.OK)
        self.sim.steps(last - first)
        self.assertEqual(after_gap, self.of_node(('sheet', 'line')))
        hand.stop()
        grasps.close()


if __name__ == '__main__':
    rospy.init_node('same_bits_test')
    rostest.rosrun('deformable_sim', 'same_bits', SameBits)
