#!/usr/bin/env python3
"""A running scene that changes: bodies that come and go, materials, parameters by dynamic_reconfigure."""

import unittest

import dynamic_reconfigure.client
import rospy
import rostest
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from visualization_msgs.msg import Marker, MarkerArray

from deformable_sim.msg import BodyState
from deformable_sim.srv import AddBody, RemoveBody, SetMaterial
from support import Refusals, SimStatus, Simulation, Status, feature, node_position, wait_until

ROPE = 'bodies:\n  - rope: {name: cord, length: 0.4, segments: 8, pins: [end_0], pose: {position: [0, 3, 1]}}\n'
STANDARD = {'gravity_x': 0.0, 'gravity_y': 0.0, 'gravity_z': -9.81, 'wind_x': 0.0, 'air_damping': 3.0, 'friction': 0.5}


class Changes(Refusals, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sim = Simulation()
        cls.add = cls.sim._service('add_body', AddBody)
        cls.remove = cls.sim._service('remove_body', RemoveBody)
        cls.material = cls.sim._service('set_material', SetMaterial)
        cls.live = dynamic_reconfigure.client.Client('/deformable_sim', timeout=20)
        cls.status = cls.sim.listen('status', SimStatus)

    def setUp(self):
        self.answer_ok(self.sim.load_scene(file=rospy.get_param('/deformable_sim/scene')))

    def answer_ok(self, answer):
        self.assertEqual(answer.status.code, Status.OK, answer.status.message)
        return answer

    def test_a_body_comes_and_the_others_go_on(self):
        self.sim.steps(30)
        before = self.sim.state('sheet')
        pose = PoseStamped(pose=Pose(position=Point(0.5, 2.0, 0.8), orientation=Quaternion(w=1.0)))
        self.assertEqual(self.answer_ok(self.add(yaml=ROPE, pose=pose)).bodies, ['cord'])
        after = self.sim.state('sheet')
        self.assertEqual(before.positions, after.positions)
        self.assertEqual(before.velocities, after.velocities)
        self.assertEqual(self.sim.description('time'), '0.3 s')
        cord = self.sim.state('cord')
        self.assertAlmostEqual(sum(cord.positions[1::3]) / 9, 2.0, places=9)
        held = node_position(cord, 0)
        states = self.sim.listen('cord/state', BodyState)
        self.sim.steps(100)
        states.wait(lambda m: m.header.stamp.to_sec() > 1.25)
        self.assertEqual(node_position(self.sim.state('cord'), 0), held)
        self.assertLess(node_position(self.sim.state('cord'), 8)[2], 0.5)

    def test_a_grasp_holds_on_while_bodies_come(self):
        self.answer_ok(self.sim.grasp(name='hand', body='line', selection=feature('end_1'), stiffness=0.0))
        self.sim.steps(5)
        held = node_position(self.sim.state('line'), 10)
        self.answer_ok(self.add(yaml=ROPE))
        self.sim.steps(50)
        self.assertEqual(node_position(self.sim.state('line'), 10), held)
        self.answer_ok(self.sim.release('hand'))
        self.sim.steps(50)
        self.assertNotEqual(node_position(self.sim.state('line'), 10), held)

    def test_a_body_goes_with_its_grasps_and_its_picture(self):
        markers = self.sim.listen('markers', MarkerArray)
        self.sim.steps(20)
        markers.wait(lambda m: any(marker.ns == 'body/line' for marker in m.markers))
        seen = len(markers.messages)
        before = self.sim.state('sheet').positions
        self.answer_ok(self.remove('line'))
        self.assertEqual(before, self.sim.state('sheet').positions)
        self.assertEqual(self.sim.get_state('line').status.code, Status.NOT_FOUND)
        self.assertEqual(self.sim.release('pin_line_end_0').status.code, Status.NOT_FOUND)
        self.sim.steps(20)
        gone = (Marker.DELETE, Marker.DELETEALL)
        markers.wait(lambda m: any(marker.action in gone for marker in m.markers), after=seen)
        self.refuse_alone(Status.INVALID_ARGUMENT, 'only body', lambda: self.remove('sheet'))

    def refuse_alone(self, code, word, call):
        answer = call()
        self.assertEqual(answer.status.code, code, answer.status.message)
        self.assertIn(word, answer.status.message)

    def test_reset_keeps_what_was_added(self):
        self.answer_ok(self.add(yaml=ROPE))
        start = self.sim.state('cord').positions
        self.sim.steps(50)
        self.assertTrue(self.sim.reset().success)
        self.assertEqual(self.sim.state('cord').positions, start)

    def test_bad_changes_are_refused(self):
        far = PoseStamped()
        far.header.frame_id, far.pose.orientation.w = 'nowhere', 1.0
        bad = PoseStamped(pose=Pose(position=Point(float('nan'), 0, 0), orientation=Quaternion(w=1.0)))
        for code, word, call in [
                (Status.ALREADY_EXISTS, 'line', lambda: self.add(yaml='bodies: [{rope: {name: line}}]')),
                (Status.INVALID_ARGUMENT, 'one of the two', self.add),
                (Status.INVALID_ARGUMENT, 'yaml:1', lambda: self.add(yaml='bodies: [{rope: {name: a, lenght: 1}}]')),
                (Status.UNAVAILABLE, 'nowhere', lambda: self.add(yaml=ROPE, pose=far)),
                (Status.INVALID_ARGUMENT, 'pose', lambda: self.add(yaml=ROPE, pose=bad)),
                (Status.NOT_FOUND, 'sheet, line', lambda: self.remove('shirt')),
                (Status.NOT_FOUND, 'sheet, line', lambda: self.material('shirt', '{}')),
                (Status.OUT_OF_RANGE, 'damping', lambda: self.material('sheet', '{damping: 7}')),
                (Status.INVALID_ARGUMENT, 'finite', lambda: self.material('sheet', '{damping: .nan}'))]:
            self.refuse(code, word, call)

    def test_a_material_changes_while_the_body_moves(self):
        self.sim.steps(20)
        before = self.sim.state('line')
        self.answer_ok(self.material('line', '{youngs_modulus: 200000}'))
        self.assertEqual(self.sim.state('line').positions, before.positions)
        self.assertEqual(self.sim.state('line').velocities, before.velocities)
        self.sim.steps(400)
        # A hanging rope: lambda g L^2 / (2 E A) of length 0.5 m, 0.05 kg/m, 8 mm.
        expected = 0.05 * 9.81 * 0.5**2 / (2 * 2e5 * 3.14159265 * 0.004**2)
        state = self.sim.state('line')
        length = node_position(state, 0)[2] - node_position(state, 10)[2]
        self.assertAlmostEqual(length - 0.5, expected, delta=0.05 * expected)

    def shown(self):
        return self.live.get_configuration(timeout=20)

    def test_values_are_those_of_the_scene(self):
        for key, value in STANDARD.items():
            self.assertAlmostEqual(self.shown()[key], value, places=12)

    def test_gravity_changes_live(self):
        got = self.live.update_configuration({'gravity_z': -1.62, 'air_damping': 0.0})
        self.assertEqual(got['gravity_z'], -1.62)
        self.answer_ok(self.sim.release(''))
        z = node_position(self.sim.state('line'), 5)[2]
        self.sim.steps(100)
        # Implicit Euler in steps of h: g (t^2 + h t) / 2.
        self.assertAlmostEqual(z - node_position(self.sim.state('line'), 5)[2], 0.5 * 1.62 * (1.0 + 0.01), places=4)
        self.answer_ok(self.sim.load_scene(file=rospy.get_param('/deformable_sim/scene')))
        wait_until(lambda: self.shown()['gravity_z'] == -9.81, 'the values of the scene loaded anew')

    def test_colours_leave_the_world_alone(self):
        self.sim.steps(10)
        before = self.sim.everything()
        self.assertEqual(self.live.update_configuration({'color_by': 'strain', 'strain_range': 0.01})['color_by'], 'strain')
        self.assertEqual(before, self.sim.everything())

    def test_shadows_and_legend_come_and_go_live(self):
        def spaces(message):
            return {marker.ns for marker in message.markers if marker.action == Marker.ADD}
        self.assertEqual(self.shown()['legend'], True)
        markers = self.sim.listen('markers', MarkerArray)
        self.sim.steps(1)
        markers.wait(lambda m: 'body/sheet' in spaces(m) and not {'shadow/sheet', 'legend'} & spaces(m))
        self.live.update_configuration({'color_by': 'strain', 'shadows': True})
        markers.wait(lambda m: {'shadow/sheet', 'legend'} <= spaces(m))
        shown = len(markers.messages)
        self.live.update_configuration({'color_by': 'body', 'shadows': False})
        message = markers.wait(lambda m: not {'shadow/sheet', 'legend'} & spaces(m), after=shown)
        self.assertIn(Marker.DELETEALL, [marker.action for marker in message.markers])

    def test_a_value_that_is_refused_is_set_back(self):
        before = self.sim.everything()
        got = self.live.update_configuration({'color_by': 'mood'})
        self.assertEqual(got['color_by'], 'body')
        self.status.wait(lambda m: any('mood' in text for text in m.warnings))
        got = self.live.update_configuration({'accuracy': 0.001})
        self.assertEqual(got['accuracy'], 0.01)
        self.assertEqual(before, self.sim.everything())


if __name__ == '__main__':
    rospy.init_node('changes_test')
    rostest.rosrun('deformable_sim', 'changes', Changes)
