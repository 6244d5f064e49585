"""What the ROS tests share: waiting for conditions with a deadline, and the node as a Python object."""

import threading
import time

import rospy
from geometry_msgs.msg import Pose
from shape_msgs.msg import SolidPrimitive
from std_srvs.srv import SetBool, Trigger

from deformable_sim.msg import GraspSelection, GraspStateArray, Obstacle, SimStatus, Status
from deformable_sim.srv import (AddObstacle, GetDistance, GetState, Grasp, LetThrough, LoadScene, MoveGrasp, Release,
                                RemoveObstacle, RestoreState, SaveState, SetState, Step)

DEADLINE = 20.0  # s, wall: only ever reached by a failure


def wait_until(condition, what, deadline=DEADLINE):
    """Polls `condition` until it returns something true, and returns that."""
    end = time.monotonic() + deadline
    pause = threading.Event()
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > end:
            raise AssertionError('not within %g s: %s' % (deadline, what))
        pause.wait(0.005)


class Listener:
    """Keeps the messages of one topic."""

    def __init__(self, topic, kind, connected=True):
        self.messages = []
        self._subscriber = rospy.Subscriber(topic, kind, self.messages.append)
        self.topic = topic
        if connected:
            wait_until(lambda: self._subscriber.get_num_connections() > 0, 'a publisher of ' + topic)

    def wait(self, condition=lambda message: True, after=0):
        """The first message from number `after` on that meets `condition`."""

        def found():
            return next((m for m in self.messages[after:] if condition(m)), None)

        return wait_until(found, 'a message on %s' % self.topic)

    def close(self):
        self._subscriber.unregister()


class Simulation:
    """The services of one node, by their names."""

    def __init__(self, node='deformable_sim'):
        self.node = node
        self.grasp = self._service('grasp', Grasp)
        self.move_grasp = self._service('move_grasp', MoveGrasp)
        self.release = self._service('release', Release)
        self.pause = self._service('pause', SetBool)
        self.reset = self._service('reset', Trigger)
        self.describe = self._service('describe', Trigger)
        self.step = self._service('step', Step)
        self.load_scene = self._service('load_scene', LoadScene)
        self.add_obstacle = self._service('add_obstacle', AddObstacle)
        self.remove_obstacle = self._service('remove_obstacle', RemoveObstacle)
        self.let_through = self._service('let_through', LetThrough)
        self.get_distance = self._service('get_distance', GetDistance)
        self.get_state = self._service('get_state', GetState)
        self.set_state = self._service('set_state', SetState)
        self.save_state = self._service('save_state', SaveState)
        self.restore_state = self._service('restore_state', RestoreState)

    def _service(self, name, kind):
        full = '/%s/%s' % (self.node, name)
        rospy.wait_for_service(full, DEADLINE)
        return rospy.ServiceProxy(full, kind)

    def topic(self, name):
        return '/%s/%s' % (self.node, name)

    def listen(self, name, kind):
        return Listener(self.topic(name), kind)

    def steps(self, count):
        """Makes steps; returns the time reached."""
        answer = self.step(steps=count)
        assert answer.status.code == Status.OK, answer.status.message
        assert answer.steps == count
        return answer.time

    def state(self, body):
        answer = self.get_state(body)
        assert answer.status.code == Status.OK, answer.status.message
        return answer.state

    def description(self, key):
        """The value of one line of ~describe."""
        for line in self.describe().message.splitlines():
            if line.startswith(key + ': '):
                return line[len(key) + 2:]
        raise AssertionError('~describe has no line ' + key)

    def everything(self, bodies=('sheet', 'line')):
        """All that a refusal must not change: nodes, grasps, obstacles, time."""
        states = [self.state(body) for body in bodies]
        grasps = self.listen('grasps', GraspStateArray)
        grasp_states = grasps.wait().grasps
        grasps.close()
        return ([(s.positions, s.velocities) for s in states], self.description('time'),
                [(g.name, g.body, g.nodes, g.state, str(g.pose)) for g in grasp_states],
                [line for line in self.describe().message.splitlines() if line.startswith('obstacle: ')])


class Refusals:
    """Of a test case that has the node as `sim`."""

    def refuse(self, code, word, call):
        """`call` is answered with `code`, a message that has `word` in it, and an unchanged world."""
        before = self.sim.everything()
        answer = call()
        self.assertEqual(answer.status.code, code, answer.status.message)
        self.assertIn(word, answer.status.message)
        self.assertEqual(before, self.sim.everything())


def box(name, z=0.5, size=(0.1, 0.1, 0.1)):
    pose = Pose()
    pose.position.x, pose.position.z, pose.orientation.w = 3.0, z, 1.0
    return Obstacle(name=name, primitives=[SolidPrimitive(type=SolidPrimitive.BOX, dimensions=list(size))],
                    primitive_poses=[pose], friction=0.5)


def feature(name):
    return GraspSelection(method=GraspSelection.FEATURE, feature=name)


def nearest(x, y, z, frame='', radius=0.0):
    selection = GraspSelection(method=GraspSelection.NEAREST, radius=radius)
    selection.pose.header.frame_id = frame
    selection.pose.pose.position.x, selection.pose.pose.position.y, selection.pose.pose.position.z = x, y, z
    selection.pose.pose.orientation.w = 1.0
    return selection


def node_position(state, node):
    return state.positions[3 * node:3 * node + 3]


__all__ = ['DEADLINE', 'GraspSelection', 'GraspStateArray', 'Listener', 'Refusals', 'SimStatus', 'Simulation', 'Status', 'box',
           'feature', 'nearest', 'node_position', 'wait_until']
