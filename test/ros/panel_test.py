#!/usr/bin/env python3
"""The panel inside rviz, on a virtual screen: it loads, listens to its node, and outlives it."""

import os
import signal
import subprocess
import tempfile
import unittest
import xmlrpc.client

import roslib.packages
import rosgraph
import rospy
import rostest
from std_srvs.srv import Empty

from support import wait_until

PACKAGE = roslib.packages.get_pkg_dir('deformable_sim')
CONFIGURATION = PACKAGE + '/config/rviz/default.rviz'  # names the node /deformable_sim
NODE = 'watched'
START = 40.0  # s, wall: rviz without a graphics card


class PanelInRviz(unittest.TestCase):
    def setUp(self):
        self.processes = []
        self.folder = tempfile.TemporaryDirectory()
        self.master = rosgraph.Master('/panel_test')
        self.node = self.start_node()
        self.log = os.path.join(self.folder.name, 'rviz.log')
        self.rviz = self.start(['rviz', '-d', CONFIGURATION, '__name:=rviz_panel', '/deformable_sim:=/' + NODE],
                               output=self.log, DISPLAY=self.start_screen(), LIBGL_ALWAYS_SOFTWARE='1', LP_NUM_THREADS='1')
        wait_until(self.listened_to, 'the panel listens to its node', START)

    def tearDown(self):
        for process in reversed(self.processes):
            if process.poll() is None:
                process.terminate()
        for process in self.processes:
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.folder.cleanup()

    def start(self, command, output=os.devnull, pass_fds=(), **environment):
        with open(output, 'w') as stream:
            process = subprocess.Popen(command, env=dict(os.environ, **environment), stdin=subprocess.DEVNULL,
                                       stdout=stream, stderr=subprocess.STDOUT, pass_fds=pass_fds)
        self.processes.append(process)
        return process

    def start_node(self):
        program = roslib.packages.find_node('deformable_sim', 'sim_node')[0]
        return self.start([program, '__name:=' + NODE, '_scene:=%s/test/ros/scenes/hanging.yaml' % PACKAGE])

    def start_screen(self):
        read_end, write_end = os.pipe()
        self.start(['Xvfb', '-displayfd', str(write_end), '-screen', '0', '1280x960x24', '-nolisten', 'tcp', '-noreset'],
                   pass_fds=[write_end])
        os.close(write_end)
        with os.fdopen(read_end) as stream:
            return ':' + stream.readline().strip()

    def log_text(self):
        with open(self.log, encoding='utf-8', errors='replace') as stream:
            return stream.read()

    def listened_to(self):
        """The node's own word that rviz is connected to its ~status, which nothing but the panel asks for."""
        try:
            address = self.master.lookupNode('/' + NODE)
            connections = xmlrpc.client.ServerProxy(address).getBusInfo('/panel_test')[2]
        except (OSError, rosgraph.MasterException):
            return False
        return any(c[1] == '/rviz_panel' and c[2] == 'o' and c[4] == '/%s/status' % NODE for c in connections)

    def rviz_answers(self):
        """Services of rviz are answered by the thread that draws."""
        rospy.wait_for_service('/rviz_panel/reload_shaders', START)
        rospy.ServiceProxy('/rviz_panel/reload_shaders', Empty)()
        return self.rviz.poll() is None

    def test_the_shipped_configuration_holds_a_panel_that_loads_and_listens(self):
        self.assertTrue(self.rviz_answers())
        for word in ('PluginlibFactory', '[ERROR]', '[FATAL]', 'deformable_sim/Simulation'):
            self.assertNotIn(word, self.log_text())

    def test_rviz_outlives_the_node_and_the_panel_finds_it_again(self):
        self.node.send_signal(signal.SIGKILL)
        self.node.wait()
        for _ in range(3):
            self.assertTrue(self.rviz_answers())
        self.node = self.start_node()
        wait_until(self.listened_to, 'the panel listens to the new node')
        self.assertTrue(self.rviz_answers())

    def test_rviz_closes_while_the_node_hangs(self):
        self.node.send_signal(signal.SIGSTOP)
        try:
            self.assertTrue(self.rviz_answers())
            self.rviz.send_signal(signal.SIGINT)  # as its window's close button: everything is taken down in order
            self.assertEqual(self.rviz.wait(20), 0)
        finally:
            self.node.send_signal(signal.SIGCONT)


if __name__ == '__main__':
    rospy.init_node('panel_test')
    rostest.rosrun('deformable_sim', 'panel', PanelInRviz)
