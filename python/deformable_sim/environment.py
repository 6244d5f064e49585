"""reset(), step(action), observe(): a simulation in lock-step, as learning loops want it.

The node makes steps when it is told to and at no other time, and each call returns when it is done: the same scene,
seed and actions give the same bits, each time, on a busy machine and on an idle one.
"""

import dataclasses
import hashlib
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

import numpy
import rospy

from deformable_sim.errors import Refused
from deformable_sim.listener import Listener
from deformable_sim.msg import GraspSelection
from deformable_sim.selection import IDENTITY, to_pose
from deformable_sim.simulation import Simulation, to_duration
from deformable_sim.state import State


@dataclasses.dataclass(frozen=True)
class Grasp:
    """Closes a gripper on nodes of a body: nearest(point), feature('corner_0'), ... max_force: N, slips off beyond."""

    body: str
    selection: GraspSelection
    max_force: float = 0.0

    def __post_init__(self) -> None:
        if not isinstance(self.body, str) or not isinstance(self.selection, GraspSelection):
            raise TypeError('Grasp: %r, %r; a name and a selection such as nearest(point) are needed' %
                            (self.body, self.selection))


@dataclasses.dataclass(frozen=True)
class MoveTo:
    """Sends a closed gripper to a pose; without a duration (s) it arrives at the end of the step, if max_speed allows."""

    position: Sequence[float]
    orientation: Sequence[float] = IDENTITY
    duration: Optional[float] = None

    def __post_init__(self) -> None:
        to_pose(self.position, self.orientation)
        if self.duration is not None:
            to_duration(self.duration)


@dataclasses.dataclass(frozen=True)
class Release:
    """Opens a gripper."""


Command = Union[Grasp, MoveTo, Release]
# What grippers do, by their names; several commands of one are done one after the other, all before time passes.
Action = Mapping[str, Union[Command, Sequence[Command]]]


@dataclasses.dataclass
class Observation:
    """The world after a step.

    time        simulated s since the reset.
    states      of every observed body.
    held        nodes of each closed gripper. One that slips off stays here until it is opened; the topic `grasps` says so.
    messages    of this very step, of the topics asked for.
    """

    time: float
    states: Dict[str, State]
    held: Dict[str, Tuple[int, ...]]
    messages: Dict[str, Any] = dataclasses.field(default_factory=dict)

    def digest(self) -> str:
        """A hash of time, nodes held and every bit of the states; equal for equal runs."""
        digest = hashlib.sha256(repr((self.time, sorted(self.held.items()))).encode())
        for name in sorted(self.states):
            state = self.states[name]
            for array in (state.positions, state.velocities, state.segments):
                digest.update(array.tobytes())
        return digest.hexdigest()


def no_reward(_: Observation) -> float:
    return 0.0


def never(_: Observation) -> bool:
    return False


