#!/usr/bin/env python3
"""Sessions recorded by rosbag and made again by `simulate --replay`: the same bits, and every difference seen."""

import os
import re
import signal
import struct
import subprocess
import tempfile
import time
import unittest

import rosbag
import roslib.packages
import rospy
import rostest

from deformable_sim.msg import SessionRecord
from real_time_test import MovingFrame
from support import DEADLINE, Simulation, Status, box, feature, nearest, wait_until

SCENE = '/test/ros/scenes/hanging.yaml'
NODE = 'recorded'


class Replay(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.programs = {name: roslib.packages.find_node('deformable_sim', name)[0] for name in ('sim_node', 'simulate')}
        cls.scene = roslib.packages.get_pkg_dir('deformable_sim') + SCENE

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.bag = os.path.join(self.folder.name, 'session.bag')
        self.node = self.recorder = None

    def tearDown(self):
        for process in (self.recorder, self.node):
            self.end(process)
        self.folder.cleanup()

    @staticmethod
    def end(process):
        if process and process.poll() is None:
            process.send_signal(signal.SIGINT)
            process.wait(DEADLINE)

    def start(self, *parameters):
        self.node = subprocess.Popen([self.programs['sim_node'], '_scene:=' + self.scene, '__name:=' + NODE, *parameters],
                                     stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.sim = Simulation(NODE)

    def record(self):
        topics = ['/%s/%s' % (NODE, name) for name in ('session', 'sheet/state', 'line/state')]
        self.recorder = subprocess.Popen(['rosbag', 'record', '-O', self.bag, *topics], stdout=subprocess.DEVNULL,
                                         stderr=subprocess.DEVNULL)
        master = rospy.get_master()

        def listens():
            subscribed = {topic: nodes for topic, nodes in master.getSystemState()[2][1]}
            return all(subscribed.get(topic) for topic in topics)
        wait_until(listens, 'the recorder')
        time.sleep(0.5)  # until it is connected

    def replay(self, bag=None, *arguments):
        """(exit code, what it says)."""
        done = subprocess.run([self.programs['simulate'], '--replay', bag or self.bag, '--quiet', *arguments],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, timeout=DEADLINE)
        return done.returncode, done.stdout

    def equal(self, text):
        return int(re.search(r'(\d+) equal, 0 different', text).group(1))

    def session(self):
        """A bag of a session on demand with commands of all kinds, begun in its middle."""
        self.start('_clock:=on_demand')
        self.sim.steps(7)
        self.record()
        sim = self.sim
        self.ok(sim.grasp(name='hand', body='line', selection=feature('end_1')))
        sim.steps(5)
        self.ok(sim.move_grasp(name='hand', target=nearest(0.3, 1.0, 1.2).pose))
        sim.steps(20)
        self.ok(sim.add_obstacle(box('crate')))
        self.ok(sim.let_through(obstacle='crate', bodies=['line']))
        sim.steps(5)
        self.ok(sim.save_state(name='kept'))
        state = sim.get_state('sheet').state
        state.velocities = [v + 0.25 for v in state.velocities]
        self.ok(sim.set_state(state=state))
        sim.steps(5)
        self.ok(sim.release('hand'))
        sim.steps(5)
        self.ok(sim.restore_state(name='kept'))
        sim.steps(5)
        self.assertTrue(sim.reset().success)
        sim.steps(5)
        self.ok(sim.remove_obstacle('table'))
        sim.steps(5)
        self.close()

    def ok(self, answer):
        self.assertEqual(answer.status.code, Status.OK, answer.status.message)

    def close(self):
        time.sleep(1.0)  # for what is under way
        self.end(self.recorder)
        self.end(self.node)

    def altered(self, change):
        """A copy of the bag; change(topic, message) gives what is written, or None."""
        path = os.path.join(self.folder.name, 'altered.bag')
        with rosbag.Bag(self.bag) as bag, rosbag.Bag(path, 'w') as out:
            for topic, message, stamp in bag.read_messages():
                written = change(topic.split('/')[-1], message)
                if written is not None:
                    out.write(topic, written, stamp)
        return path

    def test_a_session_on_demand_and_what_was_altered(self):
        self.session()
        code, text = self.replay()
        self.assertEqual(code, 0, text)
        self.assertGreater(self.equal(text), 20, text)  # what is published is the newest when there is time
        self.assertIn('55 steps, 7 commands', text)
        self.assertIn('3 beginnings', text)
        self.assertEqual(self.replay(None, '--threads', '2')[0], 0)

        count = [0]

        def nudge(topic, message):
            if topic == 'state':
                count[0] += 1
                if count[0] == 15:
                    message.positions = list(message.positions)
                    bits, = struct.unpack('<q', struct.pack('<d', message.positions[4]))
                    message.positions[4], = struct.unpack('<d', struct.pack('<q', bits + 1))
            return message
        code, text = self.replay(self.altered(nudge))
        self.assertEqual(code, 1, text)
        self.assertIn('1 different', text)
        self.assertIn('node 1 is', text)

        def without(kind, nth, renumber):
            seen, gone = [0], [0]

            def change(topic, message):
                if topic != 'session':
                    return message
                if message.kind == kind:
                    seen[0] += 1
                    if seen[0] == nth:
                        gone[0] = 1
                        return None
                message.number -= gone[0] if renumber else 0
                return message
            return change
        code, text = self.replay(self.altered(without(SessionRecord.COMMAND, 2, False)))
        self.assertEqual(code, 2, text)
        self.assertIn('is missing', text)
        code, text = self.replay(self.altered(without(SessionRecord.COMMAND, 2, True)))  # the grasp does not move
        self.assertEqual(code, 1, text)
        self.assertRegex(text, r"different   '(line|sheet)' at step (1[3-9]|[23]\d)")

        def cut(topic, message):
            if topic == 'session' and message.kind in (SessionRecord.BEGIN, SessionRecord.COMMAND):
                message.data = message.data[:-1]
            return message
        code, text = self.replay(self.altered(cut))
        self.assertEqual(code, 2, text)
        self.assertIn('ends too early', text)
        for what, change in (('no session', lambda topic, message: message if topic == 'state' else None),
                             ('no ~<body>/state', lambda topic, message: message if topic == 'session' else None)):
            code, text = self.replay(self.altered(change))
            self.assertEqual((code, what in text), (2, True), text)
        with open(self.bag, 'r+b') as stream:
            stream.truncate(os.path.getsize(self.bag) // 2)
        for path in (self.bag, self.scene, '/no/such.bag'):
            code, text = self.replay(path)
            self.assertEqual(code, 2, text)
            self.assertIn(path, text)

    def test_a_session_in_real_time_with_a_gripper_on_tf(self):
        self.start()
        self.record()
        frame = MovingFrame('gripper', (0.5, 1.0, 1.0), speed=0.1)
        try:
            self.ok(self.sim.grasp(name='hand', body='line', selection=feature('end_1'), follow_frame='gripper'))
            time.sleep(1.5)
        finally:
            frame.stop()
        time.sleep(0.5)  # the grasp waits for its frame
        self.assertTrue(self.sim.pause(True).success)
        self.close()
        code, text = self.replay()
        self.assertEqual(code, 0, text)
        self.assertGreater(self.equal(text), 50, text)
        self.assertGreater(int(re.search(r'(\d+) commands', text).group(1)), 20, text)


if __name__ == '__main__':
    rospy.init_node('replay_test')
    rostest.rosrun('deformable_sim', 'replay', Replay)
