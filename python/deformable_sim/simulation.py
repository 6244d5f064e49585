"""The services of one sim_node as methods."""

import dataclasses
import json
import time
from typing import Any, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

import genpy
import rospy
from geometry_msgs.msg import PoseStamped
from shape_msgs.msg import SolidPrimitive
from std_srvs.srv import SetBool, SetBoolRequest, Trigger, TriggerRequest

from deformable_sim.errors import Refused, TimedOut, check_interrupted
from deformable_sim.listener import Listener
from deformable_sim.msg import GraspSelection, Obstacle, RolloutPlan, RolloutResult, SimStatus, Status
from deformable_sim.selection import IDENTITY, nearest, pose_stamped, to_pose
from deformable_sim.service import Service, wait_for_master
from deformable_sim.srv import (AddBody, AddBodyRequest, AddObstacle, AddObstacleRequest, GetDistance, GetDistanceRequest,
                                GetDistanceResponse, GetState, GetStateRequest, Grasp, GraspRequest, LetThrough,
                                LetThroughRequest, LoadScene, LoadSceneRequest, MoveGrasp, MoveGraspRequest, Release,
                                ReleaseRequest, RemoveBody, RemoveBodyRequest, RemoveObstacle, RemoveObstacleRequest,
                                RestoreState, RestoreStateRequest, Rollout, RolloutRequest, SaveState, SaveStateRequest,
                                SetMaterial, SetMaterialRequest, SetState, SetStateRequest, Step, StepRequest)
from deformable_sim.state import State, state_from_message, state_to_message

_SERVICES = {'add_body': AddBody, 'remove_body': RemoveBody, 'set_material': SetMaterial, 'rollout': Rollout,
             'grasp': Grasp, 'move_grasp': MoveGrasp, 'release': Release, 'pause': SetBool, 'reset': Trigger,
             'describe': Trigger, 'step': Step, 'load_scene': LoadScene, 'add_obstacle': AddObstacle,
             'remove_obstacle': RemoveObstacle, 'let_through': LetThrough, 'get_distance': GetDistance,
             'get_state': GetState, 'set_state': SetState, 'save_state': SaveState, 'restore_state': RestoreState}
_SAME_TIME = 2e-9  # s: /clock counts nanoseconds


@dataclasses.dataclass(frozen=True)
class Body:
    """A line of ~describe. kind: cloth, rope or soft."""

    name: str
    kind: str
    nodes: int


def to_duration(seconds: float) -> genpy.Duration:
    """ValueError for what 32 bits of seconds do not hold."""
    if not abs(seconds) < 2.0 ** 31:
        raise ValueError('duration: %r s; a ROS duration is finite and shorter than 2^31 s' % seconds)
    return genpy.Duration.from_sec(seconds)


def connect(name: str, node: str = 'deformable_sim', wait: float = 5.0) -> 'Simulation':
    """rospy.init_node(name) and a Simulation. Unreachable without a master, for which rospy alone would wait for ever."""
    wait_for_master(wait)
    rospy.init_node(name)
    return Simulation(node, wait=wait)