class Environment:
    """One episode after another in one simulation.

    simulation  a node with clock: on_demand. One with another clock is paused, so that time passes in step() alone.
    steps       of the simulation in a step of the environment.
    bodies      to observe; all of the scene when none are named.
    grippers    names that actions may use.
    reward      of an observation.
    done        whether an observation ends the episode.
    prepare     what makes episodes differ: called in reset() with the simulation and a generator of the seed.
    settle      steps after `prepare`, before the first observation.
    topics      of the node, by private name, with their types: {'grasps': GraspStateArray}. Observations then wait for their
                messages of that step, which takes up to one period of the topic (wall): start the node with rate_state and
                rate_points at 1000. There is no message for the instant of a reset, so settle is at least 1.
    """

    def __init__(self, simulation: Simulation, *, steps: int = 10, bodies: Iterable[str] = (),
                 grippers: Iterable[str] = ('left', 'right'), reward: Callable[[Observation], float] = no_reward,
                 done: Callable[[Observation], bool] = never,
                 prepare: Optional[Callable[[Simulation, numpy.random.Generator], None]] = None, settle: int = 0,
                 topics: Optional[Mapping[str, Any]] = None) -> None:
        if steps < 1 or settle < 0:
            raise ValueError('steps: %d, settle: %d; at least 1 and 0 are needed' % (steps, settle))
        self.simulation = simulation
        self.steps = steps
        self.bodies = list(bodies) or [body.name for body in simulation.bodies()]
        self.grippers = list(grippers)
        self._reward = reward
        self._done = done
        self._prepare = prepare
        self._settle = max(settle, 1) if topics else settle
        simulation.pause()
        self._seconds = steps * simulation.dt()
        self._listeners: Dict[str, Listener] = {name: simulation.listen(name, kind)
                                                for name, kind in (topics or {}).items()}
        self._time = 0.0
        self._held: Dict[str, Tuple[int, ...]] = {}
        self._closed = False

    def reset(self, seed: Optional[int] = None) -> Observation:
        """Back to the beginning of the scene, prepared by the seed; None is a seed nobody knows."""
        self._check_open()
        self.simulation.pause()  # it may be another node than last time
        self.simulation.reset()
        self._time = 0.0
        self._held = {}
        if self._prepare is not None:
            self._prepare(self.simulation, numpy.random.default_rng(seed))
        for listener in self._listeners.values():
            listener.clear()
        if self._settle:
            self._time = self.simulation.step(self._settle)
        return self.observe()

    def step(self, action: Optional[Action] = None) -> Tuple[Observation, float, bool, Dict[str, Any]]:
        """Does what the action says, then lets time pass: observation, reward, done, info.

        A command that the node refuses, such as a grasp where there is nothing, is left out, and listed in
        info['refused'] as (gripper, Refused). info['notes']: (gripper, text) of moves that were limited. A gripper that
        does not exist is the caller's mistake: KeyError, and TypeError for what is no command; nothing is done then.
        """
        self._check_open()
        refused: List[Tuple[str, Refused]] = []
        notes: List[Tuple[str, str]] = []
        for gripper, command in self._commands({} if action is None else action):
            try:
                note = self._do(gripper, command)
            except Refused as refusal:
                refused.append((gripper, refusal))
                continue
            if note:
                notes.append((gripper, note))
        self._time = self.simulation.step(self.steps)
        observation = self.observe()
        info = {'refused': refused, 'notes': notes}
        return observation, float(self._reward(observation)), bool(self._done(observation)), info

    def observe(self) -> Observation:
        """The world as it is; no time passes."""
        self._check_open()
        states = {name: self.simulation.get_state(name) for name in self.bodies}
        stamp = next(iter(states.values())).stamp
        stamp = rospy.Time(stamp.secs, stamp.nsecs)
        messages = {name: listener.at(stamp, self.simulation.timeout) for name, listener in self._listeners.items()}
        return Observation(self._time, states, dict(self._held), messages)

    def close(self) -> None:
        """Ends the subscriptions; what is called afterwards is a RuntimeError. The simulation stays open."""
        self._closed = True
        for listener in self._listeners.values():
            listener.close()
        self._listeners = {}

    def _check_open(self) -> None:
        if self._closed:
            raise RuntimeError('the environment is closed')

    def _commands(self, action: Action) -> List[Tuple[str, Command]]:
        """In their order. All are looked at before the first is sent."""
        if not isinstance(action, Mapping):
            raise TypeError('action: %r; a mapping from grippers to commands is needed' % (action,))
        found: List[Tuple[str, Command]] = []
        for gripper, commands in action.items():
            if gripper not in self.grippers:
                raise KeyError('no gripper %r; there are %s' % (gripper, ', '.join(self.grippers)))
            listed = commands if isinstance(commands, (list, tuple)) else [commands]
            for command in listed:
                if not isinstance(command, (Grasp, MoveTo, Release)):
                    raise TypeError('gripper %r: %r is no Grasp, MoveTo or Release' % (gripper, command))
                found.append((gripper, command))
        return found

    def _do(self, gripper: str, command: Command) -> str:
        """Returns the note of a move that was limited."""
        if isinstance(command, Grasp):
            self._held[gripper] = self.simulation.grasp(gripper, command.body, command.selection,
                                                        max_force=command.max_force)
        elif isinstance(command, MoveTo):
            duration = self._seconds if command.duration is None else command.duration
            return self.simulation.move_grasp(gripper, command.position, command.orientation, duration)
        else:
            self.simulation.release(gripper)
            self._held.pop(gripper, None)
        return ''
