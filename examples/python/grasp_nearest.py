#!/usr/bin/env python3
"""Grasps a body at the node nearest to a point, lifts it, says how hard it pulls, and lets go.

    roslaunch deformable_sim simulation.launch scene:=towel_on_table clock:=on_demand rviz:=false
    rosrun deformable_sim grasp_nearest.py --point 0.55 0 0.8
"""

import argparse
import sys

import numpy
import rospy

import deformable_sim
from deformable_sim.msg import GraspStateArray


def grasp_and_lift(sim, body, point, radius, height, seconds):
    """(node held, m it was lifted by, N it pulls down with)."""
    sim.step(seconds=seconds)  # it comes to rest
    before = sim.get_state(body)
    if point is None:
        point = before.positions[0]
    node = sim.grasp_nearest('example', body, point, radius)
    grasps = sim.listen('grasps', GraspStateArray)
    try:
        hand = before.positions[node]
        sim.move_grasp('example', hand + [0.0, 0.0, height], duration=seconds)
        sim.step(seconds=2 * seconds)
        after = sim.get_state(body)
        held = next(g for g in grasps.at(after.stamp, sim.timeout).grasps if g.name == 'example')
    finally:
        grasps.close()
        sim.release('example')
    return node, after.positions[node, 2] - hand[2], -held.wrench.force.z


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--node', default='deformable_sim', help='name of the simulation node')
    parser.add_argument('--body', help='default: the first of the scene')
    parser.add_argument('--point', type=float, nargs=3, metavar=('X', 'Y', 'Z'), help='m; default: where node 0 is')
    parser.add_argument('--radius', type=float, default=0.1, help='m, how far the node may be')
    parser.add_argument('--height', type=float, default=0.2, help='m')
    parser.add_argument('--seconds', type=float, default=1.0, help='simulated, of the lift')
    arguments = parser.parse_args(rospy.myargv()[1:])
    try:
        sim = deformable_sim.connect('grasp_nearest', arguments.node)
        sim.pause()  # whatever its clock: time passes in step() alone
        body = arguments.body or sim.bodies()[0].name
        point = None if arguments.point is None else numpy.array(arguments.point)
        node, lifted, force = grasp_and_lift(sim, body, point, arguments.radius, arguments.height, arguments.seconds)
    except deformable_sim.SimulationError as error:
        sys.exit('grasp_nearest: %s' % error)
    print('held node %d of %s, lifted it by %.3f m, and it pulled with %.3f N' % (node, body, lifted, force))


if __name__ == '__main__':
    main()
