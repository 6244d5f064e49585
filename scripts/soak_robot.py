"""The robot of the soak: one hand that follows a frame of its own on tf, one that is sent targets; folds, lifts and throws a towel.

It goes by simulated time, which it reads from ~status, and puts that time on its transforms, as robots do whose clock is
the simulation. A request that fails is counted, and the next thing done.
"""
import random
import threading
import time

import rosgraph
import rospy
from geometry_msgs.msg import PoseStamped, TransformStamped
from tf2_msgs.msg import TFMessage

from deformable_sim.msg import GraspCommand, GraspStateArray, SimStatus
from soak_books import norm, points, sub
from support import Simulation, Status, feature

BODY = 'towel'
HAND = 'hand'              # tf frame
SPEED = 0.6                # m/s of a hand
TABLE = 0.752              # m, where a towel lies
HOLD = 1.0                 # N, beyond which a corner slips off: six times the towel's weight
GRAVITY = 9.81
FLIGHT_STEPS = 5
PATIENCE = 10.0            # s (wall) without news of time, until it asks for the next thing


class Interrupted(Exception):
    """Time jumped, or stands still."""


class Robot:
    """Also keeps what the node says: `status`, `simulated` (s, over all resets), counts of what was `done`."""

    def __init__(self, node, seed, sheet):
        self.random = random.Random(seed)
        self.sheet, self.node = sheet, node
        self.sim = Simulation(node)
        self.news = threading.Condition()
        self.status, self.simulated, self.jumps, self.warned = None, 0.0, 0, {}
        self.created, self.repeated, self.lowest_factor = 0.0, 0, float('inf')
        self.most_strain = self.deepest = 0.0
        self.broadcasts, self.lost_since, self.longest_lost = True, None, 0.0
        self.quiet = threading.Lock()   # who holds it has the towel to itself
        self.path = (0.0, 0.0, (0.0, 0.0, 1.0), (0.0, 0.0, 1.0))  # from when to when (simulated s), from where to where
        self.done = {}
        self.flights = []               # (m/s^2, share): what a flight's books of momentum and energy leave open
        self.stopping = False
        self.tf = rospy.Publisher('/tf', TFMessage, queue_size=10)
        self.commands = rospy.Publisher('/%s/grasp_command' % node, GraspCommand, queue_size=10)
        self.grasps = []
        self.listeners = [rospy.Subscriber('/%s/status' % node, SimStatus, self.on_status, queue_size=50, tcp_nodelay=True),
                          rospy.Subscriber('/%s/grasps' % node, GraspStateArray, self.on_grasps, queue_size=1)]
        self.thread = threading.Thread(target=self.work, daemon=True)

    # --- what the node says ---

    def on_status(self, message):
        with self.news:
            before, self.status = self.status, message
            self.deepest = max(self.deepest, message.max_penetration)
            self.most_strain = max(self.most_strain, message.max_strain)
            for warning in message.warnings:
                if not before or warning not in before.warnings:
                    key = ' '.join(word for word in warning.split(':')[0].split() if not word[0].isdigit())
                    self.warned[key] = self.warned.get(key, 0) + 1
            if before and message.time < before.time:
                self.jumps += 1
            elif before:
                self.simulated += message.time - before.time
                self.created += message.energy_created - before.energy_created
                self.repeated += message.repeated_steps - before.repeated_steps
            self.note_lost_hand(message)
            self.news.notify_all()
        if self.broadcasts:
            self.broadcast(message.time)

    def note_lost_hand(self, message):
        """How long (s, wall) the node does not see the hand though it is told where it is."""
        if not self.broadcasts or message.paused or not any('stopped arriving' in w for w in message.warnings):
            self.lost_since = None
            return
        self.lost_since = self.lost_since or time.monotonic()
        self.longest_lost = max(self.longest_lost, time.monotonic() - self.lost_since)

    def on_grasps(self, message):
        self.grasps = message.grasps

    def broadcast(self, now):
        begin, end, start, goal = self.path
        share = 1.0 if now >= end else 0.0 if now <= begin else (now - begin) / (end - begin)
        transform = TransformStamped(child_frame_id=HAND)
        transform.header.frame_id, transform.header.stamp = 'world', rospy.Time(now)
        t = transform.transform.translation
        t.x, t.y, t.z = (a + share * (b - a) for a, b in zip(start, goal))
        transform.transform.rotation.w = 1.0
        self.tf.publish(TFMessage([transform]))

    def register_again(self):
        """With a master that knows nothing: rospy does not."""
        master = rosgraph.Master(rospy.get_name())
        for publisher in (self.tf, self.commands):
            master.registerPublisher(publisher.resolved_name, publisher.type, rospy.get_node_uri())
        for listener in self.listeners:
            master.registerSubscriber(listener.resolved_name, listener.type, rospy.get_node_uri())

    # --- time ---

    def now(self):
        return self.status.time if self.status else 0.0

    def wait(self, seconds):
        """Of simulated time. Interrupted when it jumps or stands still."""
        with self.news:
            jumps, until = self.jumps, self.now() + seconds
            while self.now() < until:
                if not self.news.wait(PATIENCE) or self.jumps != jumps or self.stopping:
                    raise Interrupted()

    # --- asking ---

    def count(self, what):
        self.done[what] = self.done.get(what, 0) + 1

    def ask(self, what, call, *arguments, **fields):
        """The answer, or None: it was refused or there is nobody to ask."""
        try:
            with self.quiet:
                answer = call(*arguments, **fields)
        except (rospy.ServiceException, rospy.exceptions.ROSException, OSError):
            self.count(what + ' unanswered')
            time.sleep(0.05)
            return None
        granted = answer.success if hasattr(answer, 'success') else answer.status.code == Status.OK
        self.count(what if granted else what + ' refused')
        return answer if granted else None

    def corner(self, k):
        answer = self.ask('get_state', self.sim.get_state, BODY)
        if answer is None:
            raise Interrupted()
        across = int(round(len(answer.state.positions) / 3) ** 0.5) - 1
        row, column = divmod(k, 2)
        return points(answer.state.positions)[row * across * (across + 1) + column * across]

    # --- moving ---

    def carry(self, name, goal, follows):
        """Moves a hand from where it is, over the table and not through it; returns when it is there, or should be."""
        start = self.path[3]
        if min(start[2], goal[2]) < TABLE - 0.01:
            for low in (start, goal):
                self.go(name, low[:2] + (TABLE + 0.3,), follows)
        self.go(name, goal, follows)

    def go(self, name, goal, follows):
        start = self.path[3]
        seconds = max(0.1, norm(sub(goal, start)) / SPEED)
        self.path = (self.now(), self.now() + seconds, start, goal)
        if name and not follows:
            self.ask('move_grasp', self.sim.move_grasp, name=name, target=pose(goal), duration=rospy.Duration(seconds))
        self.wait(seconds)

    def take(self, k, follows):
        """A corner, by service or by topic; the name of the grasp."""
        place = self.corner(k)
        self.carry('', place[:2] + (place[2] + 0.1,), True)
        self.carry('', self.corner(k), True)  # it may have moved since
        name = 'hand_%d' % k
        fields = dict(name=name, body=BODY, selection=feature('corner_%d' % k), follow_frame=HAND if follows else '', max_force=HOLD)
        if self.random.random() < 0.5:
            self.ask('grasp', self.sim.grasp, **fields)
        else:
            with self.quiet:
                self.commands.publish(GraspCommand(action=GraspCommand.GRASP, **fields))
            self.count('grasp by topic')
        self.wait(0.2)
        return name

    def let_go(self, name=''):
        if self.random.random() < 0.5:
            return self.ask('release', self.sim.release, name=name)
        with self.quiet:
            self.commands.publish(GraspCommand(action=GraspCommand.RELEASE, name=name))
        self.count('release by topic')
        return None

    # --- what it does ---

    def work(self):
        while not self.stopping:
            try:
                self.random.choice((self.fold, self.fold, self.lift, self.throw, self.drag))()
                self.count('rounds')
            except Interrupted:
                self.count('rounds broken off')
            except (rospy.ServiceException, rospy.exceptions.ROSException, OSError):
                self.count('rounds broken off for want of a master')
                time.sleep(0.1)
            except Exception as error:  # whatever it is: it goes on, and says what it was
                self.count('robot: %s: %s' % (type(error).__name__, error))
                time.sleep(0.1)

    def begin(self):
        """Empty hands, and the towel not too far away: a corner of it and how to hold it."""
        self.let_go()
        self.wait(1.0)
        if self.random.random() < 0.2 or any(abs(c) > 1.5 for c in self.corner(0)):
            self.ask('set_state', self.sim.set_state, self.spread_state())
            self.wait(0.5)
        return self.random.randrange(4), self.random.random() < 0.5

    def spread_state(self):
        """Flat, 1 mm above where it lies."""
        state = self.sim.get_state(BODY).state
        state.positions = [c + (TABLE if i % 3 == 2 else 0.0) for i, c in enumerate(c for p in self.sheet.rest for c in p)]
        state.velocities = [0.0] * len(state.positions)
        return state

    def fold(self):
        """A corner, or two, over to the other side."""
        k, follows = self.begin()
        name = self.take(k, follows)
        goal = self.corner(3 - k if self.random.random() < 0.5 else k ^ 1)
        start = self.path[3]
        height = TABLE + self.random.uniform(0.08, 0.2)
        middle = tuple(0.5 * (a + b) for a, b in zip(start[:2], goal[:2])) + (max(goal[2], height),)
        self.carry(name, middle, follows)
        self.carry(name, goal[:2] + (goal[2] + 0.02,), follows)
        self.let_go(name)
        self.wait(self.random.uniform(0.5, 2.0))

    def lift(self):
        """Up with it over the table, and down where it likes to fall."""
        k, follows = self.begin()
        name = self.take(k, follows)
        self.carry(name, self.above_table(0.4, 0.6), follows)
        self.wait(1.0)
        self.carry(name, self.above_table(0.03, 0.1), follows)
        self.let_go(name)
        self.wait(1.0)

    def drag(self):
        """Along the table, the other corner held too, soft, and slipping off."""
        k, follows = self.begin()
        name = self.take(k, follows)
        self.ask('grasp', self.sim.grasp, name='other', body=BODY, selection=feature('corner_%d' % (3 - k)), max_force=0.3,
                 stiffness=50.0)
        self.carry(name, self.above_table(0.03, 0.3), follows)
        self.let_go()
        self.wait(0.5)

    def throw(self):
        """Lets go while it moves; in the air nothing but its weight acts on it."""
        k, _ = self.begin()
        name = self.take(k, False)
        self.carry(name, self.above_table(0.5, 0.7), False)
        goal = tuple(c + self.random.uniform(-0.5, 0.5) for c in self.path[3][:2]) + (self.path[3][2] + self.random.uniform(0.0, 0.2),)
        with self.quiet:
            thrown = self.fly(name, goal)
        if thrown:
            self.count('throws')
        self.path = self.path[:2] + (goal, goal)
        self.wait(1.5)

    def fly(self, name, goal):
        """With time stopped, so that it lets go at the same instant at any speed of simulation."""
        try:
            self.sim.pause(True)
            self.sim.move_grasp(name=name, target=pose(goal), duration=rospy.Duration(0.4))
            self.sim.step(seconds=self.random.uniform(0.1, 0.3))
            if self.sim.release(name='').status.code != Status.OK:
                return False
            states = []
            for steps in (1, FLIGHT_STEPS):
                answer = self.sim.step(steps=steps)
                states.append((answer.time, self.sim.get_state(BODY).state))
            return self.keep_books(*states)
        except (rospy.ServiceException, rospy.exceptions.ROSException, OSError):
            self.count('flight unanswered')
            return False
        finally:
            self.go_on()

    def keep_books(self, before, after):
        """Of a flight that touched nothing: by how much it did not fall with g, and what energy it won."""
        seconds = after[0] - before[0]
        if before[1].contacts or after[1].contacts or not 0.0 < seconds < 1.0:
            return False
        mass = sum(self.sheet.mass)
        change = [(b - a) / (mass * seconds) for a, b in zip(*(self.sheet.momentum(s) for _, s in (before, after)))]
        energy = [s.kinetic_energy + s.elastic_energy + s.potential_energy for _, s in (before, after)]
        self.flights.append((norm((change[0], change[1], change[2] + GRAVITY)), (energy[1] - energy[0]) / before[1].kinetic_energy))
        return True

    def go_on(self):
        while not self.stopping:
            try:
                self.sim.pause(False)
                return
            except (rospy.ServiceException, rospy.exceptions.ROSException, OSError):
                time.sleep(0.05)

    def above_table(self, low, high):
        return self.random.uniform(-0.2, 0.2), self.random.uniform(-0.2, 0.2), TABLE + self.random.uniform(low, high)


def pose(place):
    message = PoseStamped()
    message.pose.position.x, message.pose.position.y, message.pose.position.z = place
    message.pose.orientation.w = 1.0
    return message
