"""A client of sim_node, and an environment that steps it in lock-step; see doc/python.md.

The messages and services are deformable_sim.msg and deformable_sim.srv, as ever.
"""

from deformable_sim.environment import (Action, Command, Environment, Grasp, MoveTo, Observation, Release,
                                        no_reward)
from deformable_sim.errors import Interrupted, Refused, SimulationError, TimedOut, Unreachable
from deformable_sim.listener import Listener
from deformable_sim.selection import all_within, feature, in_box, nearest, nodes
from deformable_sim.simulation import Body, Simulation, connect
from deformable_sim.state import State, cloud_array

__all__ = ['Action', 'Body', 'Command', 'Environment', 'Grasp', 'Interrupted', 'Listener', 'MoveTo', 'Observation', 'Refused',
           'Release', 'Simulation', 'SimulationError', 'State', 'TimedOut', 'Unreachable', 'all_within', 'cloud_array', 'connect',
           'feature', 'in_box', 'nearest', 'no_reward', 'nodes']
