#!/usr/bin/env python3
"""The simulation as a nodelet: what the node has, in a manager that may load several and unload them."""

import unittest

import rospy
import rosservice
import rostest
from nodelet.srv import NodeletList, NodeletLoad, NodeletUnload
from sensor_msgs.msg import PointCloud2

from support import DEADLINE, Simulation, Status, feature, node_position, wait_until

MANAGER = '/deformable_sim_manager/'


class Nodelet(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        for name in ('load_nodelet', 'unload_nodelet', 'list'):
            rospy.wait_for_service(MANAGER + name, DEADLINE)
        cls.load = rospy.ServiceProxy(MANAGER + 'load_nodelet', NodeletLoad)
        cls.unload = rospy.ServiceProxy(MANAGER + 'unload_nodelet', NodeletUnload)
        cls.list = rospy.ServiceProxy(MANAGER + 'list', NodeletList)
        cls.sim = Simulation()

    def test_it_simulates_as_the_node_does(self):
        clouds = self.sim.listen('points', PointCloud2)
        self.assertEqual(self.sim.grasp(name='hand', body='line', selection=feature('end_1')).status.code, Status.OK)
        held = node_position(self.sim.state('line'), 10)
        self.sim.steps(50)
        self.assertEqual(node_position(self.sim.state('line'), 10), held)
        self.assertAlmostEqual(clouds.wait(lambda m: m.header.stamp.to_sec() > 0.4).header.stamp.to_sec(), 0.5, delta=0.1)
        self.assertEqual(self.sim.load_scene(yaml='nonsense').status.code, Status.INVALID_ARGUMENT)
        services = {name for name in rosservice.get_service_list(namespace='/deformable_sim')}
        self.assertTrue({'/deformable_sim/step', '/deformable_sim/rollout', '/deformable_sim/set_parameters'} <= services)

    def test_two_in_one_manager_and_one_goes(self):
        rospy.set_param('/second/scene', 'minimal')
        rospy.set_param('/second/clock', 'on_demand')
        self.assertTrue(self.load(name='/second', type='deformable_sim/Simulation').success)
        second = Simulation('second')
        self.assertGreater(second.steps(3), 0.0)
        time = self.sim.description('time')
        self.assertTrue(self.unload(name='/second').success)
        wait_until(lambda: '/second/step' not in rosservice.get_service_list(), 'the services to go')
        self.assertEqual(self.list().nodelets, ['/deformable_sim'])
        self.assertEqual(self.sim.description('time'), time)
        self.sim.steps(2)

    def test_a_scene_that_is_refused_is_not_loaded(self):
        rospy.set_param('/third/scene', '/no/such/file.yaml')
        try:
            loaded = self.load(name='/third', type='deformable_sim/Simulation').success
        except rospy.ServiceException:
            loaded = False
        self.assertFalse(loaded)
        self.assertEqual(self.list().nodelets, ['/deformable_sim'])
        self.sim.steps(1)


if __name__ == '__main__':
    rospy.init_node('nodelet_test')
    rostest.rosrun('deformable_sim', 'nodelet', Nodelet)
