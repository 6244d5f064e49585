#!/usr/bin/env python3
"""Starting, stopping, and a master that goes away: the node as a process."""

import os
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest
import xmlrpc.client

import roslib.packages
import rospy
import rostest

from support import DEADLINE, SimStatus, Simulation, Status, wait_until

SCENE = '/test/ros/scenes/hanging.yaml'
REFUSED = 2


class Processes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.executable = roslib.packages.find_node('deformable_sim', 'sim_node')[0]
        cls.scene = roslib.packages.get_pkg_dir('deformable_sim') + SCENE

    def setUp(self):
        self.processes = []

    def tearDown(self):
        for process in self.processes:
            if process.poll() is None:
                process.kill()
            process.communicate()

    def start(self, *arguments, master=None):
        environment = dict(os.environ)
        if master:
            environment['ROS_MASTER_URI'] = master
        process = subprocess.Popen([self.executable, *arguments], env=environment, stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, text=True)
        self.processes.append(process)
        return process

    def start_master(self, port):
        process = subprocess.Popen(['rosmaster', '--core', '-p', str(port)], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        self.processes.append(process)
        wait_until(lambda: self.master_answers(port), 'a master')
        return process

    @staticmethod
    def master_answers(port):
        try:
            return xmlrpc.client.ServerProxy('http://localhost:%d' % port).getPid('/test')[0] == 1
        except OSError:
            return False

    @staticmethod
    def free_port():
        with socket.socket() as probe:
            probe.bind(('localhost', 0))
            return probe.getsockname()[1]

    def interrupt(self, process):
        process.send_signal(signal.SIGINT)
        output, _ = process.communicate(timeout=DEADLINE)
        return process.returncode, output

    # --- refused at start ---

    def test_bad_parameters_and_scenes_end_the_start_with_a_reason(self):
        with tempfile.TemporaryDirectory() as directory:
            broken = os.path.join(directory, 'broken.yaml')
            with open(broken, 'w') as file:
                file.write('title: broken\nbodies:\n  - cloth: {name: a, no_such_key: 1}\n')
            empty = os.path.join(directory, 'empty.yaml')
            with open(empty, 'w') as file:
                file.write('')
            good = '_scene:=' + self.scene
            for arguments, word in (([], '~scene'), (['_scene:=no_such_scene'], 'no_such_scene'),
                                    (['_scene:=/no/such/file.yaml'], '/no/such/file.yaml'),
                                    (['_scene:=' + broken], broken + ':3'), (['_scene:=' + empty], empty),
                                    (['_scene:=5'], '~scene'), ([good, '_clock:=sundial'], 'real_time'),
                                    ([good, '_rate_points:=-1'], '~rate_points'),
                                    ([good, '_tf_timeout:=0'], '~tf_timeout'),
                                    ([good, '_start_paused:=maybe'], '~start_paused'),
                                    ([good, '_threads:=0'], '~threads'), ([good, '_priority:=100'], '~priority'),
                                    ([good, '_priority:=5', '_clock:=on_demand'], 'real_time alone'), ([good, '_cameras:=5'], '~cameras'),
                                    ([good, '_frame_id:=/map'], '~frame_id')):
                with self.subTest(arguments=arguments):
                    process = self.start(*arguments, '__name:=refused')
                    output, _ = process.communicate(timeout=DEADLINE)
                    self.assertEqual(process.returncode, REFUSED, output)
                    self.assertIn(word, output)
                    self.assertIn('FATAL', output)
                    if rospy.has_param('/refused'):
                        rospy.delete_param('/refused')

    def test_a_second_clock_is_refused(self):
        first = self.start('_scene:=' + self.scene, '_clock:=on_demand', '_publish_clock:=true', '__name:=first_clock')
        wait_until(lambda: '/clock' in dict(rospy.get_published_topics()), '/clock')
        second = self.start('_scene:=' + self.scene, '_publish_clock:=true', '__name:=second_clock')
        output, _ = second.communicate(timeout=DEADLINE)
        self.assertEqual(second.returncode, REFUSED)
        self.assertIn('/first_clock', output)
        self.assertEqual(self.interrupt(first)[0], 0)

    def test_unknown_parameters_are_named(self):
        process = self.start('_scene:=' + self.scene, '_rate_ponits:=5', '__name:=typing_mistake')
        Simulation('typing_mistake')
        code, output = self.interrupt(process)
        self.assertEqual(code, 0)
        self.assertIn('~rate_ponits', output)

    # --- interrupted ---

    def test_an_interrupt_ends_the_wait_for_a_master(self):
        process = self.start('_scene:=' + self.scene, master='http://localhost:%d' % self.free_port())
        line = process.stdout.readline()
        self.assertIn('master', line)
        self.assertEqual(self.interrupt(process)[0], -signal.SIGINT)

    def test_an_interrupt_ends_a_running_node(self):
        for name, arguments in (('running', []), ('fast', ['_clock:=as_fast_as_possible']),
                                ('paused', ['_start_paused:=true']), ('demanded', ['_clock:=on_demand'])):
            with self.subTest(name=name):
                process = self.start('_scene:=' + self.scene, '__name:=' + name, *arguments)
                Simulation(name)
                self.assertEqual(self.interrupt(process)[0], 0)

    def test_an_interrupt_ends_a_node_that_loads(self):
        with tempfile.NamedTemporaryFile('w', suffix='.yaml') as big:
            big.write('bodies:\n  - cloth: {name: big, size: [4, 4], cells: [400, 400]}\n')
            big.flush()
            process = self.start('_scene:=' + big.name, '__name:=loading')
            wait_until(lambda: rospy.has_param('/loading/scene'), 'the node to begin')
            self.assertIn(self.interrupt(process)[0], (0, -signal.SIGINT))

    def test_an_interrupt_answers_a_client_that_waits_for_steps(self):
        process = self.start('_scene:=' + self.scene, '_clock:=on_demand', '__name:=stepping')
        sim = Simulation('stepping')
        answers = []

        def step():
            try:
                answers.append(sim.step(steps=1000000).status.code)
            except rospy.ServiceException as error:
                answers.append(error)

        client = threading.Thread(target=step)
        client.start()
        wait_until(lambda: float(sim.description('time').split()[0]) > 0.0, 'the steps to begin')
        self.assertEqual(sim.step(steps=1).status.code, Status.UNAVAILABLE)
        self.assertEqual(self.interrupt(process)[0], 0)
        client.join(DEADLINE)
        self.assertEqual(len(answers), 1)

    # --- trouble while running ---

    def test_a_scene_that_diverges_stops_on_its_last_good_state(self):
        with tempfile.NamedTemporaryFile('w', suffix='.yaml') as wild:
            wild.write('bodies:\n  - soft: {name: block, law: neo_hookean, box: {size: [0.1, 0.1, 0.1], cells: [1, 1, 1]}, '
                       'pins: [face_z1]}\n')
            wild.flush()
            self.start('_scene:=' + wild.name, '__name:=wild')
            sim = Simulation('wild')
            status = sim.listen('status', SimStatus)
            status.wait()
            # Inside out, where this law has no energy: nothing can step it.
            state = sim.state('block')
            state.positions = [-x if k % 3 == 0 else x for k, x in enumerate(state.positions)]
            self.assertEqual(sim.set_state(state).status.code, Status.OK)
            status.wait(lambda m: m.paused and any('last good state' in w for w in m.warnings))
            self.assertTrue(all(abs(x) < float('inf') for x in sim.state('block').positions))
            self.assertFalse(sim.pause(False).success)
            self.assertTrue(sim.pause(True).success)
            self.assertTrue(sim.reset().success)
            self.assertEqual(sim.description('state'), 'paused')
            self.assertEqual(sim.load_scene(file=self.scene).status.code, Status.OK)
            self.assertTrue(sim.pause(False).success)
            status.wait(lambda m: not m.paused and not m.warnings, after=len(status.messages))

    def test_a_master_that_was_restarted_knows_the_node_again(self):
        self.restart_the_master_of(self.scene)

    def test_a_master_that_was_restarted_knows_a_node_whose_grasps_come_and_go(self):
        # Each is a topic that is registered with whatever master there is, and leaves no second without news.
        with tempfile.NamedTemporaryFile('w', suffix='.yaml') as busy, open(self.scene) as quiet:
            busy.write(quiet.read() + 'script:\n')
            for i in range(300):
                grasp = 'grasp: {name: busy, body: sheet, select: {feature: corner_0}}'
                busy.write('  - {at: %g, %s}\n' % (0.3 * i, 'release: busy' if i % 2 else grasp))
            busy.flush()
            self.restart_the_master_of(busy.name)

    def restart_the_master_of(self, scene):
        port = self.free_port()
        uri = 'http://localhost:%d' % port
        master = self.start_master(port)
        node = self.start('_scene:=' + scene, master=uri)
        api = xmlrpc.client.ServerProxy(uri)

        def registered():
            publishers, subscribers, services = api.getSystemState('/test')[2]
            return tuple({name for name, nodes in names if '/deformable_sim' in nodes and '/busy/' not in name}
                         for names in (publishers, subscribers, services))

        everything = ('/deformable_sim/grasp/pin_line_end_0/wrench', '/deformable_sim/grasp/pin_line_end_0/target',
                      '/deformable_sim/step')

        def complete():
            return all(name in names for name, names in zip(everything, registered()))

        def settled():
            """What is registered once nothing has been added for a second."""
            seen = registered()
            time.sleep(1.0)
            return complete() and registered() == seen

        wait_until(settled, 'registration')
        before = registered()
        master.kill()
        master.wait()
        self.assertIsNone(node.poll())
        self.start_master(port)
        try:
            wait_until(lambda: registered() == before, 'registration with the new master')
        except AssertionError as error:
            raise AssertionError('%s; missing %s, new %s' % (
                error, [b - r for b, r in zip(before, registered())], [r - b for b, r in zip(before, registered())]))
        environment = dict(os.environ, ROS_MASTER_URI=uri)
        for command in (['rosservice', 'call', '/deformable_sim/describe'],
                        ['rostopic', 'echo', '-n', '1', '/deformable_sim/status/time']):
            output = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=DEADLINE)
            self.assertEqual(output.returncode, 0, output.stderr)
        code, output = self.interrupt(node)
        self.assertEqual(code, 0, output)


if __name__ == '__main__':
    rospy.init_node('process_test')
    rostest.rosrun('deformable_sim', 'process', Processes)
