#!/usr/bin/env python3
"""The Python package deformable_sim: the client, and the environment in lock-step."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import unittest

import numpy
import rosgraph
import roslib.packages
import rospy
import rostest
from sensor_msgs.msg import PointCloud2, PointField

import deformable_sim
from deformable_sim import Environment, Grasp, MoveTo, Refused, Release, Simulation, TimedOut, Unreachable, feature
from deformable_sim.msg import GraspStateArray, RolloutPlan, Status
from deformable_sim.service import Service
from deformable_sim.srv import Step, StepRequest
from deformable_sim.state import state_to_message
from visualization_msgs.msg import MarkerArray

from python_episode import play, shake
from support import DEADLINE, wait_until

HERE = os.path.dirname(os.path.abspath(__file__))
SCENE = os.path.join(HERE, 'scenes', 'hanging.yaml')


class Client(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sim = Simulation(timeout=DEADLINE, wait=DEADLINE)
        cls.executable = roslib.packages.find_node('deformable_sim', 'sim_node')[0]

    def setUp(self):
        self.processes = []
        self.sim.load_scene(SCENE)

    def tearDown(self):
        for process in self.processes:
            process.kill()
            process.wait()

    def start(self, name, *parameters):
        process = subprocess.Popen([self.executable, '__name:=' + name, '_scene:=' + SCENE, *parameters],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.processes.append(process)
        return process

    @staticmethod
    def step_or_none(sim):
        """The time after one step; None while the node makes those of another call."""
        try:
            return sim.step()
        except Refused as refusal:
            if refusal.code != Status.UNAVAILABLE:
                raise
            return None

    def refused(self, code, word, call):
        """`call` is refused with that code and a message with that word."""
        with self.assertRaises(Refused) as caught:
            call()
        self.assertEqual(caught.exception.code, code, caught.exception)
        self.assertIn(word, caught.exception.message)
        return caught.exception

    # The client.

    def test_it_says_what_there_is(self):
        self.assertEqual([(b.name, b.kind, b.nodes) for b in self.sim.bodies()],
                         [('sheet', 'cloth', 99), ('line', 'rope', 11)])
        self.assertEqual(self.sim.dt(), 0.01)
        self.sim.step(7)
        self.assertAlmostEqual(self.sim.time(), 0.07, delta=1e-12)
        status = self.sim.status()
        self.assertAlmostEqual(status.time, 0.07, delta=1e-12)

    def test_steps_are_counted_or_timed(self):
        self.assertAlmostEqual(self.sim.step(), 0.01, delta=1e-12)
        self.assertAlmostEqual(self.sim.step(4), 0.05, delta=1e-12)
        self.assertAlmostEqual(self.sim.step(seconds=0.2), 0.25, delta=1e-12)
        self.sim.reset()
        self.assertEqual(self.sim.time(), 0.0)

    def test_a_state_goes_out_and_comes_back_to_the_bit(self):
        self.sim.step(10)
        state = self.sim.get_state('sheet')
        self.assertEqual((state.positions.shape, state.positions.dtype), ((99, 3), numpy.float64))
        self.assertEqual(state.stamp.to_sec(), 0.1)
        moved = state.positions + [0.0, 0.0, 0.001 / 3.0]
        self.sim.set_state('sheet', moved, state.velocities)
        after = self.sim.get_state('sheet')
        self.assertEqual(after.positions.tobytes(), moved.tobytes())
        self.assertEqual(after.velocities.tobytes(), state.velocities.tobytes())
        self.sim.set_state('sheet', moved)
        self.assertFalse(self.sim.get_state('sheet').velocities.any())

    def test_a_saved_simulation_goes_on_to_the_same_bits(self):
        self.sim.step(10)
        self.assertAlmostEqual(self.sim.save('here'), 0.1, delta=1e-12)
        self.sim.step(5)
        first = self.sim.get_state('sheet')
        self.assertAlmostEqual(self.sim.restore('here'), 0.1, delta=1e-12)
        self.sim.step(5)
        self.assertEqual(self.sim.get_state('sheet').positions.tobytes(), first.positions.tobytes())

    def test_a_grasp_takes_the_nearest_node_and_carries_it(self):
        start = self.sim.get_state('sheet')
        point = start.positions[0] + [0.003, 0.0, -0.004]
        self.assertEqual(start.nearest_node(point), 0)
        self.assertEqual(self.sim.grasp_nearest('hand', 'sheet', point), 0)
        self.assertEqual(self.sim.move_grasp('hand', start.positions[0] + [0.1, 0.0, 0.0], duration=0.5), '')
        self.assertIn('rate-limited', self.sim.move_grasp('hand', start.positions[0] + [0.1, 0.0, 0.0], duration=0.01))
        self.sim.step(seconds=0.6)
        held = self.sim.get_state('sheet').positions[0]
        numpy.testing.assert_allclose(held, start.positions[0] + [0.1, 0.0, 0.0], atol=1e-9)
        self.sim.release('hand')
        self.sim.step(seconds=0.6)
        self.assertGreater(numpy.linalg.norm(self.sim.get_state('sheet').positions[0] - held), 0.02)

    def test_grasps_by_every_selection(self):
        positions = self.sim.get_state('sheet').positions
        for selection, expected in ((deformable_sim.nodes([3, 5]), {3, 5}), (feature('corner_1'), {10}),
                                    (deformable_sim.all_within(positions[5], 0.031), {4, 5, 6}),
                                    (deformable_sim.in_box(positions[5], [0.07, 0.01, 0.01]), {4, 5, 6})):
            with self.subTest(expected=expected):
                self.assertEqual(set(self.sim.grasp('hand', 'sheet', selection)), expected)
                self.sim.release('hand')

    def test_obstacles_come_and_go(self):
        self.sim.add_sphere('ball', 0.1, [0.0, 1.2, 0.2])
        distance = self.sim.distance('line', ['ball'])
        self.assertEqual(distance.obstacle, 'ball')
        near = distance.distance
        self.sim.let_through('ball', ['line'])
        self.sim.remove_obstacle('ball')
        self.sim.add_box('ball', [0.1, 0.1, 0.1], [0.0, 1.2, 0.1])
        self.assertGreater(self.sim.distance('line', ['ball']).distance, near)
        self.refused(Status.ALREADY_EXISTS, 'ball', lambda: self.sim.add_box('ball', [1, 1, 1], [5, 5, 5]))

    def test_every_refusal_is_an_exception_and_changes_nothing(self):
        self.sim.step(3)
        before = Environment(self.sim).observe().digest()
        nan = float('nan')
        for code, word, call in (
                (Status.NOT_FOUND, 'nobody', lambda: self.sim.get_state('nobody')),
                (Status.NOT_FOUND, 'nobody', lambda: self.sim.release('nobody')),
                (Status.NOT_FOUND, 'within 0.02 m', lambda: self.sim.grasp_nearest('hand', 'sheet', [9, 9, 9])),
                (Status.NOT_FOUND, 'nothing', lambda: self.sim.restore('nothing')),
                (Status.NOT_FOUND, 'nothing', lambda: self.sim.remove_obstacle('nothing')),
                (Status.INVALID_ARGUMENT, 'finite', lambda: self.sim.move_grasp('pin_line_end_0', [nan, 0, 0])),
                (Status.INVALID_ARGUMENT, 'needs', lambda: self.sim.set_state('line', numpy.zeros((3, 3)))),
                (Status.INVALID_ARGUMENT, 'bodies', lambda: self.sim.load_scene(yaml='bodies: 3')),
                (Status.OUT_OF_RANGE, '1000000', lambda: self.sim.step(2000000)),
                (Status.UNAVAILABLE, 'no tf', lambda: self.sim.grasp_nearest('hand', 'sheet', [0, 0, 0], frame_id='no_tf'))):
            with self.subTest(word=word):
                error = self.refused(code, word if word != 'no tf' else 'no_tf', call)
                self.assertIn(error.code_name, str(error))
                self.assertIn('/deformable_sim/', str(error))
        self.assertEqual(Environment(self.sim).observe().digest(), before)

    def test_arrays_of_the_wrong_shape_are_not_sent(self):
        for positions, velocities in ((numpy.zeros(33), None), (numpy.zeros((11, 2)), None),
                                      (numpy.zeros((11, 3)), numpy.zeros(33))):
            with self.assertRaisesRegex(ValueError, 'n x 3'):
                state_to_message('line', positions, velocities)

    def test_values_of_the_wrong_kind_are_not_sent(self):
        nan = float('nan')
        self.sim.step(3)
        before = Environment(self.sim).observe().digest()
        for error, word, call in (
                (ValueError, 'unsigned', lambda: self.sim.step(-1)),
                (ValueError, 'unsigned', lambda: self.sim.step(1.5)),
                (ValueError, 'body', lambda: self.sim.get_state(3)),
                (ValueError, 'selection|method', lambda: self.sim.grasp('hand', 'sheet', 'corner_0')),
                (ValueError, 'position: .* 3 numbers', lambda: self.sim.move_grasp('hand', [1, 2])),
                (ValueError, 'position: None', lambda: self.sim.move_grasp('hand', None)),
                (ValueError, '4 numbers', lambda: self.sim.move_grasp('hand', [1, 2, 3], [0, 0, 1])),
                (ValueError, 'duration: nan', lambda: self.sim.move_grasp('hand', [1, 2, 3], duration=nan)),
                (ValueError, 'duration', lambda: self.sim.move_grasp('hand', [1, 2, 3], duration=1e12)),
                (ValueError, 'size', lambda: deformable_sim.in_box([0, 0, 0], [1, 1])),
                (ValueError, 'from 0', lambda: deformable_sim.nodes([4, -1])),
                (TypeError, 'integer', lambda: deformable_sim.nodes([1.5]))):
            with self.subTest(word=word):
                with self.assertRaisesRegex(error, word):
                    call()
        self.assertEqual(Environment(self.sim).observe().digest(), before)

    def test_topics_without_a_header_are_refused(self):
        with self.assertRaisesRegex(TypeError, 'no header'):
            self.sim.listen('markers', MarkerArray)

    def test_clouds_with_padded_rows_become_arrays(self):
        # Two rows of two points of 6 bytes, and 4 bytes after each row.
        cloud = PointCloud2(height=2, width=2, point_step=6, row_step=16, is_bigendian=True,
                            fields=[PointField('a', 0, PointField.UINT16, 1), PointField('b', 2, PointField.FLOAT32, 1)])
        rows = [[(1, 0.5), (2, 1.5)], [(3, -1.0), (4, 8.0)]]
        cloud.data = b''.join(numpy.array(row, dtype='>u2,>f4').tobytes() + b'\xff' * 4 for row in rows)
        array = deformable_sim.cloud_array(cloud)
        self.assertEqual(array['a'].tolist(), [[1, 2], [3, 4]])
        self.assertEqual(array['b'].tolist(), [[0.5, 1.5], [-1.0, 8.0]])

    # Peers that go away.

    def test_a_node_that_was_killed_is_unreachable_and_found_again(self):
        process = self.start('mortal', '_clock:=on_demand')
        sim = Simulation('mortal', timeout=DEADLINE, wait=DEADLINE)
        self.assertAlmostEqual(sim.step(2), 0.02, delta=1e-12)
        process.kill()
        process.wait()
        with self.assertRaises(Unreachable):
            sim.step()
        self.start('mortal', '_clock:=on_demand')

        def again():
            try:
                return sim.step()
            except Unreachable:
                return None

        self.assertAlmostEqual(wait_until(again, 'the new node'), 0.01, delta=1e-12)

    def test_a_node_killed_during_a_call_is_unreachable(self):
        process = self.start('mortal', '_clock:=on_demand')
        sim = Simulation('mortal', timeout=DEADLINE, wait=DEADLINE)
        sim.step()
        process.send_signal(signal.SIGSTOP)  # the call is under way when it dies
        killer = subprocess.Popen(['/bin/sh', '-c', 'sleep 0.5; kill -KILL %d' % process.pid])
        with self.assertRaisesRegex(Unreachable, 'went away'):
            sim.step()
        killer.wait()

    def test_a_node_that_hangs_times_out_and_its_late_answer_is_not_taken_for_another(self):
        process = self.start('sleeper', '_clock:=on_demand')
        sim = Simulation('sleeper', timeout=DEADLINE, wait=DEADLINE)
        sim.step()
        process.send_signal(signal.SIGSTOP)
        for name, call in (('step', lambda: sim.step(3, timeout=0.3)), ('describe', lambda: sim.describe())):
            sim.timeout = 0.3
            with self.assertRaisesRegex(TimedOut, '/sleeper/%s: no answer within 0.3 s' % name):
                call()
        sim.timeout = DEADLINE
        process.send_signal(signal.SIGCONT)
        self.assertIn('body', sim.describe())
        # roscpp drops a request whose caller has gone before it was looked at: three steps are made, or none.
        after = wait_until(lambda: self.step_or_none(sim), 'a step')
        self.assertIn(round(after, 9), (0.02, 0.05))

    def test_steps_that_timed_out_go_on_and_keep_others_away_until_a_reset(self):
        with self.assertRaisesRegex(TimedOut, 'no answer within 0.2 s'):
            self.sim.step(1000000, timeout=0.2)
        self.refused(Status.UNAVAILABLE, 'another ~step', self.sim.step)
        self.sim.reset()
        self.assertEqual(self.sim.time(), 0.0)
        self.assertAlmostEqual(wait_until(lambda: self.step_or_none(self.sim), 'a step'), 0.01, delta=1e-12)

    def test_a_program_that_is_told_to_stop_stops_waiting(self):
        for what, code in (('/deformable_sim/step', 'sim.step(1000000, timeout=1000)'),
                           ('/deformable_sim/grasps', 'sim.listen("grasps", GraspStateArray).at(rospy.Time(9999), 1000)')):
            for how in (signal.SIGINT, signal.SIGTERM):
                with self.subTest(what=what, how=how):
                    child = subprocess.Popen(
                        [sys.executable, '-c', 'import rospy, signal, deformable_sim\n'
                         'from deformable_sim.msg import GraspStateArray\n'
                         'signal.signal(signal.SIGINT, signal.default_int_handler)\n'
                         'sim = deformable_sim.connect("child")\nsim.reset()\nprint("ready", flush=True)\n' + code],
                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True)
                    self.processes.append(child)
                    self.assertEqual(child.stdout.readline(), 'ready\n')
                    # In the midst of making a subscriber rospy's own handler may wait for a lock that this thread has.
                    time.sleep(0.5)
                    child.send_signal(how)
                    _, errors = child.communicate(timeout=DEADLINE)
                    self.assertIn('Interrupted: %s' % what, errors)
                    self.sim.reset()

    def test_bodies_materials_and_what_if(self):
        names = self.sim.add_bodies(yaml='bodies: [{rope: {name: cord, length: 0.3}}]', position=(0.0, 2.0, 1.0))
        self.assertEqual(names, ['cord'])
        self.assertAlmostEqual(self.sim.get_state('cord').positions[:, 1].mean(), 2.0)
        self.sim.set_material('cord', {'damping': 0.01})
        before = self.sim.get_state('cord').positions
        falls = self.sim.rollout([RolloutPlan()], 0.1, with_positions=True)[0]
        self.assertEqual(len(falls.samples), 2)
        fallen = numpy.reshape(falls.samples[-1].bodies[-1].positions, (-1, 3))
        self.assertTrue((fallen[:, 2] < before[:, 2]).all())
        numpy.testing.assert_array_equal(self.sim.get_state('cord').positions, before)
        with self.assertRaisesRegex(Refused, 'damping'):
            self.sim.set_material('cord', {'damping': -1})
        self.sim.remove_body('cord')
        self.assertNotIn('cord', [body.name for body in self.sim.bodies()])

    def test_two_clients_at_once_never_mix_their_steps(self):
        # Each step is made and answered once, or refused: the time is that of the steps that were answered.
        made, other = [], Simulation(timeout=DEADLINE, wait=DEADLINE)

        def work(sim):
            for _ in range(100):
                made.append(self.step_or_none(sim))

        threads = [threading.Thread(target=work, args=(sim,)) for sim in (self.sim, other)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(DEADLINE)
        self.assertEqual(len(made), 200)
        times = sorted(time for time in made if time is not None)
        numpy.testing.assert_allclose(times, 0.01 * numpy.arange(1, len(times) + 1), rtol=0.0, atol=1e-9)
        self.assertAlmostEqual(self.sim.time(), times[-1], delta=1e-5)

    def test_a_closed_client_opens_again_and_a_closed_environment_does_not(self):
        sim = Simulation(timeout=DEADLINE, wait=DEADLINE)
        environment = Environment(sim, topics={'grasps': GraspStateArray})
        environment.reset()
        environment.close()
        for call in (environment.reset, environment.step, environment.observe):
            with self.assertRaisesRegex(RuntimeError, 'closed'):
                call()
        sim.close()
        self.assertAlmostEqual(sim.time(), 0.01, delta=1e-12)

    def test_what_is_no_ros_node_is_unreachable(self):
        # A program on the port where a node was registered: it answers, but not as a service does.
        with socket.socket() as listener:
            listener.bind(('127.0.0.1', 0))
            listener.listen()
            listener.settimeout(DEADLINE)
            name = '/impostor/step'
            master = rosgraph.Master('/impostor')  # not its own name: the master would have this program stopped
            address = 'rosrpc://127.0.0.1:%d' % listener.getsockname()[1]
            master.registerService(name, address, 'http://127.0.0.1:1/')

            def answer():
                with listener.accept()[0] as peer:
                    peer.recv(4096)
                    peer.sendall(b'\x04\x00\x00\x00HTTP')

            thread = threading.Thread(target=answer)
            thread.start()
            try:
                with self.assertRaisesRegex(Unreachable, 'no ROS service'):
                    Service(name, Step)(StepRequest(), DEADLINE)
            finally:
                thread.join(DEADLINE)
                master.unregisterService(name, address)

    def test_without_a_node_or_a_master_it_says_what_to_start(self):
        with self.assertRaisesRegex(Unreachable, 'roslaunch deformable_sim'):
            Simulation('nobody', wait=0.1)
        child = subprocess.run([sys.executable, '-c', 'import deformable_sim; deformable_sim.connect("x", wait=0.1)'],
                               env=dict(os.environ, ROS_MASTER_URI='http://localhost:9'), stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, universal_newlines=True, timeout=DEADLINE)
        self.assertNotEqual(child.returncode, 0)
        self.assertIn('no ROS master at http://localhost:9', child.stderr)

    # The environment.

    def digests(self, sim, seed=3):
        return [observation.digest() for observation in play(Environment(sim, steps=5, prepare=shake), seed)]

    def test_the_same_seed_and_actions_give_the_same_bits(self):
        environment = Environment(self.sim, steps=5, prepare=shake)
        first = [observation.digest() for observation in play(environment, 3)]
        self.assertEqual(len(set(first)), 7)
        self.assertEqual(first, [observation.digest() for observation in play(environment, 3)])
        other = [observation.digest() for observation in play(environment, 4)]
        self.assertTrue(set(first).isdisjoint(other))

    def test_another_node_with_another_clock_gives_the_same_bits(self):
        self.start('hurried', '_clock:=as_fast_as_possible')
        hurried = Simulation('hurried', timeout=DEADLINE, wait=DEADLINE)
        wait_until(lambda: hurried.time() > 0.1, 'time to pass')
        self.assertEqual(self.digests(self.sim), self.digests(hurried))

    def test_the_clock_of_the_system_gives_the_same_bits_and_stands_at_the_observation(self):
        expected = self.digests(self.sim)
        rospy.set_param('/use_sim_time', True)
        try:
            self.start('clocked', '_clock:=on_demand', '_publish_clock:=true')
            child = subprocess.run([sys.executable, os.path.join(HERE, 'python_episode.py'), 'clocked'],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True,
                                   timeout=3 * DEADLINE)
        finally:
            rospy.set_param('/use_sim_time', False)
        self.assertEqual(child.returncode, 0, child.stderr)
        for episode in json.loads(child.stdout):
            self.assertEqual(episode['digests'], expected)
            self.assertEqual(len(episode['clock']), 6)
            numpy.testing.assert_allclose(episode['clock'], episode['times'][1:], rtol=0.0, atol=2e-9)

    def test_observations_have_the_messages_of_their_step(self):
        environment = Environment(self.sim, steps=2, bodies=['sheet'],
                                  topics={'sheet/points': PointCloud2, 'grasps': GraspStateArray})
        seen = []
        for _ in range(2):
            observations = [environment.reset()]
            for i in range(4):
                action = {'left': Grasp('sheet', feature('corner_0'))} if i == 0 else {}
                observations.append(environment.step(action)[0])
            self.assertEqual([o.time for o in observations], [0.01, 0.03, 0.05, 0.07, 0.09])
            for observation in observations:
                state = observation.states['sheet']
                for message in observation.messages.values():
                    self.assertEqual(message.header.stamp, state.stamp)
                cloud = deformable_sim.cloud_array(observation.messages['sheet/points'])
                self.assertEqual(cloud.shape, (9, 11))
                self.assertEqual(cloud['z'].ravel().tolist(), state.positions[:, 2].astype(numpy.float32).tolist())
                self.assertEqual('left' in [g.name for g in observation.messages['grasps'].grasps],
                                 'left' in observation.held)
            seen.append([str(o.messages['grasps'].grasps) for o in observations])
        environment.close()
        self.assertEqual([line.replace('seq', '') for line in seen[0]], [line.replace('seq', '') for line in seen[1]])

    def test_reward_and_end_are_those_given(self):
        environment = Environment(self.sim, steps=1, bodies=['line'],
                                  reward=lambda observation: observation.states['line'].center[2],
                                  done=lambda observation: observation.time > 0.025)
        environment.reset()
        results = [environment.step() for _ in range(3)]
        self.assertEqual([done for _, _, done, _ in results], [False, False, True])
        for observation, reward, _, _ in results:
            self.assertEqual(reward, observation.states['line'].positions.mean(axis=0)[2])

    def test_what_a_gripper_cannot_do_is_said_and_the_rest_is_done(self):
        environment = Environment(self.sim, steps=1)
        environment.reset()
        observation, _, _, info = environment.step({
            'left': [Grasp('sheet', deformable_sim.nearest([9, 9, 9])), MoveTo([0, 0, 0])],
            'right': [Grasp('line', feature('end_1')), MoveTo([0, 5, 1])]})
        self.assertEqual([(name, error.code) for name, error in info['refused']],
                         [('left', Status.NOT_FOUND), ('left', Status.NOT_FOUND)])
        self.assertEqual([name for name, _ in info['notes']], ['right'])
        self.assertEqual(observation.held, {'right': (10,)})
        self.assertEqual(observation.time, 0.01)
        self.assertEqual(environment.step({'right': Release()})[0].held, {})
        with self.assertRaises(ValueError):
            Environment(self.sim, steps=0)
        with self.assertRaises(ValueError):
            Environment(self.sim, settle=-1)

    def test_an_action_with_a_mistake_in_it_is_not_begun(self):
        environment = Environment(self.sim, steps=1)
        before = environment.reset().digest()
        good = Grasp('line', feature('end_1'))
        for error, word, action in ((KeyError, 'third', {'left': good, 'third': Release()}),
                                    (TypeError, 'release', {'left': good, 'right': ['release']}),
                                    (TypeError, 'None', {'left': good, 'right': None}),
                                    (TypeError, 'mapping', [good])):
            with self.subTest(word=word):
                with self.assertRaisesRegex(error, word):
                    environment.step(action)
                self.assertEqual(environment.observe().digest(), before)
                self.assertFalse([g for g in self.sim.describe()['grasp'] if g.startswith('left')])
        for error, make in ((ValueError, lambda: MoveTo([0, 0])), (ValueError, lambda: MoveTo([0, 0, 'x'])),
                            (ValueError, lambda: MoveTo([0, 0, 1], duration=float('nan'))),
                            (TypeError, lambda: Grasp('line', 'end_1')), (TypeError, lambda: Grasp(3, feature('end_1')))):
            with self.assertRaises(error):
                make()
        # Values that a policy may come to: the node refuses them, and time passes.
        observation, _, _, info = environment.step({'left': [good, MoveTo([float('nan'), 0, 0])],
                                                    'right': Grasp('nobody', feature('end_1'))})
        self.assertEqual([(name, error.code) for name, error in info['refused']],
                         [('left', Status.INVALID_ARGUMENT), ('right', Status.NOT_FOUND)])
        self.assertEqual(observation.time, 0.01)
        self.assertTrue(numpy.isfinite(observation.states['line'].positions).all())
        with self.assertRaisesRegex(Refused, 'nobody'):
            Environment(self.sim, bodies=['nobody']).reset()

    def test_two_resets_give_the_same_bits_whatever_was_done_between(self):
        environment = Environment(self.sim, steps=3, prepare=shake, settle=2)
        first = environment.reset(5).digest()
        self.assertEqual(environment.reset(5).digest(), first)
        environment.step({'left': [Grasp('sheet', feature('corner_0')), MoveTo([1, 1, 1])]})
        self.sim.add_sphere('ball', 0.1, [3.0, 3.0, 3.0])
        self.assertEqual(environment.reset(5).digest(), first)
        self.assertNotEqual(environment.reset(6).digest(), first)

    def test_an_environment_goes_on_with_a_node_that_was_started_anew(self):
        process = self.start('mortal', '_clock:=real_time')
        sim = Simulation('mortal', timeout=DEADLINE, wait=DEADLINE)
        environment = Environment(sim, steps=5, prepare=shake)
        first = [observation.digest() for observation in play(environment, 3)]
        process.kill()
        process.wait()
        with self.assertRaises(Unreachable):
            environment.step()
        self.start('mortal', '_clock:=real_time')

        def again():
            try:
                return [observation.digest() for observation in play(environment, 3)]
            except Unreachable:
                return None

        self.assertEqual(wait_until(again, 'the new node'), first)


if __name__ == '__main__':
    rospy.init_node('python_test')
    rostest.rosrun('deformable_sim', 'python', Client)