class Simulation:
    """A sim_node.

    Each method is one service call, in which the node does what was asked or refuses it: Refused, with code and message,
    and nothing has changed. A node that is not there, or goes away, is Unreachable; one that does not answer within the
    timeout is TimedOut; Ctrl-C during a call is Interrupted. Arguments of the wrong type or shape are a ValueError or TypeError, and not sent. Positions in m,
    orientations as quaternions x y z w, times in s. Threads may share one; calls of one service wait for one another.

    With use_sim_time and the node's publish_clock, what sets time returns when rospy's time is that of the simulation.

    node       name of the node; remapped and put into the caller's namespace like any name.
    timeout    s (wall), of every call; of step() unless it is given another.
    wait       s (wall), how long the constructor waits for the node.
    """

    def __init__(self, node: str = 'deformable_sim', timeout: float = 10.0, wait: float = 5.0) -> None:
        self.node = rospy.resolve_name(node)
        self.timeout = timeout
        self._services = {name: Service(self.topic(name), kind) for name, kind in _SERVICES.items()}
        self._status: Optional[Listener] = None
        self._services['step'].wait(wait)
        self._clocked = bool(rospy.get_param('/use_sim_time', False) and
                             rospy.get_param(self.topic('publish_clock'), False))

    def topic(self, name: str) -> str:
        """Full name of a private topic, service or parameter of the node."""
        return self.node + '/' + name

    def listen(self, name: str, kind: Any) -> Listener:
        """A topic of the node, to be read in lock-step."""
        return Listener(self.topic(name), kind)

    def close(self) -> None:
        """Closes the connections; the next call opens them again."""
        for service in self._services.values():
            service.close()
        if self._status is not None:
            self._status.close()
            self._status = None

    # Time.

    def pause(self) -> None:
        """Stops time; ~step goes on working."""
        self._ask('pause', SetBoolRequest(data=True))

    def resume(self) -> None:
        """Lets time run, but with clock: on_demand, where only steps do."""
        self._ask('pause', SetBoolRequest(data=False))

    def step(self, steps: int = 0, *, seconds: float = 0.0, timeout: Optional[float] = None) -> float:
        """Makes steps, or seconds rounded to whole steps; one step when neither is given. Returns the simulated time.

        TimedOut does not stop steps that the node has begun: it makes the rest, and refuses another step() until it has;
        reset() ends them. While another client steps, Refused (UNAVAILABLE).
        """
        if not steps and not seconds:
            steps = 1
        answer = self._ask('step', StepRequest(steps=steps, seconds=seconds), timeout)
        self._await_clock(answer.time)
        return answer.time

    def reset(self) -> None:
        """Back to the initial state, grasps and obstacles of the scene, and to time 0; also after a failure."""
        self._ask('reset', TriggerRequest())
        self._await_clock(0.0)

    def load_scene(self, scene: str = '', *, yaml: str = '', timeout: Optional[float] = None) -> None:
        """A scene by name or file, or the text of one, in place of the running one."""
        self._ask('load_scene', LoadSceneRequest(file=scene, yaml=yaml), timeout)
        self._await_clock(0.0)

    def add_bodies(self, scene: str = '', *, yaml: str = '', position: Optional[Sequence[float]] = None,
                   orientation: Sequence[float] = IDENTITY, frame_id: str = '', timeout: Optional[float] = None) -> List[str]:
        """Bodies of another scene (a name, a file or a text) join the running one; returns their names. position (m) and
        orientation (x, y, z, w) place a single body in frame_id, which is empty for the world frame."""
        pose = PoseStamped() if position is None else pose_stamped(position, orientation, frame_id)
        return list(self._ask('add_body', AddBodyRequest(file=scene, yaml=yaml, pose=pose), timeout).bodies)

    def remove_body(self, name: str, timeout: Optional[float] = None) -> None:
        """With its grasps."""
        self._ask('remove_body', RemoveBodyRequest(body=name), timeout)

    def set_material(self, body: str, material: Union[str, Mapping[str, Any]], timeout: Optional[float] = None) -> None:
        """Keys to change, such as {'damping': 0.01}, or the name of a material."""
        text = material if isinstance(material, str) else json.dumps(dict(material))
        self._ask('set_material', SetMaterialRequest(body=body, yaml=text), timeout)

    def rollout(self, plans: Sequence[RolloutPlan], seconds: float, *, sample_period: float = 0.0, with_positions: bool = False,
                with_contacts: bool = False, timeout: float = 60.0) -> List[RolloutResult]:
        """What if: each plan played for so many s of simulated time on a copy of the simulation, which is not touched.
        sample_period in s, 0: the start and the end. What has not ended after 0.9 timeout says TIMEOUT in its status."""
        request = RolloutRequest(plans=list(plans), seconds=seconds, sample_period=sample_period, with_positions=with_positions,
                                 with_contacts=with_contacts, deadline=0.9 * timeout)
        return list(self._ask('rollout', request, timeout).results)

    # Grasps.

    def grasp(self, name: str, body: str, selection: GraspSelection, *, follow_frame: str = '', max_force: float = 0.0,
              max_speed: float = 0.0, stiffness: float = 0.0) -> Tuple[int, ...]:
        """Attaches the selected nodes of a body to a new grasp; returns them. selection: nearest(), nodes(), feature() ...

        follow_frame    tf frame it is attached to; empty: it goes where move_grasp() says.
        max_force       N, slips off beyond; 0: never.      max_speed    m/s; 0: the scene's.
        stiffness       N/m; 0: rigid.
        """
        answer = self._ask('grasp', GraspRequest(name, body, selection, follow_frame, max_force, max_speed, stiffness))
        return tuple(int(node) for node in answer.nodes)

    def grasp_nearest(self, name: str, body: str, point: Sequence[float], radius: float = 0.02, frame_id: str = '',
                      **limits: Any) -> int:
        """Grasps the node nearest to a point, at most `radius` m away; returns it. limits: as of grasp()."""
        return self.grasp(name, body, nearest(point, radius, frame_id), **limits)[0]

    def move_grasp(self, name: str, position: Sequence[float], orientation: Sequence[float] = IDENTITY,
                   duration: float = 0.0, frame_id: str = '') -> str:
        """Sends a grasp there, in `duration` simulated s (0: as fast as max_speed allows). Returns at once, with a note
        when the move was limited, else an empty text."""
        request = MoveGraspRequest(name=name, target=pose_stamped(position, orientation, frame_id),
                                   duration=to_duration(duration))
        return self._ask('move_grasp', request).status.message

    def release(self, name: str = '') -> None:
        """One grasp, or all."""
        self._ask('release', ReleaseRequest(name=name))

    # State.

    def get_state(self, body: str) -> State:
        """Every node of a body, exact."""
        return state_from_message(self._ask('get_state', GetStateRequest(body=body)).state)

    def set_state(self, body: str, positions: Any, velocities: Optional[Any] = None,
                  segments: Optional[Any] = None) -> None:
        """Puts every node of a body somewhere else: n x 3 arrays. Without velocities it is at rest there."""
        self._ask('set_state', SetStateRequest(state=state_to_message(body, positions, velocities, segments)))

    def save(self, name: str = '', *, file: str = '') -> float:
        """Saves the whole simulation under a name in the node's memory, or to a file in its ~state_dir; the time saved."""
        return self._ask('save_state', SaveStateRequest(name=name, file=file)).time

    def restore(self, name: str = '', *, file: str = '') -> float:
        """Goes on, to the same bits, where a simulation of the same scene was saved; the time reached."""
        reached = self._ask('restore_state', RestoreStateRequest(name=name, file=file)).time
        self._await_clock(reached)
        return reached

    # Obstacles.

    def add_obstacle(self, obstacle: Obstacle) -> None:
        """Any obstacle the message can say."""
        self._ask('add_obstacle', AddObstacleRequest(obstacle=obstacle))

    def add_box(self, name: str, size: Sequence[float], position: Sequence[float],
                orientation: Sequence[float] = IDENTITY, friction: float = 0.5, frame_id: str = '') -> None:
        """size: full edge lengths, m."""
        self._add_primitive(name, SolidPrimitive.BOX, size, position, orientation, friction, frame_id)

    def add_sphere(self, name: str, radius: float, position: Sequence[float], friction: float = 0.5,
                   frame_id: str = '') -> None:
        self._add_primitive(name, SolidPrimitive.SPHERE, [radius], position, IDENTITY, friction, frame_id)

    def remove_obstacle(self, name: str) -> None:
        self._ask('remove_obstacle', RemoveObstacleRequest(name=name))

    def let_through(self, obstacle: str, bodies: Iterable[str]) -> None:
        """Which bodies an obstacle, or a link `robot.<link>`, does not touch from now on; none: it touches all."""
        self._ask('let_through', LetThroughRequest(obstacle=obstacle, bodies=list(bodies)))

    def distance(self, body: str, obstacles: Iterable[str] = ()) -> GetDistanceResponse:
        """How far a body is from obstacles (none named: all that it may touch), and where."""
        return self._ask('get_distance', GetDistanceRequest(body=body, obstacles=list(obstacles)))

    # What there is.

    def describe(self) -> Dict[str, List[str]]:
        """The lines of ~describe by their first words: {'time': ['0 s'], 'body': ['towel (cloth, 1200 nodes)'], ...}."""
        lines: Dict[str, List[str]] = {}
        for line in self._ask('describe', TriggerRequest()).message.splitlines():
            key, _, value = line.partition(': ')
            lines.setdefault(key, []).append(value)
        return lines

    def bodies(self) -> List[Body]:
        found = []
        for line in self.describe().get('body', []):
            name, _, rest = line.partition(' (')
            kind, nodes = rest.rstrip(')').split(', ')[:2]
            found.append(Body(name, kind, int(nodes.split()[0])))
        return found

    def dt(self) -> float:
        """s, of one step."""
        return float(self.describe()['step'][0].split()[0])

    def time(self) -> float:
        """Simulated s since the start or the last reset, to six digits; step() returns it exactly."""
        return float(self.describe()['time'][0].split()[0])

    def status(self) -> SimStatus:
        """A ~status of now or later: energies, strain, penetration, warnings. rospy.init_node() must have been called."""
        if self._status is None:
            self._status = self.listen('status', SimStatus)
        time_now = self.time()
        tolerance = 1e-5 * max(1.0, time_now)
        return self._status.wait(lambda message: message.time >= time_now - tolerance, self.timeout)

    def _add_primitive(self, name: str, kind: int, dimensions: Sequence[float], position: Sequence[float],
                       orientation: Sequence[float], friction: float, frame_id: str) -> None:
        obstacle = Obstacle(name=name, friction=friction,
                            primitives=[SolidPrimitive(type=kind, dimensions=[float(value) for value in dimensions])],
                            primitive_poses=[to_pose(position, orientation)])
        obstacle.header.frame_id = frame_id
        self.add_obstacle(obstacle)

    def _ask(self, service: str, request: Any, timeout: Optional[float] = None) -> Any:
        answer = self._services[service](request, self.timeout if timeout is None else timeout)
        if hasattr(answer, 'success'):
            if not answer.success:
                raise Refused(self.topic(service), None, answer.message)
        elif answer.status.code != Status.OK:
            raise Refused(self.topic(service), answer.status.code, answer.status.message)
        return answer

    def _await_clock(self, reached: float) -> None:
        """Until rospy's time is the simulation's, where the node makes the time of the system."""
        if not self._clocked:
            return
        end = time.monotonic() + self.timeout
        condition = rospy.rostime.get_rostime_cond()
        with condition:
            while abs(rospy.get_time() - reached) > _SAME_TIME:
                left = end - time.monotonic()
                if left <= 0.0:
                    raise TimedOut('/clock: not at %.9g s within %g s; is rospy.init_node() called, and is %s the only '
                                   'clock?' % (reached, self.timeout, self.node))
                check_interrupted('/clock')
                condition.wait(min(left, 0.05))
