#!/usr/bin/env python3
"""Plays random grasps and records what the body does: a rosbag an episode, every step of it in lock-step.

    roslaunch deformable_sim simulation.launch scene:=towel_on_table clock:=on_demand rviz:=false
    rosrun deformable_sim collect_dataset.py --out dataset --episodes 10

Each step is one message of each topic, all with one stamp, which is also their time in the bag: state and cloud of the
body, the grasps, and where the gripper was sent. An episode depends on its seed, the scene and the options alone.
"""

import argparse
import os
import sys

import numpy
import rosbag
import rospy
from sensor_msgs.msg import PointCloud2

import deformable_sim
from deformable_sim import Environment, Grasp, MoveTo
from deformable_sim.msg import BodyState, GraspStateArray
from deformable_sim.selection import pose_stamped

GRIPPER = 'gripper'


def topics_of(body):
    return {body + '/state': BodyState, body + '/points': PointCloud2, 'grasps': GraspStateArray}


def target_topic():
    return 'grasp/%s/target' % GRIPPER


def record_episode(environment, body, seed, steps, reach, path):
    """Writes one bag; returns the last observation. reach: m, how far a target may be from where the gripper took hold."""
    sim = environment.simulation
    random = numpy.random.default_rng(seed)
    observation = environment.reset(seed)
    positions = observation.states[body].positions
    node = int(random.integers(len(positions)))
    home = positions[node]
    # Complete or not there: a reader never takes an episode that was cut for a whole one.
    with rosbag.Bag(path + '.part', 'w') as bag:
        for step in range(steps):
            goal = home + random.uniform([-reach, -reach, 0.0], [reach, reach, reach])
            commands = [MoveTo(goal)]
            if step == 0:
                commands.insert(0, Grasp(body, deformable_sim.nodes([node])))
            observation, _, _, info = environment.step({GRIPPER: commands})
            for _, refusal in info['refused']:
                raise refusal
            stamp = observation.states[body].stamp
            for name, message in observation.messages.items():
                bag.write(sim.topic(name), message, stamp)
            target = pose_stamped(goal, frame_id=observation.states[body].frame_id)
            target.header.stamp = stamp
            bag.write(sim.topic(target_topic()), target, stamp)
    os.rename(path + '.part', path)
    return observation


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--node', default='deformable_sim', help='name of the simulation node')
    parser.add_argument('--body', help='default: the first of the scene')
    parser.add_argument('--out', default='dataset', help='folder of the bags')
    parser.add_argument('--episodes', type=int, default=3)
    parser.add_argument('--steps', type=int, default=20, help='of an episode')
    parser.add_argument('--seconds', type=float, default=0.1, help='simulated, of a step')
    parser.add_argument('--reach', type=float, default=0.1, help='m')
    parser.add_argument('--seed', type=int, default=0, help='of the first episode; the next has the next')
    arguments = parser.parse_args(rospy.myargv()[1:])
    os.makedirs(arguments.out, exist_ok=True)
    try:
        sim = deformable_sim.connect('collect_dataset', arguments.node)
        body = arguments.body or sim.bodies()[0].name
        environment = Environment(sim, bodies=[body], grippers=[GRIPPER], topics=topics_of(body),
                                  steps=max(1, int(round(arguments.seconds / sim.dt()))))
        for seed in range(arguments.seed, arguments.seed + arguments.episodes):
            path = os.path.join(arguments.out, 'episode_%04d.bag' % seed)
            last = record_episode(environment, body, seed, arguments.steps, arguments.reach, path)
            print('%s: %d steps to %.2f s, %s' % (path, arguments.steps, last.time, last.digest()[:12]), flush=True)
    except deformable_sim.SimulationError as error:
        sys.exit('collect_dataset: %s' % error)


if __name__ == '__main__':
    main()
