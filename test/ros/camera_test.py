#!/usr/bin/env python3
"""Depth cameras of the running node: images against closed forms, their frames, their labels."""

import unittest

import numpy
import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import CameraInfo, Image, PointCloud2

from deformable_sim.msg import SegmentLabels, SimStatus
from support import Listener, Simulation, wait_until

TABLE_TOP = 0.1  # m
CLOTH_TOP = TABLE_TOP + 0.003  # its contact radius lies between
CLOTH_HALF = numpy.array((0.15, 0.1))  # m, half of its edges
BALL, BALL_RADIUS = numpy.array((0.1, 0.25, 0.16)), 0.06
FX, FY, CX, CY = 150.0, 140.0, 82.0, 57.0
WIDTH, HEIGHT = 160, 120

EYE = numpy.array((-0.4, 0.1, 0.7))
# Columns: the image's right, its down and forward in the world; looks along +x, 50 degrees down.
DOWN = numpy.radians(50.0)
EYE_AXES = numpy.array(((0.0, -numpy.sin(DOWN), numpy.cos(DOWN)), (-1.0, 0.0, 0.0),
                        (0.0, -numpy.cos(DOWN), -numpy.sin(DOWN))))


def depths(message):
    return numpy.frombuffer(message.data, '<f4').reshape(message.height, message.width)


def labels(message):
    return numpy.frombuffer(message.data, '<u2').reshape(message.height, message.width)


def quaternion(axes):
    """x y z w of a rotation matrix whose trace is not -1."""
    w = 0.5 * numpy.sqrt(1.0 + numpy.trace(axes))
    return ((axes[2, 1] - axes[1, 2]) / (4 * w), (axes[0, 2] - axes[2, 0]) / (4 * w),
            (axes[1, 0] - axes[0, 1]) / (4 * w), w)


def expected():
    """Depth of ball, cloth and table in each pixel (m): the distance along the ray whose z is 1 in the optical frame."""
    v, u = numpy.mgrid[0:HEIGHT, 0:WIDTH]
    rays = numpy.stack(((u - CX) / FX, (v - CY) / FY, numpy.ones_like(u, dtype=float)), axis=-1) @ EYE_AXES.T
    table = (TABLE_TOP - EYE[2]) / rays[..., 2]
    cloth = (CLOTH_TOP - EYE[2]) / rays[..., 2]
    at = EYE[:2] + cloth[..., None] * rays[..., :2]
    cloth = numpy.where(numpy.all(numpy.abs(at) < CLOTH_HALF, axis=-1), cloth, numpy.inf)
    # |EYE + t d - BALL|^2 = r^2, the smaller root.
    a = numpy.sum(rays * rays, axis=-1)
    b = rays @ (EYE - BALL)
    c = numpy.dot(EYE - BALL, EYE - BALL) - BALL_RADIUS**2
    root = b * b - a * c
    ball = numpy.where(root > 0, (-b - numpy.sqrt(numpy.maximum(root, 0))) / a, numpy.inf)
    return ball, cloth, table


