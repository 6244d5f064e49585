"""Sends hostile messages to every topic and service of one node, and checks after each batch that nothing came of them."""

import math
import re
import socket
import struct
import xmlrpc.client

import genpy
import rosgraph
import rospy
from actionlib_msgs.msg import GoalID
from dynamic_reconfigure.srv import Reconfigure
from geometry_msgs.msg import PoseStamped
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerUpdate, MarkerArray

from deformable_sim.msg import BodyState, FollowGraspTrajectoryActionGoal, GraspCommand, Obstacle, SimStatus, Status
from deformable_sim.srv import (AddBody, AddObstacle, GetDistance, GetState, Grasp, LetThrough, LoadScene, MoveGrasp, Release,
                                RemoveBody, RemoveObstacle, RestoreState, Rollout, SaveState, SetMaterial, SetState, Step)
from hostile_messages import Hostile, garbage_class
from support import Listener, Simulation, wait_until

SERVICES = {'grasp': Grasp, 'move_grasp': MoveGrasp, 'release': Release, 'pause': SetBool, 'reset': Trigger, 'describe': Trigger,
            'step': Step, 'load_scene': LoadScene, 'add_obstacle': AddObstacle, 'remove_obstacle': RemoveObstacle,
            'let_through': LetThrough, 'get_distance': GetDistance, 'get_state': GetState, 'set_state': SetState,
            'save_state': SaveState, 'restore_state': RestoreState, 'add_body': AddBody, 'remove_body': RemoveBody,
            'set_material': SetMaterial, 'rollout': Rollout, 'set_parameters': Reconfigure}
CHANGES = (AddBody, RemoveBody, SetMaterial, Reconfigure)  # of the scene, which keeps its name
TOPICS = {'~grasp_command': GraspCommand, '~obstacle': Obstacle, '~grasp/hand/target': PoseStamped,
          '~grasp/pin_sheet_corner_2/target': PoseStamped, '/tf': TFMessage, '/tf_static': TFMessage,
          '~interactive_markers/feedback': InteractiveMarkerFeedback,
          '~follow_trajectory/goal': FollowGraspTrajectoryActionGoal, '~follow_trajectory/cancel': GoalID}
MOST_STEPS = 5          # of one granted call: what is between this and the node's own limit only takes long
MOST_SECONDS = 0.05
FRESH_STEPS = 5
TOPICS_IN_A_ROW = 20    # fewer than the node's queues hold


class Poisoned(AssertionError):
    """What a message must not do to a node."""


def numbers(message, path=''):
    """All floating point numbers of a message, each with its path."""
    if isinstance(message, float):
        yield path, message
    elif isinstance(message, genpy.Message):
        for slot in message.__slots__:
            yield from numbers(getattr(message, slot), '%s.%s' % (path, slot))
    elif isinstance(message, (list, tuple)) and message and not isinstance(message[0], (int, str)):
        for k, item in enumerate(message):
            yield from numbers(item, '%s[%d]' % (path, k))


def owner_of(message, path):
    """The name of the marker, or the first lines of the message, that the path leads into."""
    marker = re.match(r'\.markers\[(\d+)\]', path)
    if marker and hasattr(message.markers[int(marker.group(1))], 'ns'):
        owner = message.markers[int(marker.group(1))]
        return '%s %d, action %d, scale %s' % (owner.ns, owner.id, owner.action, owner.scale)
    return str(message)[:200]


