#!/usr/bin/env python3
"""Obstacles: every shape comes and goes, a hundred at a time; what they let through, and how far bodies are from them."""

import math
import os
import unittest

import rosgraph
import rosnode
import rospy
import rostest
from geometry_msgs.msg import Point, Pose
from shape_msgs.msg import Mesh, MeshTriangle, Plane, SolidPrimitive

from deformable_sim.msg import Obstacle, Octomap
from support import Refusals, SimStatus, Simulation, Status, box

DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'scene', 'data')

TOWEL_ON_TABLE = """
step: {solver: manual, dt: 0.01, integrator: bdf2, linear_solver: multigrid}
bodies:
  - cloth: {name: towel, size: [0.4, 0.4], cells: [20, 20], contact_radius: 0.001, pose: {position: [0, 0, 0.002]},
      material: {areal_density: 0.3, thickness: 0.001, youngs_modulus: 1.0e5, bending_rigidity: [1e-5, 1e-5]}}
colliders:
  - box: {name: table, size: [1, 1, 0.1], pose: {position: [0, 0, -0.05]}}
"""


def pyramid():
    corners = ((0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1))
    faces = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
    return Mesh(vertices=[Point(*map(float, corner)) for corner in corners],
                triangles=[MeshTriangle(vertex_indices=face) for face in faces])


def with_mesh(mesh):
    pose = Pose()
    pose.orientation.w = 1.0
    return Obstacle(name='bad', meshes=[mesh], mesh_poses=[pose])


def at(x, y, z):
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z, pose.orientation.w = x, y, z, 1.0
    return pose


def octomap(name, **fields):
    return Obstacle(name=name, octomaps=[Octomap(**fields)], octomap_poses=[at(3, 0, 0)], friction=0.5)


def tree(name):
    """What octomap_msgs/Octomap carries of a file: all behind its header."""
    with open(os.path.join(DATA, name), 'rb') as stream:
        data = stream.read().split(b'\ndata\n', 1)[1]
    return [byte - 256 if byte > 127 else byte for byte in data]