class Cameras(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sim = Simulation()
        cls.tf = tf2_ros.StaticTransformBroadcaster()
        cls.frames = {}
        cls.place('eye_optical_frame', EYE, quaternion(EYE_AXES))
        cls.time = cls.sim.steps(300)  # the cloth lies still: e^-9 of its fall is left

    @classmethod
    def place(cls, frame, position, rotation):
        transform = TransformStamped()
        transform.header.frame_id, transform.header.stamp, transform.child_frame_id = 'world', rospy.Time.now(), frame
        t, r = transform.transform.translation, transform.transform.rotation
        t.x, t.y, t.z = position
        r.x, r.y, r.z, r.w = rotation
        cls.frames[frame] = transform
        cls.tf.sendTransform(list(cls.frames.values()))

    def one(self, name, kind):
        listener = Listener(self.sim.topic(name), kind)
        message = listener.wait()
        listener.close()
        return message

    def test_depth_is_that_of_the_closed_forms_to_a_millimetre(self):
        image = self.one('camera/eye/depth', Image)
        self.assertEqual((image.encoding, image.header.frame_id), ('32FC1', 'eye_optical_frame'))
        seen, ball, cloth, table = depths(image), *expected()
        truth = numpy.minimum(numpy.minimum(ball, cloth), table)
        error = numpy.abs(seen - truth)
        # At an outline the one pixel or the other: 1 % of them may show what is beside.
        self.assertLess(numpy.count_nonzero(~(error < 1e-3)), 0.01 * error.size)
        # Float32 and nothing more where there are no bodies, whose place is the solver's.
        for part, tolerance in ((ball < table, 1e-5), (cloth < numpy.minimum(ball, table), 1e-3),
                                (~(ball < table) & ~numpy.isfinite(cloth), 1e-5)):
            self.assertGreater(numpy.count_nonzero(part), 300)
            self.assertLess(numpy.quantile(error[part], 0.98), tolerance)

    def test_labels_say_whose_pixels_they_are(self):
        names = self.one('camera/eye/labels', SegmentLabels)
        numbers = dict(zip(names.name, names.label))
        self.assertEqual(set(numbers), {'cloth', 'table', 'ball'})
        seen = labels(self.one('camera/eye/segmentation', Image))
        ball, cloth, table = expected()
        for name, part in (('ball', ball < table), ('cloth', (cloth < table) & (cloth < ball)),
                           ('table', ~(ball < table) & ~(cloth < table))):
            right = numpy.count_nonzero(seen[part] == numbers[name])
            self.assertGreater(right, 0.97 * numpy.count_nonzero(part), name)

    def test_points_are_the_depth_image_through_the_camera_info(self):
        image, info = self.one('camera/eye/depth', Image), self.one('camera/eye/camera_info', CameraInfo)
        self.assertEqual((info.width, info.height, info.distortion_model), (WIDTH, HEIGHT, 'plumb_bob'))
        self.assertEqual(info.K, (FX, 0, CX, 0, FY, CY, 0, 0, 1))
        self.assertEqual(info.P, (FX, 0, CX, 0, 0, FY, CY, 0, 0, 0, 1, 0))
        self.assertEqual(info.header.frame_id, 'eye_optical_frame')
        cloud = self.one('camera/eye/points', PointCloud2)
        self.assertEqual((cloud.width, cloud.height, cloud.point_step), (WIDTH, HEIGHT, 16))
        points = numpy.frombuffer(cloud.data, '<f4').reshape(HEIGHT, WIDTH, 4)
        v, u = numpy.mgrid[0:HEIGHT, 0:WIDTH]
        z = depths(image)
        numpy.testing.assert_array_equal(points[..., 2], z)
        numpy.testing.assert_allclose(points[..., 0], z * (u - CX) / FX, atol=1e-6)
        numpy.testing.assert_allclose(points[..., 1], z * (v - CY) / FY, atol=1e-6)

    def test_noise_is_that_of_its_parameters_and_of_the_step(self):
        clean = depths(self.one('camera/eye/depth', Image))
        noisy = depths(self.one('camera/noisy/depth', Image))
        # n = 19200 pixels: the standard deviation is known to 4 / sqrt(2 n) = 2 %.
        self.assertAlmostEqual(numpy.std(noisy - clean), 0.005, delta=0.0001)
        numpy.testing.assert_array_equal(noisy, depths(self.one('camera/noisy/depth', Image)))

    def test_a_camera_moves_with_its_frame_even_while_time_stands(self):
        # It looks straight down: turned by half a turn about x. Depth of the table in the middle: height - 0.1.
        self.place('hand_optical_frame', (1.0, 1.0, 0.9), (1, 0, 0, 0))
        listener = self.sim.listen('camera/hand/depth', Image)
        listener.wait(lambda m: abs(depths(m)[12, 16] - 0.8) < 1e-5)
        self.place('hand_optical_frame', (1.0, 1.0, 1.2), (1, 0, 0, 0))
        listener.wait(lambda m: abs(depths(m)[12, 16] - 1.1) < 1e-5)
        self.place('hand_optical_frame', (1.0, 1.0, 1.2), (0, 0, 0, 1))  # upwards
        listener.wait(lambda m: numpy.all(numpy.isnan(depths(m))))
        listener.close()

    def test_a_frame_that_is_missing_is_a_warning_and_no_image(self):
        status = self.sim.listen('status', SimStatus)
        listener = self.sim.listen('camera/lost/depth', Image)

        def warned(message):
            return any('lost_optical_frame' in warning for warning in message.warnings)

        status.wait(warned)
        self.sim.steps(20)
        self.assertEqual(listener.messages, [])
        self.place('lost_optical_frame', (1.0, 1.0, 1.0), (1, 0, 0, 0))
        self.assertAlmostEqual(depths(listener.wait())[12, 16], 0.9, delta=1e-5)
        wait_until(lambda: status.messages and not warned(status.messages[-1]), 'the warning to go')
        listener.close()
        status.close()

    def test_cameras_are_described(self):
        self.assertIn('eye (160 x 120, at eye_optical_frame, 10 Hz)', self.sim.describe().message)


if __name__ == '__main__':
    rospy.init_node('camera_test')
    rostest.rosrun('deformable_sim', 'camera', Cameras)
