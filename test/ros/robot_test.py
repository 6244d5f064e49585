#!/usr/bin/env python3
"""The robot of robot_description: its links, and what they carry, enter with their first transform and move with it."""

import unittest

import numpy
import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import TransformStamped, WrenchStamped
from sensor_msgs.msg import Image

from deformable_sim.msg import ContactArray, SegmentLabels, SimStatus
from support import Simulation, Status, wait_until


NAPKIN_ON_TRAY = """
step: {solver: manual, dt: 0.01}
bodies:
  - cloth:
      name: napkin
      size: [0.1, 0.1]
      cells: [5, 5]
      contact_radius: 0.001
      pose: {position: [0.03, 0, 0.612]}
      material: {areal_density: 0.2, thickness: 0.001, youngs_modulus: 3.0e4, bending_rigidity: [1e-5, 1e-5]}
colliders:
  - box: {name: tray, frame: hand, size: [0.3, 0.2, 0.02], pose: {position: [0.05, 0, 0.1]}}
robot: {friction: 0.4}
"""


def transform(parent, child, z):
    message = TransformStamped()
    message.header.stamp = rospy.Time.now()
    message.header.frame_id = parent
    message.child_frame_id = child
    message.transform.translation.z = z
    message.transform.rotation.w = 1.0
    return message


