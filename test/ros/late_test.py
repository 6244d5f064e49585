#!/usr/bin/env python3
"""Real time that cannot be held: it is said, and what ~when_late names gives way."""

import os
import subprocess
import tempfile
import unittest

import roslib.packages
import rospy
import rostest

from support import DEADLINE, SimStatus, Simulation

# A hundred times what a core can do in real time, whatever the machine.
HEAVY = """
step: {integrator: implicit_euler, linear_solver: direct, dt: 0.005}
bodies:
  - cloth: {name: sheet, size: [1, 1], cells: [60, 60], pins: [corner_2, corner_3]}
"""
# Steps in 64 parts, for an error that they cannot hold either: more than a core can do; in one part it is light.
PRECISE = """
step: {integrator: linear_implicit_euler, dt: 0.02, control: error, accuracy: 1.0e-5}
bodies:
  - cloth: {name: sheet, size: [1, 1], cells: [26, 26], pins: [corner_2, corner_3]}
"""


class Late(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.executable = roslib.packages.find_node('deformable_sim', 'sim_node')[0]

    def setUp(self):
        self.node = None

    def tearDown(self):
        if self.node:
            self.node.terminate()
            self.node.wait(DEADLINE)

    def start(self, scene, *parameters):
        """The listener to ~status of a node with the scene."""
        with tempfile.NamedTemporaryFile('w', suffix='.yaml') as file:
            file.write(scene)
            file.flush()
            self.node = subprocess.Popen([self.executable, '_scene:=' + file.name, '__name:=hurried', *parameters],
                                         stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.sim = Simulation('hurried')
        return self.sim.listen('status', SimStatus)

    @staticmethod
    def says(message, what):
        return any('real time is not held' in w and what in w for w in message.warnings)

    def test_it_runs_slower_and_says_by_how_much(self):
        status = self.start(HEAVY)
        late = status.wait(lambda m: self.says(m, 'factor 0.'))
        self.assertFalse(late.paused)
        self.assertLess(late.real_time_factor, 0.9)
        status.wait(lambda m: m.time > late.time and not m.paused, after=len(status.messages))

    def test_it_stops_and_goes_on_when_asked(self):
        status = self.start(HEAVY, '_when_late:=stop')
        stopped = status.wait(lambda m: m.paused and self.says(m, 'paused, as when_late says'))
        self.assertEqual(status.wait(lambda m: True, after=len(status.messages)).time, stopped.time)
        self.assertTrue(self.sim.pause(False).success)
        status.wait(lambda m: m.time > stopped.time)

    def test_it_goes_before_others_where_that_is_allowed(self):
        status = self.start(HEAVY, '_priority:=7').wait(lambda m: m.time > 0.0)
        refused = any('no real-time priority 7' in w for w in status.warnings)
        policies = [(os.sched_getscheduler(thread) & ~os.SCHED_RESET_ON_FORK, os.sched_getparam(thread).sched_priority)
                    for thread in map(int, os.listdir('/proc/%d/task' % self.node.pid))]
        self.assertEqual(policies.count((os.SCHED_FIFO, 7)), 0 if refused else 1, policies)

    def test_accuracy_gives_way_and_real_time_is_held_again(self):
        status = self.start(PRECISE, '_when_late:=less_accurate', '_accuracy_floor:=1.0')
        status.wait(lambda m: m.substeps == 64)
        status.wait(lambda m: self.says(m, 'accuracy gives way, up to an error of 100'))
        status.wait(lambda m: m.substeps < 32 and not self.says(m, ''))
        last = status.wait(lambda m: any('are asked for' in w for w in m.warnings), after=len(status.messages))
        self.assertLess(last.substeps, 64)


if __name__ == '__main__':
    rospy.init_node('late_test')
    rostest.rosrun('deformable_sim', 'late', Late)
