"""Seeded messages that nobody means: valid ones with some fields made extreme, and ones that are random all over."""

import io
import random
import struct

import genpy
import rospy
from actionlib_msgs.msg import GoalID
from dynamic_reconfigure.msg import BoolParameter, DoubleParameter, StrParameter
from dynamic_reconfigure.srv import Reconfigure
from geometry_msgs.msg import Pose, PoseStamped, TransformStamped
from shape_msgs.msg import Mesh, MeshTriangle, Plane, SolidPrimitive
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import InteractiveMarkerFeedback

from deformable_sim.msg import (FollowGraspTrajectoryActionGoal, GraspCommand, GraspSelection, GraspTrajectory,
                                GraspTrajectoryPoint, Obstacle, Octomap, RolloutPlan, TimedGraspCommand)
from deformable_sim.srv import (AddBody, AddObstacle, GetDistance, GetState, Grasp, LetThrough, LoadScene, MoveGrasp, Release,
                                RemoveBody, RemoveObstacle, RestoreState, Rollout, SaveState, SetMaterial, SetState, Step)

FLOATS = (0.0, -0.0, 1.0, -1.0, 0.01, 1e-9, 5e-324, 1e9, 1e30, 1e308, -1e308, float('inf'), float('-inf'), float('nan'))
WORDS = ('', 'a', 'A_1', '1', 'sheet', 'line', 'nobody', 'hand', 'pin_sheet_corner_2', 'table', 'ball', 'robot.hand', 'world',
         'tool', 'loop_a', '/world', 'no_such_frame', 'corner_0', 'end_1', 'edge_9', '../x', 'a b', 'a/b', '~', '/', '\x00', '\n',
         '%s%n', '\u00e4\u20ac\U0001f600', 'x' * 70, 'y' * 20000, 'NaN', 'position')
FILES = ('', '/etc/passwd', '../../etc/passwd', '/dev/zero', '/dev/stdin', '/proc/self/mem', 'file:///etc/passwd', 'FILE:///etc/passwd',
         'http://127.0.0.1:1/x.bt', 'gopher://127.0.0.1:1/x', 'package://deformable_sim/../../../../etc/passwd', 'package://',
         'package://no_such_package/x', 'package://deformable_sim/test/scene/data/blocks.bt', 'hanging_sheet', 'minimal', '.', '..',
         'a\x00b', 'x' * 5000, '/' * 4000, '../' * 1000 + 'etc/passwd')
SCENES = ('bodies:\n  - rope: {name: line, segments: 4}\n',
          'bodies:\n  - cloth: {name: sheet, size: [0.2, 0.2], cells: [3, 3], pins: [corner_0],\n'
          '      look: {checker: 0.05, seams: 0.02, thickness: 0.001}}\n'
          'colliders:\n  - sphere: {name: ball, radius: 0.05}\n',
          'gravity: [0, 0, -9.81]\nstep: {dt: 0.005, integrator: bdf2}\noutputs: {shadows: true, contact_arrows: true, color_by: contact}\n'
          'bodies:\n  - soft: {name: block, box: {size: [0.1, 0.1, 0.1], cells: [1, 1, 1]}}\n')
BODIES = ('bodies: [{rope: {name: cord, segments: 4, pose: {position: [0, 5, 1]}}}]', 'bodies: [{rope: {name: line}}]', SCENES[1],
          'bodies:\n  - cloth: {name: extra, size: [0.2, 0.2], cells: [3, 3], touches: all, pins: [corner_0]}\n')
MATERIALS = ('{damping: 0.01}', '{youngs_modulus: 100000}', '{diameter: 0.01}', 'denim_11oz_black', 'damping: 0.001\nthickness: 0.001')
LIVE = ('gravity_z', 'wind_x', 'air_damping', 'friction', 'tolerance', 'accuracy', 'strain_range')
SHOWN = ('wireframe', 'shadows', 'contact_arrows', 'legend')
SCENE_WORDS = ('nan', '.inf', '-1', '1e308', '1000000000', '[]', '{}', '&a *a', '[1e9, 1e9]', 'null', '"', ': :', 'name', 'bodies',
               'mesh: /etc/passwd', '\t', '- -', '999999999999999999999')