class Robot(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sim = Simulation()
        cls.tf = tf2_ros.TransformBroadcaster()

    def heights(self):
        """{obstacle: z} after one more step."""
        self.sim.steps(1)
        heights = {}
        for line in self.sim.describe().message.splitlines():
            if line.startswith('obstacle: '):
                heights[line.split()[1]] = float(line.rstrip(')').split()[-1])
        return heights

    def send_until(self, z, condition):
        def sent():
            self.tf.sendTransform([transform('world', 'base', 0.0), transform('base', 'hand', z)])
            return condition(self.heights())

        wait_until(sent, 'the robot at %g m' % z)

    def test_links_enter_with_their_first_transform_and_move_with_it(self):
        status = self.sim.listen('status', SimStatus)
        self.assertEqual(self.heights(), {})
        status.wait(lambda m: any('no transform yet' in w and 'hand' in w for w in m.warnings))
        # The mesh link is left out; the one without a shape is no obstacle.
        self.send_until(0.5, lambda h: set(h) == {'robot.base', 'robot.hand', 'tray'})
        self.send_until(0.7, lambda h: abs(h['robot.hand'] - 0.7) < 1e-6 and abs(h['tray'] - 0.8) < 1e-6)
        self.assertEqual(self.heights()['robot.base'], 0.0)
        count = len(status.messages)
        status.wait(lambda m: not any('no transform yet' in w for w in m.warnings), after=count)
        status.close()

        self.assertTrue(self.sim.reset().success)
        self.send_until(0.6, lambda h: abs(h.get('robot.hand', 0.0) - 0.6) < 1e-6)

    def test_the_camera_sees_links_and_not_what_they_hide(self):
        # From the world's origin upwards: the lowest point of the hand's ball, 50 mm below its centre, before the tray,
        # whose lower side is 90 mm above that centre; 80 mm towards -x the tray alone. near leaves out the base.
        self.send_until(0.7, lambda h: abs(h.get('robot.hand', 0.0) - 0.7) < 1e-6 and abs(h['tray'] - 0.8) < 1e-6)
        depth, owner = self.sim.listen('camera/below/depth', Image), self.sim.listen('camera/below/segmentation', Image)
        names = self.sim.listen('camera/below/labels', SegmentLabels)

        def near(message):
            z = numpy.frombuffer(message.data, '<f4').reshape(33, 33)
            return abs(z[16, 16] - 0.65) < 1e-5 and abs(z[16, 8] - 0.79) < 1e-5

        depth.wait(near)
        message = names.wait(lambda m: 'tray' in m.name)
        numbers = dict(zip(message.name, message.label))
        numbers = (numbers['robot.hand'], numbers['tray'])

        def owned(message):
            label = numpy.frombuffer(message.data, '<u2').reshape(33, 33)
            return (label[16, 16], label[16, 8]) == numbers

        owner.wait(owned)
        for listener in (depth, owner, names):
            listener.close()

    def test_what_a_link_lets_through_it_does_not_touch(self):
        scene = NAPKIN_ON_TRAY.replace('robot: {friction: 0.4}', 'robot: {lets_through: {hand: [napkin]}}')
        scene = scene.replace('cells: [5, 5]', 'cells: [5, 5]\n      pins: [corner_0, corner_1, corner_2, corner_3]')
        self.assertEqual(self.sim.load_scene(yaml=scene).status.code, Status.OK)
        self.send_until(0.61, lambda h: 'robot.hand' in h)
        self.assertLess(self.sim.get_distance(body='napkin', obstacles=['robot.hand']).distance, 0.0)
        self.assertNotEqual(self.sim.get_distance(body='napkin').obstacle, 'robot.hand')
        bad = scene.replace('hand: [', 'elbow: [')
        answer = self.sim.load_scene(yaml=bad)
        self.assertEqual(answer.status.code, Status.NOT_FOUND)
        self.assertIn("'elbow' is not in robot_description", answer.status.message)
        self.assertEqual(self.sim.load_scene(file=rospy.get_param('/deformable_sim/scene')).status.code, Status.OK)

    def test_what_lies_on_a_link_is_felt_by_it(self):
        # A napkin of weight W rests 3 cm off the hand's origin on the tray that the hand carries: the contacts push it up
        # by W, and the tray feels (0, 0, -W) and the torque r x F = (0, 0.03 W, 0) about the hand.
        answer = self.sim.load_scene(yaml=NAPKIN_ON_TRAY)
        self.assertEqual(answer.status.code, Status.OK, answer.status.message)
        wanted = {self.sim.topic('contact/%s/wrench' % name) for name in ('tray', 'robot/hand', 'robot/base')}
        wait_until(lambda: wanted <= set(dict(rospy.get_published_topics())), 'topics of what the robot feels')
        self.send_until(0.5, lambda h: 'tray' in h)
        self.sim.steps(300)

        contacts = self.sim.listen('contacts', ContactArray)
        felt = self.sim.listen('contact/tray/wrench', WrenchStamped)
        other = self.sim.listen('contact/robot/hand/wrench', WrenchStamped)
        time = self.sim.steps(20)
        touching, wrench, none = (topic.wait(lambda m: abs(m.header.stamp.to_sec() - time) < 1e-6)
                                  for topic in (contacts, felt, other))
        weight = 0.2 * 0.1 * 0.1 * 9.81
        self.assertEqual(touching.header.frame_id, 'world')
        self.assertEqual({(c.collider, c.link, c.body) for c in touching.contacts}, {('tray', 'hand', 'napkin')})
        self.assertAlmostEqual(sum(c.force.z for c in touching.contacts), weight, delta=0.01 * weight)
        for contact in touching.contacts:
            self.assertAlmostEqual(contact.point.z, 0.61, delta=1e-9)
            self.assertAlmostEqual(contact.normal.z, 1.0, delta=1e-9)
            self.assertAlmostEqual(contact.distance, 0.0, delta=1e-4)
        self.assertEqual(wrench.header.frame_id, 'hand')
        self.assertAlmostEqual(wrench.wrench.force.z, -weight, delta=0.01 * weight)
        self.assertAlmostEqual(wrench.wrench.torque.x, 0.0, delta=0.01 * 0.03 * weight)
        self.assertAlmostEqual(wrench.wrench.torque.y, 0.03 * weight, delta=0.01 * 0.03 * weight)
        self.assertEqual((none.header.frame_id, none.wrench.force.z), ('hand', 0.0))
        for topic in (contacts, felt, other):
            topic.close()
        self.assertEqual(self.sim.load_scene(file=rospy.get_param('/deformable_sim/scene')).status.code, Status.OK)

    def test_a_link_is_no_obstacle_of_a_user(self):
        answer = self.sim.remove_obstacle('robot.hand')
        self.assertEqual(answer.status.code, Status.INVALID_ARGUMENT)

    def test_a_link_that_does_not_exist_is_refused(self):
        answer = self.sim.load_scene(yaml='bodies:\n  - cloth: {name: a}\nrobot: {links: [elbow]}\n')
        self.assertEqual(answer.status.code, Status.NOT_FOUND)
        self.assertIn('elbow', answer.status.message)
        self.assertIn('hand', answer.status.message)


if __name__ == '__main__':
    rospy.init_node('robot_test')
    rostest.rosrun('deformable_sim', 'robot', Robot)
