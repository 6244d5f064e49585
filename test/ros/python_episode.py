#!/usr/bin/env python3
"""An episode with two grippers on hanging.yaml, for python_test.py; as a program it prints the digests of two of them and
the times at which the program's ROS clock stood at each observation.

usage: python_episode.py NODE
"""

import json
import sys

import rospy

import deformable_sim
from deformable_sim import Environment, Grasp, MoveTo, Release, feature, nearest


def shake(sim, random):
    """Nodes a millimetre aside, by the seed: what makes episodes differ."""
    state = sim.get_state('line')
    sim.set_state('line', state.positions + 1e-3 * random.standard_normal(state.positions.shape))


def play(environment, seed):
    """Observations after the reset and each of six steps."""
    observations = [environment.reset(seed)]

    def act(action):
        observation, _, _, info = environment.step(action)
        assert not info['refused'], info
        observations.append(observation)

    corner = observations[0].states['sheet'].positions[0]
    end = observations[0].states['line'].positions[-1]
    act({'left': [Grasp('sheet', feature('corner_0')), MoveTo(corner + [0.05, 0.0, 0.05])],
         'right': Grasp('line', nearest(end))})
    act({'right': MoveTo(end + [0.0, 0.02, 0.1])})
    act({'left': MoveTo(corner + [0.0, 0.05, 0.1])})
    act({})
    act({'left': Release()})
    act({'right': Release()})
    return observations


def main():
    sim = deformable_sim.connect('episode', sys.argv[1], wait=20.0)
    environment = Environment(sim, steps=5, prepare=shake)
    episodes = []
    for _ in range(2):
        times = []
        environment._done = lambda observation: times.append(rospy.get_time())  # when it is observed, not later
        observations = play(environment, 3)
        episodes.append({'digests': [o.digest() for o in observations], 'times': [o.time for o in observations],
                         'clock': times})
    print(json.dumps(episodes))


if __name__ == '__main__':
    main()
