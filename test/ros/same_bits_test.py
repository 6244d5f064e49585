#!/usr/bin/env python3
"""The same scene and commands give the same bits: headless or in the node, watched or not, on any number of threads,
in one go or with pauses and with gaps between messages."""

import os
import signal
import struct
import subprocess
import tempfile
import threading
import unittest

import roslib.packages
import rospy
import rostest
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import MarkerArray

from deformable_sim.msg import BodyState, ContactArray
from support import DEADLINE, Listener, SimStatus, Simulation, Status, feature, wait_until

GAP = 5.0  # s, wall: the subject of a test, not a way to wait for something
SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'scenes', '')
TOPICS = (('markers', MarkerArray), ('points', PointCloud2), ('sheet/state', BodyState), ('contacts', ContactArray),
          ('status', SimStatus))


def world_of(path):
    """Time and world of a saved simulation (scene/state_file.cpp); not the scene's path, nor what tf was told last."""
    with open(path, 'rb') as file:
        data = file.read()
    at = 32  # header
    texts = []
    time = None
    for field in ('scene', 'time', 'script', 'world'):
        if field == 'time':
            time, = struct.unpack_from('=d', data, at)
            at += 8
        elif field == 'script':
            at += 8
        else:
            length, = struct.unpack_from('=Q', data, at)
            texts.append(data[at + 8:at + 8 + length])
            at += 8 + length
    return time, texts[1]


class SameBits(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.node, cls.simulate = (roslib.packages.find_node('deformable_sim', name)[0] for name in
                                  ('sim_node', 'simulate'))

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.process = None

    def tearDown(self):
        self.stop()
        self.folder.cleanup()

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def start(self, scene, *parameters):
        self.stop()
        self.process = subprocess.Popen(
            [self.node, '_scene:=' + SCENES + scene, '_state_dir:=' + self.folder.name, '__name:=bits', *parameters],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return Simulation('bits')

    def stop(self):
        if self.process is None:
            return
        self.process.send_signal(signal.SIGINT)
        self.process.wait(DEADLINE)
        self.process = None

    def saved(self, sim, name):
        answer = sim.save_state(file=name)
        self.assertEqual(answer.status.code, Status.OK, answer.status.message)
        return world_of(self.path(name))

    def headless(self, threads):
        name = self.path('headless_%d' % threads)
        subprocess.run([self.simulate, SCENES + 'shared_out.yaml', '--seconds', '0.3', '--threads', str(threads), '--save',
                        name, '--quiet'], check=True)
        return world_of(name)

    def in_node(self, threads, watched):
        sim = self.start('shared_out.yaml', '_clock:=on_demand', '_threads:=%d' % threads)
        listeners = [sim.listen(*topic) for topic in TOPICS] if watched else []
        sim.steps(60)
        for listener in listeners:
            listener.wait()
            listener.close()
        return self.saved(sim, 'node_%d_%d' % (threads, watched))

    def test_headless_or_in_the_node_watched_or_not_on_one_thread_or_two(self):
        alone = self.headless(1)
        self.assertAlmostEqual(alone[0], 0.3, delta=1e-12)
        self.assertGreater(len(alone[1]), 51 * 51 * 6 * 8)
        self.assertEqual(alone, self.headless(2))
        for threads in (1, 2):
            for watched in (False, True):
                self.assertEqual(alone, self.in_node(threads, watched), '%d threads, %s' % (threads, watched))

    def take_corner(self, sim):
        self.assertEqual(sim.grasp(name='hand', body='sheet', selection=feature('corner_0')).status.code, Status.OK)

    def run_until(self, sim, time):
        self.assertTrue(sim.pause(False).success)
        wait_until(lambda: float(sim.description('time').split()[0]) > time, '%g s of simulated time' % time)
        self.assertTrue(sim.pause(True).success)

    def test_a_pause_of_five_seconds_leaves_no_trace(self):
        sim = self.start('hanging.yaml', '_clock:=real_time', '_start_paused:=true')
        self.take_corner(sim)
        self.run_until(sim, 0.2)
        before = sim.everything()  # not saved: a state saved is a state begun anew
        threading.Event().wait(GAP)
        self.assertEqual(before, sim.everything())
        paused_at = float(before[1].split()[0])
        self.run_until(sim, paused_at + 0.2)
        interrupted = self.saved(sim, 'interrupted')
        self.assertGreater(interrupted[0], paused_at + 0.2)
        self.assertLess(interrupted[0], paused_at + 0.5 * GAP)  # it did not catch up with the pause
        sim = self.start('hanging.yaml', '_clock:=on_demand')
        self.take_corner(sim)
        sim.steps(int(round(interrupted[0] / 0.01)))
        self.assertEqual(interrupted, self.saved(sim, 'at_one_go'))

    def driven(self, name, gap, stream):
        """A corner goes 0.2 m aside at 0.1 m/s. gap: nothing is said or asked for GAP s of wall time on its way.
        stream: its target is sent again and again all the while."""
        sim = self.start('hanging.yaml', '_clock:=on_demand')
        self.assertEqual(sim.grasp(name='hand', body='sheet', selection=feature('corner_0'), max_speed=0.1).status.code,
                         Status.OK)
        target = PoseStamped()
        state = sim.state('sheet')
        target.pose.position.x, target.pose.position.y, target.pose.position.z = state.positions[:3]
        target.pose.position.x -= 0.2
        target.pose.orientation.w = 1.0
        answer = sim.move_grasp(name='hand', target=target)
        self.assertEqual(answer.status.code, Status.OK)
        self.assertIn('rate-limited', answer.status.message)
        over = threading.Event()

        def keep_sending():
            publisher = rospy.Publisher(sim.topic('grasp/hand/target'), PoseStamped, queue_size=1)
            while not over.wait(0.02):
                publisher.publish(target)

        sender = threading.Thread(target=keep_sending)
        if stream:
            sender.start()
            publishing = Listener(sim.topic('grasp/hand/target'), PoseStamped)
            publishing.wait()
        sim.steps(100)
        if gap:
            threading.Event().wait(GAP)
        sim.steps(500)  # 5 s of simulated time
        if stream:
            seen = len(publishing.messages)
            publishing.wait(after=seen)
            over.set()
            sender.join(DEADLINE)
            publishing.close()
        state = sim.state('sheet')
        self.assertAlmostEqual(state.positions[0], target.pose.position.x, delta=1e-9)
        return (state.positions, state.velocities), self.saved(sim, name)

    def test_gaps_of_five_seconds_between_messages_leave_no_trace(self):
        at_once = self.driven('at_once', gap=False, stream=False)
        self.assertEqual(at_once, self.driven('later', gap=True, stream=False))
        # The way to a target begins where the hand was when it was sent last, which is saved; the motion is the same.
        self.assertEqual(at_once[0], self.driven('streamed', gap=False, stream=True)[0])


if __name__ == '__main__':
    rospy.init_node('same_bits_test')
    rostest.rosrun('deformable_sim', 'same_bits', SameBits)