class MessageFuzz:
    """One seed against the node `name`, which runs `scene` (bodies sheet and line) on demand."""

    def __init__(self, seed, name, scene):
        self.hostile, self.random = Hostile(seed), Hostile(seed + 1).random
        self.name, self.scene = '/' + name, scene
        self.sim = Simulation(name)
        self.proxies = {key: rospy.ServiceProxy(self.name + '/' + key, kind, persistent=True) for key, kind in SERVICES.items()}
        self.publishers = {key: self.publisher(key, kind) for key, kind in TOPICS.items()}
        self.garbage = {key: garbage_class(kind) for key, kind in TOPICS.items()}
        self.listeners = [Listener(self.name + '/' + key, kind, connected=False)
                          for key, kind in (('markers', MarkerArray), ('sheet/state', BodyState), ('line/state', BodyState),
                                            ('status', SimStatus), ('interactive_markers/update', InteractiveMarkerUpdate))]
        self.sent = {'services': 0, 'topics': 0, 'garbage': 0, 'connections': 0}
        self.granted = 0
        self.changed = False
        self.stopped = 0
        self.recent = []  # of this batch, for a report
        self.load()
        self.described = self.sim.description('scene')
        self.fresh = self.history()

    def publisher(self, key, kind):
        return rospy.Publisher(key.replace('~', self.name + '/'), kind, queue_size=TOPICS_IN_A_ROW)

    @property
    def total(self):
        return sum(self.sent.values())

    # --- sending ---

    def batch(self, count):
        """So many messages, then the checks."""
        self.recent = []
        row = 0
        for _ in range(count):
            choice = self.random.random()
            if choice < 0.5 or row >= TOPICS_IN_A_ROW:
                self.call()
                row = 0
            elif choice < 0.9:
                self.publish()
                row += 1
            elif choice < 0.99:
                self.publish_garbage()
                row += 1
            else:
                self.connect_and_babble()
        self.check()

    def call(self):
        key = self.random.choice(list(SERVICES))
        kind = SERVICES[key]
        request = self.hostile.request(kind)
        if kind is SetState:
            request.state = self.sim.get_state(self.hostile.body()).state
        request = self.hostile.hostile(request)
        if kind is Step:
            self.shorten(request)
        if kind is Rollout:
            request.seconds = min(request.seconds, MOST_SECONDS) if request.seconds < 10**3 else request.seconds
            request.deadline = request.deadline or 5.0
        self.recent.append((key, request))
        self.sent['services'] += 1
        try:
            answer = self.proxies[key](request)
        except (genpy.SerializationError, struct.error, UnicodeError):
            return  # what Python cannot even write
        except rospy.ServiceException:
            self.proxies[key] = rospy.ServiceProxy(self.name + '/' + key, kind, persistent=True)
            raise Poisoned('%s did not answer' % key)
        self.changed = self.changed or kind in CHANGES
        if kind is Reconfigure:
            return
        status = getattr(answer, 'status', None)
        code = status.code if status else Status.OK if answer.success else Status.INVALID_ARGUMENT
        if kind is Step and code == Status.INTERNAL and status.message.startswith('no finite state'):
            self.stopped += 1  # of a state or a command that nothing can step; check() sees whether ~reset recovers
        elif code in (Status.INTERNAL, Status.TIMEOUT):
            raise Poisoned('%s answered %d: %s' % (key, code, status.message))
        self.granted += code == Status.OK

    @staticmethod
    def shorten(request):
        if request.steps < 10**6 + 1:
            request.steps = min(request.steps, MOST_STEPS)
        if request.seconds < 10**5:
            request.seconds = min(request.seconds, MOST_SECONDS)

    def publish(self):
        key = self.random.choice(list(TOPICS))
        message = self.hostile.hostile(self.hostile.message(TOPICS[key]))
        self.recent.append((key, message))
        self.sent['topics'] += 1
        try:
            self.publishers[key].publish(message)
        except (genpy.SerializationError, rospy.ROSSerializationException, struct.error, UnicodeError):
            pass

    def publish_garbage(self):
        """Bytes that are no message, well framed."""
        key = self.random.choice(list(TOPICS))
        message = self.garbage[key](self.hostile.bytes(self.hostile.message(TOPICS[key])))
        self.recent.append((key, message.payload))
        self.sent['garbage'] += 1
        self.publishers[key].publish(message)

    def connect_and_babble(self):
        """What no ROS client would say, to the node's TCPROS port."""
        uri = rosgraph.Master('/fuzz').lookupNode(self.name)
        _, _, (_, host, port) = xmlrpc.client.ServerProxy(uri).requestTopic('/fuzz', self.name + '/status', [['TCPROS']])
        field = b'topic=' + self.name.encode() + b'/status'
        header = struct.pack('<I', len(field)) + field
        babble = self.random.choice((b'', b'\0' * 100, b'GET / HTTP/1.0\r\n\r\n', struct.pack('<I', 2**32 - 1), struct.pack('<I', 10**6),
                                     struct.pack('<I', len(header)) + header, struct.pack('<II', 8, 2**31) + b'a=b!',
                                     struct.pack('<I', 3) + b'\xff' * 3))
        self.recent.append(('connection', babble))
        self.sent['connections'] += 1
        with socket.create_connection((host, port), timeout=5) as connection:
            connection.sendall(babble)

    # --- checks ---

    def check(self):
        """The node answers, shows finite numbers alone, and runs as a fresh one after ~reset."""
        if not self.sim.describe().success:
            raise Poisoned('~describe refused')
        self.check_finite()
        # What was published may arrive after the first ~reset, and what an action has begun after the second.
        if not any(self.as_fresh() for _ in range(4)):
            raise Poisoned('after ~reset the simulation is not that of a fresh run')

    def as_fresh(self):
        if self.changed or self.sim.description('scene') != self.described:
            self.load()
            self.changed = False
        return self.history() == self.fresh

    def load(self):
        answer = self.sim.load_scene(file=self.scene)
        if answer.status.code != Status.OK:
            raise Poisoned('the scene of the start is refused: ' + answer.status.message)

    def check_finite(self):
        for listener in self.listeners:
            messages, listener.messages[:] = list(listener.messages), []
            for message in messages:
                for path, number in numbers(message):
                    if not math.isfinite(number):
                        raise Poisoned('%s%s is %g: %s' % (listener.topic, path, number, owner_of(message, path)))

    def history(self):
        """Everything, at the start and after some steps."""
        if not self.sim.reset().success:
            raise Poisoned('~reset refused')
        start = self.everything()
        self.sim.steps(FRESH_STEPS)
        return start, self.everything()

    def everything(self):
        states = [self.sim.state(body) for body in ('sheet', 'line')]
        obstacles = [line for line in self.sim.describe().message.splitlines() if line.split(':')[0] in ('obstacle', 'grasp')]
        return [(state.positions, state.velocities) for state in states], self.sim.description('time'), obstacles

    def settle(self):
        """Waits until the node listens to what is sent."""
        wait_until(lambda: self.publishers['~obstacle'].get_num_connections(), 'the node to listen')
