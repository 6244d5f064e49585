#!/usr/bin/env python3
"""Every service accepts what it should and refuses the rest; a refusal changes nothing."""

import math
import os
import shutil
import tempfile
import unittest

import rospy
import rostest
from geometry_msgs.msg import PoseStamped, TransformStamped
from tf2_msgs.msg import TFMessage

from deformable_sim.msg import GraspCommand, Obstacle
from support import (GraspSelection, Refusals, SimStatus, Simulation, Status, box, feature, nearest, node_position,
                     wait_until)

DT = 0.01
NODES = 11 * 9  # of the sheet


def target(x, y, z, frame=''):
    stamped = PoseStamped()
    stamped.header.frame_id = frame
    stamped.pose.position.x, stamped.pose.position.y, stamped.pose.position.z = x, y, z
    stamped.pose.orientation.w = 1.0
    return stamped


def transform(child, stamp, place):
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id, message.header.stamp = 'world', rospy.Time(stamp)
    message.transform.translation.x, message.transform.translation.y, message.transform.translation.z = place
    message.transform.rotation.w = 1.0
    return message


class Services(Refusals, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sim = Simulation()
        cls.scene = rospy.get_param('/deformable_sim/scene')

    def setUp(self):
        self.assertEqual(self.sim.load_scene(file=self.scene).status.code, Status.OK)
        self.sim.steps(3)

    # --- time ---

    def test_steps_and_seconds_reach_exact_times(self):
        self.assertAlmostEqual(self.sim.steps(7), 10 * DT, delta=1e-12)
        answer = self.sim.step(seconds=0.1)
        self.assertEqual((answer.status.code, answer.steps), (Status.OK, 10))
        self.assertAlmostEqual(answer.time, 20 * DT, delta=1e-12)

    def test_a_step_needs_exactly_one_positive_finite_length(self):
        self.refuse(Status.INVALID_ARGUMENT, 'one of the two', self.sim.step)
        self.refuse(Status.INVALID_ARGUMENT, 'one of the two', lambda: self.sim.step(steps=1, seconds=1.0))
        self.refuse(Status.INVALID_ARGUMENT, 'finite', lambda: self.sim.step(seconds=math.nan))
        self.refuse(Status.OUT_OF_RANGE, '0 or more', lambda: self.sim.step(seconds=-1.0))
        self.refuse(Status.OUT_OF_RANGE, '1000000', lambda: self.sim.step(seconds=1e9))
        self.refuse(Status.OUT_OF_RANGE, '1000000', lambda: self.sim.step(steps=4000000000))

    def test_pause_and_reset_answer(self):
        self.assertTrue(self.sim.pause(True).success)
        self.sim.steps(1)
        self.assertTrue(self.sim.pause(False).success)
        self.assertTrue(self.sim.reset().success)
        self.assertEqual(self.sim.description('time'), '0 s')

    def test_after_a_reset_the_same_steps_give_the_same_bits(self):
        self.sim.reset()
        start = self.sim.everything()
        self.sim.steps(5)
        first = self.sim.everything()
        self.assertNotEqual(start, first)
        self.sim.reset()
        self.assertEqual(start, self.sim.everything())
        self.sim.steps(5)
        self.assertEqual(first, self.sim.everything())

    # --- grasps ---

    def test_after_a_reset_frames_are_seen_though_their_clock_was_set_back(self):
        # tf takes nothing 10 s older than what it has: not even one late transform of before may be left.
        frames = rospy.Publisher('/tf', TFMessage, queue_size=100)
        corners = [node_position(self.sim.state('sheet'), k) for k in (0, 10)]
        state = self.sim.state('sheet')

        def taken(corner, stamps):
            """The node grasped where the frame is said to be."""
            wanted = (corners.index(corner) * 10,)

            def grasped():
                stamps[0] += 0.1
                frames.publish(TFMessage([transform('set_back', stamps[0], corner)]))
                answer = self.sim.grasp(name='hand', body='sheet', selection=nearest(0, 0, 0, 'set_back'))
                self.sim.release('hand')
                return tuple(answer.nodes) == wanted

            wait_until(grasped, 'a grasp of node %d' % wanted)

        taken(corners[0], [600.0])
        self.assertTrue(self.sim.reset().success)
        self.sim.set_state(state)
        taken(corners[0], [605.0])  # what was under way
        taken(corners[1], [0.0])

        # ros::Time cannot add to the last of its seconds, and throws.
        last = transform('set_back', 0.0, corners[0])
        last.header.stamp = rospy.Time(2**32 - 1)
        for _ in range(2):
            frames.publish(TFMessage([last]))
        taken(corners[0], [20.0])

    def test_a_grasp_finds_its_nodes_in_five_ways(self):
        at = node_position(self.sim.state('sheet'), 40)
        by_nodes = GraspSelection(method=GraspSelection.NODES, nodes=[3, 5])
        by_radius = nearest(*at, radius=0.035)
        by_radius.method = GraspSelection.RADIUS
        by_box = nearest(*at)
        by_box.method = GraspSelection.BOX
        by_box.size.x = by_box.size.y = by_box.size.z = 0.02
        for name, selection, nodes in (('a', nearest(*at), {40}), ('b', by_nodes, {3, 5}), ('c', by_radius, None),
                                       ('d', by_box, {40}), ('e', feature('corner_1'), {10})):
            with self.subTest(name=name):
                answer = self.sim.grasp(name=name, body='sheet', selection=selection)
                self.assertEqual(answer.status.code, Status.OK, answer.status.message)
                if nodes:
                    self.assertEqual(set(answer.nodes), nodes)
                else:
                    self.assertIn(40, answer.nodes)
                    self.assertGreater(len(answer.nodes), 1)
                self.assertEqual(self.sim.release(name=name).status.code, Status.OK)

    def test_a_grasp_that_cannot_be_is_refused(self):
        sim = self.sim
        zero = nearest(0, 0, 1)
        zero.pose.pose.orientation.w = 0.0
        long = nearest(0, 0, 1)
        long.pose.pose.orientation.w = 1.1
        nan_turn = nearest(0, 0, 1)
        nan_turn.pose.pose.orientation.x = math.nan
        bad = [
            (Status.INVALID_ARGUMENT, 'finite', dict(selection=nearest(math.nan, 0, 1))),
            (Status.INVALID_ARGUMENT, 'finite', dict(selection=nearest(0, math.inf, 1))),
            (Status.OUT_OF_RANGE, '1e6', dict(selection=nearest(1e9, 0, 1))),
            (Status.INVALID_ARGUMENT, 'finite', dict(selection=nan_turn)),
            (Status.INVALID_ARGUMENT, 'all zero', dict(selection=zero)),
            (Status.INVALID_ARGUMENT, 'norm', dict(selection=long)),
            (Status.UNAVAILABLE, 'no_such_frame', dict(selection=nearest(0, 0, 1, frame='no_such_frame'))),
            (Status.UNAVAILABLE, 'no_such_frame', dict(selection=feature('corner_0'), follow_frame='no_such_frame')),
            (Status.NOT_FOUND, '', dict(selection=nearest(100, 0, 1))),
            (None, '999999', dict(selection=GraspSelection(method=GraspSelection.NODES, nodes=[999999]))),
            (Status.OUT_OF_RANGE, 'range',
             dict(selection=GraspSelection(method=GraspSelection.NODES, nodes=[2**32 - 1]))),
            (None, '', dict(selection=GraspSelection(method=GraspSelection.NODES))),
            (None, 'corner_0', dict(selection=feature('no_such_feature'))),
            (Status.INVALID_ARGUMENT, 'method', dict(selection=GraspSelection(method=9))),
            (Status.OUT_OF_RANGE, 'stiffness', dict(selection=feature('corner_0'), stiffness=-1.0)),
            (Status.INVALID_ARGUMENT, 'stiffness', dict(selection=feature('corner_0'), stiffness=math.nan)),
            (Status.OUT_OF_RANGE, 'max_force', dict(selection=feature('corner_0'), max_force=-1.0)),
            (Status.OUT_OF_RANGE, 'max_speed', dict(selection=feature('corner_0'), max_speed=-1.0)),
            (Status.NOT_FOUND, 'sheet', dict(body='nobody', selection=feature('corner_0'))),
            (Status.INVALID_ARGUMENT, 'letter', dict(name='', selection=feature('corner_0'))),
            (Status.INVALID_ARGUMENT, 'letter', dict(name='a/../b c', selection=feature('corner_0'))),
            (Status.INVALID_ARGUMENT, '64', dict(name='a' * 5000, selection=feature('corner_0'))),
            (Status.ALREADY_EXISTS, 'pin_sheet_corner_2',
             dict(name='pin_sheet_corner_2', selection=feature('corner_0'))),
        ]
        before = sim.everything()
        for code, word, arguments in bad:
            with self.subTest(word=word, **{k: str(v)[:60] for k, v in arguments.items()}):
                answer = sim.grasp(**{**dict(name='hand', body='sheet'), **arguments})
                self.assertNotEqual(answer.status.code, Status.OK)
                self.assertNotEqual(answer.status.code, Status.INTERNAL, answer.status.message)
                if code is not None:
                    self.assertEqual(answer.status.code, code, answer.status.message)
                self.assertIn(word, answer.status.message)
                self.assertEqual(list(answer.nodes), [])
        self.assertEqual(before, sim.everything())

    def test_a_moved_grasp_arrives_when_it_should(self):
        # Straight to the target in `duration`: half way at half time.
        answer = self.sim.grasp(name='hand', body='sheet', selection=feature('corner_0'))
        node = answer.nodes[0]
        x, y, z = node_position(self.sim.state('sheet'), node)
        move = target(x, y - 0.02, z)
        answer = self.sim.move_grasp(name='hand', target=move, duration=rospy.Duration(0.2))
        self.assertEqual(answer.status.code, Status.OK)
        self.sim.steps(10)
        self.assertAlmostEqual(node_position(self.sim.state('sheet'), node)[1], y - 0.01, delta=1e-9)
        self.sim.steps(10)
        self.assertAlmostEqual(node_position(self.sim.state('sheet'), node)[1], y - 0.02, delta=1e-9)

    def test_a_command_acts_in_the_next_step(self):
        node = self.sim.grasp(name='hand', body='sheet', selection=feature('corner_0')).nodes[0]
        y = node_position(self.sim.state('sheet'), node)[1]
        x, _, z = node_position(self.sim.state('sheet'), node)
        self.sim.move_grasp(name='hand', target=target(x, y - 0.001, z), duration=rospy.Duration(0.0))
        self.sim.steps(1)
        self.assertLess(node_position(self.sim.state('sheet'), node)[1], y - 1e-4)

    def test_a_ten_metre_jump_is_taken_at_max_speed(self):
        node = self.sim.grasp(name='hand', body='sheet', selection=feature('corner_0'), max_speed=0.5).nodes[0]
        x, y, z = node_position(self.sim.state('sheet'), node)
        answer = self.sim.move_grasp(name='hand', target=target(x, y + 10.0, z))
        self.assertEqual(answer.status.code, Status.OK)
        self.assertIn('0.5', answer.status.message)
        self.sim.steps(4)
        moved = node_position(self.sim.state('sheet'), node)[1] - y
        self.assertAlmostEqual(moved, 4 * DT * 0.5, delta=1e-6)
        self.assertLess(self.sim.state('sheet').max_strain, 0.5)

    def test_bad_moves_are_refused(self):
        hand = 'pin_sheet_corner_2'
        self.refuse(Status.NOT_FOUND, 'nobody', lambda: self.sim.move_grasp(name='nobody', target=target(0, 0, 1)))
        self.refuse(Status.INVALID_ARGUMENT, 'finite',
                    lambda: self.sim.move_grasp(name=hand, target=target(math.nan, 0, 1)))
        self.refuse(Status.UNAVAILABLE, 'no_such_frame',
                    lambda: self.sim.move_grasp(name=hand, target=target(0, 0, 1, 'no_such_frame')))
        self.refuse(Status.OUT_OF_RANGE, 'duration',
                    lambda: self.sim.move_grasp(name=hand, target=target(0, 0, 1), duration=rospy.Duration(-1.0)))

    def test_release_of_one_of_none_and_of_all(self):
        self.refuse(Status.NOT_FOUND, 'nobody', lambda: self.sim.release(name='nobody'))
        self.assertEqual(self.sim.release(name='pin_line_end_0').status.code, Status.OK)
        self.refuse(Status.NOT_FOUND, 'pin_line_end_0', lambda: self.sim.release(name='pin_line_end_0'))
        self.assertEqual(self.sim.release(name='').status.code, Status.OK)
        self.assertEqual(self.sim.everything()[2], [])

    # --- states and scenes ---

    def test_a_state_is_restored_to_the_bit(self):
        saved = self.sim.state('sheet')
        self.sim.steps(10)
        later = self.sim.state('sheet')
        self.assertNotEqual(saved.positions, later.positions)
        self.assertEqual(self.sim.set_state(saved).status.code, Status.OK)
        again = self.sim.state('sheet')
        self.assertEqual((saved.positions, saved.velocities), (again.positions, again.velocities))

    def test_bad_states_are_refused(self):
        def changed(**fields):
            state = self.sim.state('sheet')
            for key, value in fields.items():
                setattr(state, key, value)
            return state

        good = list(self.sim.state('sheet').positions)
        elsewhere = changed()
        elsewhere.header.frame_id = 'map'
        for code, word, state in ((Status.NOT_FOUND, 'sheet', changed(body='nobody')),
                                  (Status.INVALID_ARGUMENT, str(3 * NODES), changed(positions=good[:-1])),
                                  (Status.INVALID_ARGUMENT, str(3 * NODES), changed(velocities=[])),
                                  (Status.INVALID_ARGUMENT, 'finite', changed(positions=[math.nan] + good[1:])),
                                  (Status.INVALID_ARGUMENT, 'finite', changed(velocities=[math.inf] + good[1:])),
                                  (Status.INVALID_ARGUMENT, 'map', elsewhere)):
            with self.subTest(word=word):
                self.refuse(code, word, lambda s=state: self.sim.set_state(s))
        self.refuse(Status.NOT_FOUND, 'sheet', lambda: self.sim.get_state('nobody'))

    def test_states_that_cross_are_refused_with_the_pair(self):
        scene = ('bodies:\n  - cloth: {name: sheet, touches: others, pins: [corner_0]}\n'
                 '  - cloth: {name: line, cells: [19, 17], touches: others, pose: {position: [0, 0, 0.1]}, pins: [corner_0]}\n')
        self.assertEqual(self.sim.load_scene(yaml=scene).status.code, Status.OK)
        state = self.sim.state('line')
        turned = [0.0] * len(state.positions)
        for i in range(0, len(turned), 3):  # upright, through the sheet
            turned[i:i + 3] = [0.003 + state.positions[i], 0.004, state.positions[i + 1]]
        state.positions = turned
        self.refuse(Status.INVALID_ARGUMENT, "'sheet' and 'line' cross near", lambda: self.sim.set_state(state))

    def test_bad_scenes_leave_the_running_one(self):
        text = open(self.scene).read()
        for word, arguments in (('one of the two', {}), ('one of the two', dict(file=self.scene, yaml=text)),
                                ('no_such_scene', dict(file='no_such_scene')),
                                ('/no/such', dict(file='/no/such/file.yaml')),
                                ('', dict(yaml=' ')), ('', dict(yaml=text[:len(text) // 2] + ' {')),
                                ('yaml:', dict(yaml=text + '\nno_such_key: 1\n')),
                                ('stretch_stiffness', dict(yaml=text.replace('cells: [10, 8]',
                                                                             'material: {stretch_stiffness: -5}'))),
                                ('missing.obj', dict(yaml='bodies:\n  - cloth: {name: a, mesh: missing.obj}\n')),
                                ('robot_description', dict(yaml=text + '\nrobot: {}\n'))):
            with self.subTest(word=word):
                before = self.sim.everything()
                answer = self.sim.load_scene(**arguments)
                self.assertNotIn(answer.status.code, (Status.OK, Status.INTERNAL), answer.status.message)
                self.assertIn(word, answer.status.message)
                self.assertEqual(before, self.sim.everything())

    def test_bad_meshes_leave_the_running_scene(self):
        # A vertex that is not there, a face without area, three faces on an edge, faces wound against each other, NaN, half a file.
        data = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'scene', 'data')
        for name in ('missing_vertex.obj', 'degenerate.obj', 'repeated.obj', 'non_manifold.obj', 'winding.obj', 'no_faces.obj',
                     'nan.ply', 'truncated.ply'):
            with self.subTest(mesh=name):
                before = self.sim.everything()
                answer = self.sim.load_scene(
                    yaml='bodies:\n  - cloth: {name: a, mesh: %s}\n' % os.path.join(data, name))
                self.assertNotIn(answer.status.code, (Status.OK, Status.INTERNAL), answer.status.message)
                self.assertIn(name, answer.status.message)
                self.assertEqual(self.sim.everything(), before)

    def test_scenes_and_meshes_of_requests_lie_in_allowed_folders(self):
        with tempfile.TemporaryDirectory(dir='/tmp') as folder:
            allowed = os.path.join(folder, 'copy.yaml')
            shutil.copy(self.scene, allowed)
            link = os.path.join(folder, 'link.yaml')
            os.symlink('/etc/passwd', link)
            mesh = 'bodies:\n  - cloth: {name: a, mesh: %s}\n'
            for arguments in (dict(file='/etc/passwd'), dict(file='../../../../../../../../etc/passwd'), dict(file=link),
                              dict(file='/dev/zero'), dict(file='/no/such/file.yaml'), dict(yaml=mesh % '/etc/mesh.obj'),
                              dict(yaml=mesh % '../../../../../../etc/mesh.obj'),
                              dict(yaml=mesh % 'package://deformable_sim/../../mesh.obj')):
                with self.subTest(**arguments):
                    self.refuse(Status.INVALID_ARGUMENT, 'outside of the folders', lambda a=arguments: self.sim.load_scene(**a))
            self.assertEqual(self.sim.load_scene(file=allowed).status.code, Status.OK)

    def test_a_loaded_scene_brings_its_topics_and_takes_the_old_ones(self):
        self.assertEqual(self.sim.load_scene(file=self.scene.replace('hanging', 'small')).status.code, Status.OK)
        self.assertEqual(self.sim.steps(1), DT)
        self.assertEqual(len(self.sim.state('napkin').positions), 3 * 25)
        self.assertEqual(self.sim.get_state('sheet').status.code, Status.NOT_FOUND)

        def topics():
            return {name for name, _ in rospy.get_published_topics('/deformable_sim')}

        wait_until(lambda: '/deformable_sim/napkin/points' in topics(), 'topics of the new body')
        wait_until(lambda: '/deformable_sim/sheet/points' not in topics(), 'the end of the old ones')
        wait_until(lambda: '/deformable_sim/grasp/pin_napkin_corner_0/wrench' in topics(), 'wrench topics')

    def test_the_solver_that_was_chosen_is_described_with_its_reason(self):
        scene = ('bodies:\n  - cloth: {name: sheet, cells: [20, 20], bending: quadratic, pins: [corner_0],\n'
                 '             material: {bending_rigidity: 1.0e-5}}\n')
        self.assertEqual(self.sim.load_scene(yaml='step: {accuracy: reference}\n' + scene).status.code, Status.OK)
        self.assertIn('asked for an error of 0.1 %', self.sim.description('solver'))
        self.assertIn('measured on hang_20', self.sim.description('solver'))
        self.assertEqual(self.sim.load_scene(yaml='step: {integrator: bdf2}\n' + scene).status.code, Status.OK)
        self.assertEqual(self.sim.description('solver'), 'as the scene says')
        self.assertIn('bdf2', self.sim.description('step'))

    # --- refusals by topic ---

    def test_refused_topics_are_reported_and_change_nothing(self):
        status = self.sim.listen('status', SimStatus)
        command = rospy.Publisher(self.sim.topic('grasp_command'), GraspCommand, queue_size=10)
        obstacle = rospy.Publisher(self.sim.topic('obstacle'), Obstacle, queue_size=10)
        goal = rospy.Publisher(self.sim.topic('grasp/pin_sheet_corner_2/target'), PoseStamped, queue_size=10)
        for publisher in (command, obstacle, goal):
            wait_until(lambda p=publisher: p.get_num_connections() > 0, 'the node to subscribe')
        before = self.sim.everything()
        for publisher, message, word in (
                (command, GraspCommand(action=GraspCommand.GRASP, name='nan', body='sheet',
                                       selection=nearest(math.nan, 0, 0)), "'nan' refused"),
                (command, GraspCommand(action=7, name='seven'), "'seven' refused"),
                (command, GraspCommand(action=GraspCommand.RELEASE, name='nobody'), "'nobody' refused"),
                (goal, target(math.nan, 0, 0), "'pin_sheet_corner_2' refused"),
                (obstacle, Obstacle(action=Obstacle.REMOVE, name='nothing'), "'nothing' refused"),
                (obstacle, Obstacle(action=9, name='nine'), "'nine' refused")):
            with self.subTest(word=word):
                publisher.publish(message)
                status.wait(lambda m, w=word: any(w in warning for warning in m.warnings))
        self.assertEqual(before, self.sim.everything())
        status.close()

    def test_commands_by_topic_are_done(self):
        command = rospy.Publisher(self.sim.topic('grasp_command'), GraspCommand, queue_size=10)
        obstacle = rospy.Publisher(self.sim.topic('obstacle'), Obstacle, queue_size=10)
        for publisher in (command, obstacle):
            wait_until(lambda p=publisher: p.get_num_connections() > 0, 'the node to subscribe')
        command.publish(GraspCommand(action=GraspCommand.GRASP, name='hand', body='sheet',
                                     selection=feature('corner_0')))
        wait_until(lambda: 'hand' in [g[0] for g in self.sim.everything()[2]], 'the grasp')
        command.publish(GraspCommand(action=GraspCommand.RELEASE, name='hand'))
        wait_until(lambda: 'hand' not in [g[0] for g in self.sim.everything()[2]], 'the release')
        obstacle.publish(box('crate'))
        wait_until(lambda: any('crate' in line for line in self.sim.everything()[3]), 'the obstacle')
        moved = box('crate', z=0.7)
        moved.action = Obstacle.MOVE
        obstacle.publish(moved)

        def arrived():
            self.sim.steps(1)
            return any('crate' in line and '0.7' in line for line in self.sim.everything()[3])

        wait_until(arrived, 'the obstacle to move')


if __name__ == '__main__':
    rospy.init_node('services_test')
    rostest.rosrun('deformable_sim', 'services', Services)
