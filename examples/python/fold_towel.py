#!/usr/bin/env python3
"""Two grippers take two corners of a towel and lay them on the other two.

    roslaunch deformable_sim simulation.launch clock:=on_demand
    rosrun deformable_sim fold_towel.py

The towel and its table are brought along; --keep folds what the node has. Ends with the distances of the corners from their
goals, and with exit status 1 when they are too far.
"""

import argparse
import sys

import numpy
import rospy
from sensor_msgs.msg import PointCloud2

import deformable_sim
from deformable_sim import Environment, Grasp, MoveTo, Release

ABOVE = 0.01  # m: how far above its goal a corner is let go
GOOD = 0.03   # m
SCENE = """
title: A soft towel that feels itself, on a table
step: {dt: 0.01, integrator: implicit_euler, newton_iterations: 8}
air: {damping: 1}                            # 1/s
bodies:
  - cloth:
      name: towel
      touches: all
      pose: {position: [0, 0, 0.752]}
      size: [0.4, 0.4]
      cells: [16, 16]
      contact_radius: 0.0015
      friction: 0.6
      material: {areal_density: 0.3, membrane_stiffness: 300, poissons_ratio: 0.2, bending_rigidity: 5.0e-6}
colliders:
  - box: {name: table, size: [0.8, 0.8, 0.04], pose: {position: [0, 0, 0.73]}}
"""


def corners(sim, body):
    """Nodes of a grid cloth's corners, 2 x 2: rows by columns of its cloud."""
    points = sim.listen(body + '/points', PointCloud2)
    try:
        cloud = points.at(sim.get_state(body).stamp, sim.timeout)
    finally:
        points.close()
    nodes = deformable_sim.cloud_array(cloud)['node']
    if nodes.shape[0] < 2:
        raise SystemExit('fold_towel: %s is no grid cloth' % body)
    return nodes[[0, 0, -1, -1], [0, -1, 0, -1]].reshape(2, 2).astype(int)


def on_the_way(start, goal, part):
    """Half a circle over the crease, slow at both ends. part: 0 ... 1 of its time."""
    angle = numpy.pi * part * part * (3.0 - 2.0 * part)
    arm = 0.5 * (start - goal)
    up = numpy.linalg.norm(arm) * numpy.sin(angle) + ABOVE * 0.5 * (1.0 - numpy.cos(angle))
    return 0.5 * (start + goal) + numpy.cos(angle) * arm + [0.0, 0.0, up]


def fold(environment, body, nodes, seconds, rest, seed=None):
    """One episode: the observation after it, and the sum of rewards. seconds, rest: simulated, of the fold and after it."""
    observation = environment.reset(seed)
    step = environment.steps * environment.simulation.dt()
    hands = [(gripper, start, goal, observation.states[body].positions[start])
             for gripper, start, goal in zip(environment.grippers, nodes[1], nodes[0])]
    total = 0.0

    def act(action):
        nonlocal observation, total
        observation, reward, _, info = environment.step(action)
        for _, refusal in info['refused']:
            raise refusal
        total += reward

    act({gripper: Grasp(body, deformable_sim.nodes([start])) for gripper, start, _, _ in hands})
    carry = int(round(seconds / step))
    for i in range(1, carry + 1):
        # The goals are looked at anew each time: the towel slides a little under the pull.
        positions = observation.states[body].positions
        act({gripper: MoveTo(on_the_way(home, positions[goal], i / carry)) for gripper, _, goal, home in hands})
    for _ in range(int(round(0.5 * rest / step))):
        act({})
    act({gripper: Release() for gripper, _, _, _ in hands})
    for _ in range(int(round(0.5 * rest / step))):
        act({})
    return observation, total


def corner_distances(observation, body, nodes):
    """m, of each folded corner from its goal."""
    positions = observation.states[body].positions
    return numpy.linalg.norm(positions[nodes[1]] - positions[nodes[0]], axis=1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--node', default='deformable_sim', help='name of the simulation node')
    parser.add_argument('--body', help='default: the first of the scene')
    parser.add_argument('--keep', action='store_true', help='fold the scene that is running')
    parser.add_argument('--settle', type=float, default=0.2, help='simulated s before the fold')
    parser.add_argument('--seconds', type=float, default=2.0, help='simulated, of the fold')
    parser.add_argument('--rest', type=float, default=1.0, help='simulated s after it')
    arguments = parser.parse_args(rospy.myargv()[1:])
    try:
        sim = deformable_sim.connect('fold_towel', arguments.node)
        if not arguments.keep:
            sim.load_scene(yaml=SCENE)
        body = arguments.body or sim.bodies()[0].name
        nodes = corners(sim, body)
        environment = Environment(sim, bodies=[body], steps=max(1, int(round(0.05 / sim.dt()))),
                                  settle=int(round(arguments.settle / sim.dt())),
                                  reward=lambda observation: -corner_distances(observation, body, nodes).sum())
        observation, total = fold(environment, body, nodes, arguments.seconds, arguments.rest)
    except deformable_sim.SimulationError as error:
        sys.exit('fold_towel: %s' % error)
    distances = corner_distances(observation, body, nodes)
    print('folded %s in %.2f s: corners %.1f and %.1f mm from their goals, reward %.3f' %
          (body, observation.time, 1e3 * distances[0], 1e3 * distances[1], total))
    if distances.max() > GOOD:
        sys.exit('fold_towel: not folded; %.0f mm are allowed' % (1e3 * GOOD))


if __name__ == '__main__':
    main()