class Obstacles(Refusals, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sim = Simulation()
        cls.scene = rospy.get_param('/deformable_sim/scene')

    def setUp(self):
        self.assertEqual(self.sim.load_scene(file=self.scene).status.code, Status.OK)
        self.sim.steps(3)

    def test_obstacles_come_and_go(self):
        before = self.sim.everything()
        self.assertEqual(self.sim.add_obstacle(box('crate')).status.code, Status.OK)
        self.assertNotEqual(before, self.sim.everything())
        self.refuse(Status.ALREADY_EXISTS, 'crate', lambda: self.sim.add_obstacle(box('crate')))
        self.assertEqual(self.sim.remove_obstacle('crate').status.code, Status.OK)
        self.assertEqual(before, self.sim.everything())
        self.refuse(Status.NOT_FOUND, 'crate', lambda: self.sim.remove_obstacle('crate'))

    def test_every_shape_is_taken(self):
        pose = Pose()
        pose.position.x, pose.orientation.w = 4.0, 1.0
        shapes = [SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[1, 1, 1]),
                  SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[0.1]),
                  SolidPrimitive(type=SolidPrimitive.CYLINDER, dimensions=[0.4, 0.1]),
                  SolidPrimitive(type=Obstacle.CAPSULE, dimensions=[0.4, 0.1]),
                  SolidPrimitive(type=SolidPrimitive.CONE, dimensions=[0.4, 0.1])]
        many = Obstacle(name='many', primitives=shapes, primitive_poses=[pose] * 5, planes=[Plane(coef=[0, 0, 2, 2])],
                        meshes=[pyramid()], mesh_poses=[pose])
        self.assertEqual(self.sim.add_obstacle(many).status.code, Status.OK)

    def test_bad_obstacles_are_refused(self):
        unknown = box('bad')
        unknown.primitives[0].type = 77
        short = box('bad', size=(0.1, 0.1))
        nan_pose = box('bad')
        nan_pose.primitive_poses[0].position.x = math.nan
        no_pose = box('bad')
        no_pose.primitive_poses = []
        unplaced = box('bad')
        unplaced.meshes = [pyramid()]
        open_mesh = with_mesh(pyramid())
        open_mesh.meshes[0].triangles.pop()
        far_index = with_mesh(pyramid())
        far_index.meshes[0].triangles[0].vertex_indices = [0, 1, 4000000000]
        nan_vertex = with_mesh(pyramid())
        nan_vertex.meshes[0].vertices[0].x = math.nan
        large = with_mesh(pyramid())
        large.meshes[0].triangles *= 60000
        framed = box('bad')
        framed.frame = 'no_such_frame'
        rough = box('bad')
        rough.friction = math.nan
        for code, word, obstacle in ((Status.INVALID_ARGUMENT, 'type', unknown),
                                     (Status.INVALID_ARGUMENT, 'dimensions', short),
                                     (Status.INVALID_ARGUMENT, 'finite', nan_pose),
                                     (Status.INVALID_ARGUMENT, 'primitive_poses', no_pose),
                                     (Status.INVALID_ARGUMENT, 'mesh_poses', unplaced),
                                     (Status.INVALID_ARGUMENT, 'meshes[0]: is not closed', open_mesh),
                                     (Status.INVALID_ARGUMENT, 'names vertex 4 of 4', far_index),
                                     (Status.INVALID_ARGUMENT, 'vertex 0', nan_vertex),
                                     (Status.OUT_OF_RANGE, 'at most 200000', large),
                                     (Status.UNAVAILABLE, 'no_such_frame', framed),
                                     (Status.INVALID_ARGUMENT, 'friction', rough),
                                     (Status.OUT_OF_RANGE, 'dimensions', box('bad', size=(0.1, -0.1, 0.1))),
                                     (Status.INVALID_ARGUMENT, '', box('bad', size=(0.1, 0.0, 0.1))),
                                     (Status.INVALID_ARGUMENT, 'shape', Obstacle(name='bad')),
                                     (Status.INVALID_ARGUMENT, 'letter', box('bad name'))):
            with self.subTest(word=word):
                self.refuse(code, word, lambda o=obstacle: self.sim.add_obstacle(o))

    def test_an_octomap_comes_as_message_and_as_file(self):
        # The block of the map is 0 ... 0.2 m along each axis, 3 m aside: the pinned sheet is this far from it.
        tall = at(3, 0, 0)
        distances = []
        for name, fields in (('message', dict(binary=True, id='OcTree', resolution=0.05, data=tree('blocks.bt'))),
                             ('full', dict(binary=False, id='OcTree', resolution=0.05, data=tree('blocks.ot'))),
                             ('colour', dict(binary=False, id='ColorOcTree', resolution=0.05,
                                             data=tree('blocks_color.ot'))),
                             ('path', dict(file=os.path.join(DATA, 'blocks.bt'))),
                             ('url', dict(file='file://' + os.path.join(DATA, 'blocks.ot'))),
                             ('package', dict(file='package://deformable_sim/test/scene/data/blocks.bt'))):
            with self.subTest(name=name):
                answer = self.sim.add_obstacle(octomap(name, **fields))
                self.assertEqual(answer.status.code, Status.OK, answer.status.message)
                answer = self.sim.get_distance(body='sheet', obstacles=[name])
                self.assertEqual(answer.status.code, Status.OK, answer.status.message)
                self.assertEqual((answer.obstacle, answer.link, answer.header.frame_id), (name, '', 'world'))
                distances.append(answer.distance)
                self.assertEqual(self.sim.remove_obstacle(name).status.code, Status.OK)
        self.assertLess(max(distances) - min(distances), 1e-8)
        moved = octomap('map', file=os.path.join(DATA, 'blocks.bt'))
        self.assertEqual(self.sim.add_obstacle(moved).status.code, Status.OK)
        near = self.sim.get_distance(body='sheet', obstacles=['map']).on_obstacle
        # The lone voxel, 0.25 m before the block, is the nearest to the sheet at x <= 0.15.
        self.assertAlmostEqual(near.x, tall.position.x - 0.25, delta=1e-6)

    def test_bad_octomaps_are_refused(self):
        good = dict(binary=True, id='OcTree', resolution=0.05, data=tree('blocks.bt'))
        unplaced = octomap('bad', **good)
        unplaced.octomap_poses = []
        for code, word, obstacle in (
                (Status.INVALID_ARGUMENT, 'octomap_poses', unplaced),
                (Status.INVALID_ARGUMENT, 'octomaps[0]: octree id', octomap('bad', **{**good, 'id': 'RoughOcTree'})),
                (Status.INVALID_ARGUMENT, 'resolution', octomap('bad', **{**good, 'resolution': math.nan})),
                (Status.INVALID_ARGUMENT, 'resolution', octomap('bad', **{**good, 'resolution': 0.0})),
                (Status.INVALID_ARGUMENT, 'ends early', octomap('bad', **{**good, 'data': good['data'][:-1]})),
                (Status.INVALID_ARGUMENT, '1 bytes follow', octomap('bad', **{**good, 'data': good['data'] + [0]})),
                (Status.INVALID_ARGUMENT, 'deeper than 16', octomap('bad', **{**good, 'data': [-1] * 1000})),
                (Status.INVALID_ARGUMENT, 'no occupied space', octomap('bad', **{**good, 'data': []})),
                (Status.INVALID_ARGUMENT, 'outside of the folders', octomap('bad', file='/no/such/map.bt')),
                (Status.INVALID_ARGUMENT, 'outside of the folders', octomap('bad', file='package://deformable_sim/../../map.bt')),
                (Status.INVALID_ARGUMENT, 'outside of the folders', octomap('bad', file='file:///etc/passwd')),
                (Status.INVALID_ARGUMENT, 'file:// or package://', octomap('bad', file='http://127.0.0.1:1/map.bt')),
                (Status.NOT_FOUND, 'octomaps[0]', octomap('bad', file='package://no_such_package/map.bt')),
                (Status.INVALID_ARGUMENT, 'not an OctoMap file', octomap('bad', file=os.path.join(DATA, 'quad.obj')))):
            with self.subTest(word=word):
                self.refuse(code, word, lambda o=obstacle: self.sim.add_obstacle(o))

    def test_distances_are_those_to_the_nearest_obstacle(self):
        # Free fall of nothing: the sheet hangs in the plane y = 0; a ball of R = 0.05 is 0.2 m before its middle.
        self.assertEqual(self.sim.load_scene(yaml=open(self.scene).read().replace(
            'air:', 'gravity: [0, 0, 0]\nair:')).status.code, Status.OK)
        self.sim.steps(1)
        ball = Obstacle(name='ball', primitives=[SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[0.05])],
                        primitive_poses=[at(0.013, 0.2, 1.017)])
        self.assertEqual(self.sim.add_obstacle(ball).status.code, Status.OK)
        answer = self.sim.get_distance(body='sheet')
        self.assertEqual((answer.status.code, answer.obstacle), (Status.OK, 'ball'))
        self.assertAlmostEqual(answer.distance, 0.2 - 0.05 - 0.001, delta=1e-7)
        self.assertAlmostEqual(answer.on_obstacle.y, 0.15, delta=1e-7)
        self.assertAlmostEqual(answer.on_body.y, 0.001, delta=1e-7)
        self.assertEqual(self.sim.let_through('ball', ['sheet']).status.code, Status.OK)
        self.assertEqual(self.sim.get_distance(body='sheet').obstacle, 'table')
        self.assertEqual(self.sim.get_distance(body='sheet', obstacles=['ball']).obstacle, 'ball')
        for code, word, arguments in ((Status.NOT_FOUND, 'sheet', dict(body='nobody')),
                                      (Status.NOT_FOUND, "'cave' is not in the world; there are table, ball",
                                       dict(body='sheet', obstacles=['cave']))):
            self.refuse(code, word, lambda a=arguments: self.sim.get_distance(**a))
        self.sim.let_through('table', ['sheet'])
        self.refuse(Status.NOT_FOUND, 'may touch', lambda: self.sim.get_distance(body='sheet'))

    def test_what_is_let_through_is_not_touched_until_it_is_stopped_again(self):
        self.assertEqual(self.sim.load_scene(yaml=TOWEL_ON_TABLE).status.code, Status.OK)
        self.assertEqual(self.sim.let_through('table', ['towel']).status.code, Status.OK)
        self.sim.steps(20)
        self.assertLess(max(self.sim.state('towel').positions[2::3]), -0.05)
        self.assertTrue(self.sim.reset().success)
        self.sim.steps(20)
        self.assertGreater(min(self.sim.state('towel').positions[2::3]), 0.0005)
        passing = Obstacle(name='ghost', primitives=[SolidPrimitive(type=SolidPrimitive.BOX, dimensions=[0.1] * 3)],
                           primitive_poses=[at(0, 0, 0)], lets_through=['towel'])
        self.assertEqual(self.sim.add_obstacle(passing).status.code, Status.OK)
        self.sim.steps(20)
        self.assertLess(max(self.sim.state('towel').positions[2::3]), 0.0015)
        passing.name, passing.lets_through = 'other', ['nobody']
        for answer in (self.sim.add_obstacle(passing), self.sim.let_through('cave', []),
                       self.sim.let_through('table', ['nobody'])):
            self.assertEqual(answer.status.code, Status.NOT_FOUND)
        self.assertEqual(self.sim.let_through('', []).status.code, Status.INVALID_ARGUMENT)

    def test_a_hundred_come_and_go_under_a_towel(self):
        # Ten rounds of a hundred boxes and balls that rise 5 mm out of the table, where the towel lies: it is lifted,
        # nothing of it is deeper than half a millimetre once it has come out, and the node is as large as before.
        self.assertEqual(self.sim.load_scene(yaml=TOWEL_ON_TABLE).status.code, Status.OK)
        self.sim.steps(20)
        status = self.sim.listen('status', SimStatus)
        uri = rosnode.get_api_uri(rosgraph.Master('/test'), '/deformable_sim')
        pid = rosnode.ServerProxy(uri).getPid('/test')[2]

        def memory():
            with open('/proc/%d/statm' % pid) as numbers:
                return int(numbers.read().split()[1]) * os.sysconf('SC_PAGE_SIZE') / 2**20

        sizes, deepest = [], []
        for turn in range(10):
            for k in range(100):
                kind, size, z = ((SolidPrimitive.BOX, [0.03, 0.03, 0.01], 0.0), (SolidPrimitive.SPHERE, [0.02], -0.015))[k % 2]
                spot = Obstacle(name='o%d' % k, primitives=[SolidPrimitive(type=kind, dimensions=size)], friction=0.5,
                                primitive_poses=[at(0.04 * (k % 10) - 0.18, 0.04 * (k // 10) - 0.18, z)])
                self.assertEqual(self.sim.add_obstacle(spot).status.code, Status.OK)
                if k % 10 == 9:
                    self.sim.steps(1)
            time = self.sim.steps(10)
            deepest.append(status.wait(lambda m: abs(m.time - time) < 1e-6).max_penetration)
            heights = self.sim.state('towel').positions[2::3]
            self.assertTrue(all(math.isfinite(z) for z in heights))
            self.assertGreater(max(heights), 0.005)
            self.assertGreater(min(heights), 0.0)
            for k in range(100):
                self.assertEqual(self.sim.remove_obstacle('o%d' % k).status.code, Status.OK)
                if k % 10 == 9:
                    self.sim.steps(1)
            self.sim.steps(20)
            self.assertLess(max(self.sim.state('towel').positions[2::3]), 0.005)
            sizes.append(memory())
        self.assertLess(max(deepest), 5e-4)
        # What is kept for reuse is there after two rounds; 800 more obstacles would be 3 MiB at 4 kB each.
        self.assertLess(sizes[-1], sizes[1] + 2.0)
        print('memory after each round, MiB: %s' % ' '.join('%.1f' % size for size in sizes))
        status.close()


if __name__ == '__main__':
    rospy.init_node('obstacles_test')
    rostest.rosrun('deformable_sim', 'obstacles', Obstacles)
