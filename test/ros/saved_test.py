#!/usr/bin/env python3
"""Saved simulations: the same bits in the same node and in another one; refusals; a node killed while it saves."""

import os
import random
import signal
import subprocess
import tempfile
import threading
import unittest

import roslib.packages
import rospy
import rostest

from support import DEADLINE, Refusals, Simulation, Status, box, feature, wait_until

SCENE = '/test/ros/scenes/hanging.yaml'


class Saved(Refusals, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.executable = roslib.packages.find_node('deformable_sim', 'sim_node')[0]
        cls.scene = roslib.packages.get_pkg_dir('deformable_sim') + SCENE

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.node = None
        self.sim = self.start()

    def tearDown(self):
        self.stop(signal.SIGINT)
        self.folder.cleanup()

    def start(self):
        self.node = subprocess.Popen(
            [self.executable, '_scene:=' + self.scene, '_clock:=on_demand', '__name:=keeper',
             '_state_dir:=' + os.path.join(self.folder.name, 'states')], stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL)
        return Simulation('keeper')

    def stop(self, how):
        self.node.send_signal(how)
        self.node.wait(DEADLINE)

    def save(self, **where):
        answer = self.sim.save_state(**where)
        self.assertEqual(answer.status.code, Status.OK, answer.status.message)
        return answer.time

    def restore(self, **where):
        answer = self.sim.restore_state(**where)
        self.assertEqual(answer.status.code, Status.OK, answer.status.message)
        return answer.time

    def disturb(self):
        """Grasps, obstacles and time that are not those of the scene."""
        self.sim.steps(11)
        self.assertEqual(self.sim.grasp(name='hand', body='sheet', selection=feature('corner_0'),
                                        max_force=7.0).status.code, Status.OK)
        self.assertEqual(self.sim.add_obstacle(box('late')).status.code, Status.OK)
        self.sim.steps(5)

    def test_by_name_the_same_bits_follow(self):
        self.disturb()
        self.assertAlmostEqual(self.save(name='before'), 0.16, delta=1e-12)
        at_save = self.sim.everything()
        self.sim.steps(9)
        later = self.sim.everything()
        self.sim.release('hand')
        self.assertTrue(self.sim.reset().success)
        self.sim.steps(2)
        self.assertAlmostEqual(self.restore(name='before'), 0.16, delta=1e-12)
        self.assertEqual(at_save, self.sim.everything())
        self.sim.steps(9)
        self.assertEqual(later, self.sim.everything())

    def test_a_node_that_was_killed_goes_on_in_a_new_one_to_the_same_bits(self):
        self.disturb()
        self.save(file='robot.state')
        self.sim.steps(9)
        later = self.sim.everything()
        self.stop(signal.SIGKILL)
        self.sim = self.start()
        self.assertAlmostEqual(self.restore(file='robot.state'), 0.16, delta=1e-12)
        self.sim.steps(9)
        self.assertEqual(later, self.sim.everything())

    def test_what_cannot_be_saved_or_restored_is_refused(self):
        for call in (self.sim.save_state, self.sim.restore_state):
            self.refuse(Status.INVALID_ARGUMENT, 'one of the two', call)
            self.refuse(Status.INVALID_ARGUMENT, 'one of the two', lambda: call(name='a', file='b'))
            self.refuse(Status.INVALID_ARGUMENT, 'letter', lambda: call(name='../a'))
            for file in ('../a', '/etc/passwd', '.', '..', 'a/b', 'a\nb', '.hidden', 200 * 'a'):
                self.refuse(Status.INVALID_ARGUMENT, 'allowed is a name', lambda: call(file=file))
        self.refuse(Status.NOT_FOUND, 'there are none', lambda: self.sim.restore_state(name='nobody'))
        self.refuse(Status.NOT_FOUND, 'cannot be read', lambda: self.sim.restore_state(file='nobody'))
        self.save(file='whole')
        path = os.path.join(self.folder.name, 'states', 'whole')
        with open(path, 'rb') as file:
            whole = file.read()
        for damaged, word in ((whole[:-1], 'cut'), (b'', 'no saved'), (whole[:200] + b'x' + whole[201:], 'altered')):
            with open(path, 'wb') as file:
                file.write(damaged)
            self.refuse(Status.INVALID_ARGUMENT, word, lambda: self.sim.restore_state(file='whole'))
        self.save(name='hanging')
        self.assertEqual(self.sim.load_scene(file=self.scene.replace('hanging', 'small')).status.code, Status.OK)
        answer = self.sim.restore_state(name='hanging')
        self.assertEqual(answer.status.code, Status.INVALID_ARGUMENT)
        self.assertIn('another scene', answer.status.message)

    def test_a_node_killed_while_it_saves_leaves_a_whole_file(self):
        self.sim.steps(1)
        self.save(file='kept')
        for trial in range(3):
            written = [0.0]

            def keep_saving():
                try:
                    while True:
                        self.sim.steps(1)
                        written.append(self.save(file='kept'))
                except (rospy.ServiceException, rospy.exceptions.ROSException, OSError):
                    pass

            client = threading.Thread(target=keep_saving)
            client.start()
            wait_until(lambda: len(written) > random.Random(trial).randrange(5, 20), 'some saved states')
            self.stop(signal.SIGKILL)
            client.join(DEADLINE)
            self.sim = self.start()
            self.assertGreaterEqual(self.restore(file='kept'), written[-1])


if __name__ == '__main__':
    rospy.init_node('saved_test')
    rostest.rosrun('deformable_sim', 'saved', Saved)