INTEGERS = {'int8': (-2**7, 2**7 - 1), 'uint8': (0, 2**8 - 1), 'byte': (-2**7, 2**7 - 1), 'char': (0, 2**8 - 1),
            'int16': (-2**15, 2**15 - 1), 'uint16': (0, 2**16 - 1), 'int32': (-2**31, 2**31 - 1), 'uint32': (0, 2**32 - 1),
            'int64': (-2**63, 2**63 - 1), 'uint64': (0, 2**64 - 1)}


def garbage_class(kind):
    """Messages that pass for `kind`, and whose bytes are what `payload` says."""
    return type('Garbage', (genpy.Message,), {'__slots__': ['payload'], '_slot_types': ['string'], '_type': kind._type,
                                              '_md5sum': kind._md5sum, '_full_text': kind._full_text, '_has_header': False,
                                              'serialize': lambda self, buffer: buffer.write(self.payload)})


def pose(x=0.0, y=0.0, z=1.0):
    result = Pose()
    result.position.x, result.position.y, result.position.z, result.orientation.w = x, y, z, 1.0
    return result


class Hostile:
    """Requests and messages for one node, from a seed."""

    def __init__(self, seed):
        self.random = random.Random(seed)

    # --- what is valid ---

    def near(self):
        return self.random.uniform(-0.3, 0.3)

    def stamped(self):
        message = PoseStamped(pose=pose(self.near(), self.near(), 1.0 + self.near()))
        message.header.frame_id = self.random.choice(('', '', 'world', 'tool'))
        return message

    def selection(self):
        message = GraspSelection(method=self.random.randrange(5), pose=self.stamped(), radius=0.05,
                                 nodes=[self.random.randrange(99) for _ in range(3)], feature='corner_1')
        message.pose.header.frame_id = ''
        message.size.x = message.size.y = message.size.z = 0.1
        return message

    def name(self):
        return self.random.choice(('hand', 'other', 'pin_sheet_corner_2', 'a', 'b', 'c'))

    def body(self):
        return self.random.choice(('sheet', 'line'))

    def tetrahedron(self):
        mesh = Mesh(triangles=[MeshTriangle(vertex_indices=t) for t in ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))])
        mesh.vertices = [pose(*p).position for p in ((0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1))]
        return mesh

    def obstacle(self):
        message = Obstacle(action=self.random.randrange(3), name=self.random.choice(('table', 'ball', 'a', 'b')), friction=0.5)
        kind = self.random.choice((1, 1, 2, 3, 4, 100))
        message.primitives = [SolidPrimitive(type=kind, dimensions=[0.1] * {1: 3, 2: 1}.get(kind, 2))]
        message.primitive_poses = [pose(3.0, self.near(), self.near())]
        extra = self.random.randrange(12)
        if extra == 0:
            message.meshes, message.mesh_poses = [self.tetrahedron()], [pose(4.0)]
        elif extra == 1:
            message.planes = [Plane(coef=[0, 0, 1, 5])]
        elif extra == 2:
            message.octomaps = [Octomap(binary=True, id='OcTree', resolution=0.1, data=[0, 0])]
            message.octomap_poses = [pose(5.0)]
        elif extra == 3:
            message.octomaps, message.octomap_poses = [Octomap(file=self.random.choice(FILES))], [pose(5.0)]
        if self.random.random() < 0.1:
            message.frame = 'tool'
        return message

    def command(self):
        return GraspCommand(action=self.random.randrange(3), name=self.name(), body=self.body(), selection=self.selection(),
                            target=self.stamped(), max_speed=0.5)

    def trajectory(self):
        times = sorted(self.random.random() for _ in range(self.random.randrange(4)))
        points = [GraspTrajectoryPoint(rospy.Duration(t), self.stamped().pose) for t in times]
        return GraspTrajectory(grasp=self.name(), points=points)

    def goal(self):
        message = FollowGraspTrajectoryActionGoal()
        message.goal_id.id = self.random.choice(('', 'a', 'b', 'c'))
        message.goal.trajectories = [self.trajectory() for _ in range(self.random.randrange(3))]
        message.goal.allow_partial = self.random.random() < 0.5
        return message

    def plan(self):
        commands = [TimedGraspCommand(time=rospy.Duration(0.01 * k), command=self.command()) for k in range(self.random.randrange(3))]
        return RolloutPlan(commands=commands, trajectories=[self.trajectory() for _ in range(self.random.randrange(3))])

    def values(self, request):
        result = request()
        result.config.doubles = [DoubleParameter(self.random.choice(LIVE), self.random.choice(FLOATS + (0.3, 0.02)))]
        result.config.bools = [BoolParameter(self.random.choice(SHOWN), self.random.random() < 0.5)]
        result.config.strs = [StrParameter('color_by', self.random.choice(('strain', 'body', 'contact', 'mood', '')))]
        return result

    def scene(self, texts=SCENES):
        text = self.random.choice(texts)
        for _ in range(self.random.randrange(4)):
            at, length = self.random.randrange(len(text)), self.random.randrange(6)
            text = text[:at] + self.random.choice(SCENE_WORDS) + text[at + length:]
        return text

    def saved(self, request):
        name = self.random.choice(('a', 'b'))
        return request(name=name) if self.random.random() < 0.7 else request(file=name)

    def transforms(self):
        message = TransformStamped(child_frame_id=self.random.choice(('tool', 'tool', 'loop_a', 'loop_b')))
        message.header.frame_id = self.random.choice(('world', 'loop_a', 'loop_b'))
        message.header.stamp = rospy.Time.from_sec(self.random.choice((0.0, 1.0, 1e6, rospy.get_time())))
        message.transform.rotation.w = 1.0
        return TFMessage(transforms=[message])

    def request(self, kind):
        """A request of the service class `kind` that may well be granted."""
        make = {
            Grasp: lambda q: q(name=self.name(), body=self.body(), selection=self.selection(), max_force=5.0, max_speed=0.5),
            MoveGrasp: lambda q: q(name=self.name(), target=self.stamped(), duration=rospy.Duration(self.random.choice((0, 1)))),
            Release: lambda q: q(name=self.random.choice(('', self.name()))),
            SetBool: lambda q: q(data=self.random.random() < 0.5),
            Trigger: lambda q: q(),
            Step: lambda q: q(steps=self.random.choice((1, 1, 2, 5))),
            LoadScene: lambda q: q(file=self.random.choice(FILES)) if self.random.random() < 0.5 else q(yaml=self.scene()),
            AddObstacle: lambda q: q(obstacle=self.obstacle()),
            RemoveObstacle: lambda q: q(name=self.random.choice(('table', 'ball', 'a', 'b'))),
            LetThrough: lambda q: q(obstacle=self.random.choice(('table', 'ball', 'a')), bodies=[self.body()]),
            GetDistance: lambda q: q(body=self.body(), obstacles=self.random.choice(([], ['table'], ['ball', 'a']))),
            GetState: lambda q: q(body=self.body()),
            SetState: lambda q: q(),
            AddBody: lambda q: q(yaml=self.scene(BODIES), pose=self.stamped() if self.random.random() < 0.3 else PoseStamped()),
            RemoveBody: lambda q: q(body=self.random.choice(('line', 'cord', 'extra', 'nobody'))),
            SetMaterial: lambda q: q(body=self.body(), yaml=self.scene(MATERIALS)),
            Rollout: lambda q: q(plans=[self.plan() for _ in range(self.random.randrange(4))], seconds=0.05, sample_period=0.01,
                                 with_positions=self.random.random() < 0.5, with_contacts=self.random.random() < 0.5),
            Reconfigure: self.values,
            SaveState: lambda q: self.saved(q),
            RestoreState: lambda q: self.saved(q),
        }
        return make[kind](kind._request_class)

    def message(self, kind):
        make = {
            GraspCommand: self.command,
            FollowGraspTrajectoryActionGoal: self.goal,
            GoalID: lambda: GoalID(id=self.random.choice(('', 'a', 'b'))),
            Obstacle: self.obstacle,
            PoseStamped: self.stamped,
            TFMessage: self.transforms,
            InteractiveMarkerFeedback: lambda: InteractiveMarkerFeedback(
                event_type=self.random.randrange(7), marker_name=self.name(), control_name='move', pose=pose(self.near()),
                client_id='a'),
        }
        return make[kind]()

    # --- what is not ---

    def scalar(self, kind):
        if kind in INTEGERS:
            low, high = INTEGERS[kind]
            return max(low, min(high, self.random.choice((low, high, 0, 1, 2, 3, high // 2, self.random.randint(low, high)))))
        if kind == 'bool':
            return self.random.random() < 0.5
        if kind in ('float32', 'float64'):
            value = self.random.choice(FLOATS + (self.random.uniform(-1, 1),))
            return 3e38 if kind == 'float32' and abs(value) > 3e38 else value
        if kind in ('time', 'duration'):
            whole = self.random.choice((0, 1, 2**31 - 1) + ((2**32 - 1,) if kind == 'time' else ()))
            parts = self.random.choice((0, 1, 999999999))
            return genpy.Time(whole, parts) if kind == 'time' else genpy.Duration(whole, parts)
        return self.random.choice(FILES if self.random.random() < 0.2 else WORDS)

    def value(self, kind, depth=0):
        """Random all over, of the type that a message definition calls `kind`."""
        base, is_array, length = split(kind)
        if is_array:
            count = length if length is not None else self.random.choice((0, 0, 1, 2, 3, 6, 12, 297, 1000 if depth < 1 else 1))
            if base in ('uint8', 'char') and length is not None:
                return bytes(self.random.randrange(256) for _ in range(count))
            return [self.value(base, depth + 1) for _ in range(count)]
        if base in INTEGERS or base in ('bool', 'float32', 'float64', 'string', 'time', 'duration'):
            return self.scalar(base)
        message = genpy.message.get_message_class('std_msgs/Header' if base == 'Header' else base)()
        for slot, slot_kind in zip(message.__slots__, message._slot_types):
            setattr(message, slot, self.value(slot_kind, depth + 1))
        return message

    def spoil(self, message, changes):
        """Replaces so many fields, anywhere in the message, by extremes."""
        for _ in range(changes):
            at = message
            while True:
                slot = self.random.randrange(len(at.__slots__)) if at.__slots__ else None
                if slot is None:
                    return message
                name, kind = at.__slots__[slot], at._slot_types[slot]
                inner = getattr(at, name)
                if isinstance(inner, list) and inner and isinstance(inner[0], genpy.Message) and self.random.random() < 0.7:
                    inner = self.random.choice(inner)
                if isinstance(inner, genpy.Message) and self.random.random() < 0.95:
                    at = inner
                    continue
                setattr(at, name, self.value(kind, 1))
                break
        return message

    def hostile(self, valid):
        """The valid message as it is, spoiled, or random all over."""
        kind = self.random.random()
        if kind < 0.25:
            return valid
        if kind < 0.9:
            return self.spoil(valid, self.random.choice((1, 1, 1, 2, 5)))
        return self.value(valid._type) if not valid._type.endswith('Request') else self.spoil(valid, 20)

    def bytes(self, valid):
        """The serialised message cut, lengthened, or with counts and bytes changed."""
        buffer = io.BytesIO()
        valid.serialize(buffer)
        data = bytearray(buffer.getvalue())
        for _ in range(self.random.choice((1, 1, 3))):
            at = self.random.randrange(len(data) + 1)
            change = self.random.randrange(4)
            if change == 0:
                del data[at:]
            elif change == 1:
                data[at:at] = bytes(self.random.randrange(256) for _ in range(self.random.randrange(40)))
            elif change == 2:
                data[at:at + 4] = struct.pack('<I', self.random.choice((0, 1, 1000, 2**24, 2**31 - 1, 2**31, 2**32 - 1)))
            else:
                data[at:at + 8] = struct.pack('<d', self.random.choice(FLOATS))
        return bytes(data)


def split(kind):
    """`float64[3]` as (float64, True, 3)."""
    if not kind.endswith(']'):
        return kind, False, None
    base, count = kind[:-1].split('[')
    return base, True, int(count) if count else None
