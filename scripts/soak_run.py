"""One soak: the robot, what is done to the system meanwhile, and what is seen of the node."""
import csv
import os
import random
import signal
import subprocess
import sys
import threading
import time

import rosgraph
import rospy
import yaml

from own_node import DEADLINE, NODE, allocated, descriptors, start_master, stop
from soak_books import Sheet
from soak_judge import DESCRIPTORS
from soak_robot import BODY, Robot
from support import Listener, Simulation, Status, wait_until
from deformable_sim.msg import BodyMesh, ContactArray

MINUTES = {'subscriber killed': 5.0, 'tf stopped': 7.0, 'reset': 11.0, 'state restored': 17.0, 'looked at': 10.0,
           'master restarted': 60.0}  # simulated, between two of a kind
TAKES = (0.0, 0.02, None)           # s that subscribers take for a message; None: frozen
LISTENERS = 3
SAMPLE = 1.0                        # s (wall)
REST = 5.0                          # s (simulated) that the towel is let lie
FRESH_STEPS = 50
GIVE_BACK = 10.0                    # s (wall) for descriptors of connections that ended
LISTENER = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'soak_listener.py')


class SoakRun:
    """findings(), samples and story() are what came of it."""

    def __init__(self, master, node, scene, seed, seconds, path):
        self.master, self.node, self.seed, self.until = master, node, seed, seconds
        self.port = int(os.environ['ROS_MASTER_URI'].rsplit(':', 1)[1])
        self.random = random.Random(seed + 1)
        rospy.init_node('soak', disable_signals=True, log_level=rospy.FATAL)
        self.sim = Simulation(NODE)
        mesh = Listener('/%s/%s/mesh' % (NODE, BODY), BodyMesh).wait().mesh
        with open(scene, encoding='utf-8') as stream:
            cloth = yaml.safe_load(stream)['bodies'][0]['cloth']
        self.sheet = Sheet(mesh, cloth['cells'][0], cloth['material']['areal_density'])
        self.robot = Robot(NODE, seed, self.sheet)
        self.listeners, self.started, self.done, self.samples = [], 0, {}, []
        self.masses, self.crossings, self.unlike, self.stops, self.rests = [], [], [], 0, []
        self.slowest_registration = 0.0
        self.began, self.seconds, self.sampled = time.monotonic(), 0.0, 0.0
        self.simulated = 0.0  # s, of the run proper
        self.quiet = []  # (MiB, descriptors) without listeners: at the beginning, at the end
        self.plan = self.schedule()
        self.file = open(path, 'w', encoding='utf-8', newline='')

    def schedule(self):
        """[(simulated s, kind)]: every kind at least once, in equal parts of the run, anywhere within its part."""
        plan = []
        for kind, minutes in MINUTES.items():
            count = max(1, round(self.until / (60.0 * minutes)))
            part = 0.9 * self.until / count
            plan += [(part * (i + self.random.uniform(0.05, 1.0)), kind) for i in range(count)]
        return sorted(plan)

    # --- beginning and end ---

    def begin(self):
        wait_until(lambda: self.robot.status, 'the status of the node')
        self.fresh = self.fresh_bits()
        self.rests.append(self.rest())
        self.quiet.append((allocated(self.node.pid), descriptors(self.node.pid)))
        for _ in range(LISTENERS):
            self.start_listener()
        self.robot.thread.start()

    def end(self):
        self.simulated = self.robot.simulated
        self.robot.stopping = True
        self.robot.thread.join(DEADLINE)
        for listener in self.listeners:
            listener.kill()
            listener.wait()
        self.sim.release(name='')
        self.rests.append(self.rest())
        self.look()
        self.reset_and_compare()
        self.quiet.append((allocated(self.node.pid), self.least_descriptors()))

    def least_descriptors(self):
        """Connections end some time after those at their other ends."""
        end = time.monotonic() + GIVE_BACK
        while descriptors(self.node.pid) > self.quiet[0][1] + DESCRIPTORS and time.monotonic() < end:
            time.sleep(0.1)
        return descriptors(self.node.pid)

    def close(self):
        self.seconds = time.monotonic() - self.began
        self.robot.stopping = True
        for listener in self.listeners:
            if listener.poll() is None:
                listener.kill()
                listener.wait()
        self.simulated = self.simulated or self.robot.simulated
        self.file.close()
        stop(self.master)

    # --- what is done to it ---

    def disturb_when_due(self):
        while self.plan and self.plan[0][0] <= self.robot.simulated:
            kind = self.plan.pop(0)[1]
            {'subscriber killed': self.kill_listener, 'tf stopped': self.stop_tf, 'reset': self.reset, 'looked at': self.look,
             'state restored': self.restore, 'master restarted': self.restart_master}[kind]()
            self.done[kind] = self.done.get(kind, 0) + 1

    def start_listener(self):
        takes = TAKES[self.started % len(TAKES)]
        self.started += 1
        listener = subprocess.Popen([sys.executable, LISTENER, str(takes or 0.0)], stdout=subprocess.DEVNULL,
                                    stderr=subprocess.DEVNULL)
        self.listeners.append(listener)
        if takes is None:
            freeze = threading.Timer(3.0, lambda: listener.poll() is None and listener.send_signal(signal.SIGSTOP))
            freeze.daemon = True
            freeze.start()

    def kill_listener(self):
        """The oldest."""
        listener = self.listeners.pop(0)
        listener.kill()
        listener.wait()
        self.start_listener()

    def stop_tf(self):
        self.robot.broadcasts = False
        resume = threading.Timer(self.random.uniform(0.2, 2.0), setattr, (self.robot, 'broadcasts', True))
        resume.daemon = True
        resume.start()

    def reset(self):
        """In the midst of what the robot does; every other time nothing may differ from the first steps after it."""
        if self.done.get('reset', 0) % 2 == 0:
            self.sim.reset()
        else:
            self.reset_and_compare()

    def restore(self):
        if self.sim.save_state(name='kept').status.code == Status.OK:
            time.sleep(self.random.uniform(0.05, 0.5))
            self.sim.restore_state(name='kept')

    def restart_master(self):
        known = self.registered()
        self.master.kill()
        self.master.wait()
        time.sleep(self.random.uniform(0.1, 2.0))
        self.master = start_master(self.port)
        self.robot.register_again()
        back = time.monotonic()
        wait_until(lambda: known <= self.registered(), 'the node to register with the new master', DEADLINE)
        self.slowest_registration = max(self.slowest_registration, time.monotonic() - back)

    @staticmethod
    def registered():
        """What the master knows of the node: (0: publishes, 1: listens to, 2: serves; name), but for topics of grasps."""
        state = rosgraph.Master('/soak').getSystemState()
        return {(i, name) for i, names in enumerate(state) for name, nodes in names
                if '/' + NODE in nodes and '/grasp/' not in name}

    # --- what is seen of it ---

    def look(self):
        """At a state of the run."""
        state = self.sim.state(BODY)
        self.masses.append(self.sheet.total_mass(state))
        self.crossings.append(len(self.sheet.crossings(state)))

    def fresh_bits(self):
        """The state some steps after a reset."""
        self.sim.pause(True)
        try:
            if not self.sim.reset().success:
                return None
            self.sim.steps(FRESH_STEPS)
            state = self.sim.state(BODY)
            return state.positions, state.velocities
        finally:
            self.sim.pause(False)

    def reset_and_compare(self):
        with self.robot.quiet:
            time.sleep(0.05)  # what the robot had sent by topic
            self.unlike.append(self.fresh_bits() != self.fresh)

    def rest(self):
        """Measures of the towel that was spread and let lie."""
        with self.robot.quiet:
            self.sim.pause(True)
            try:
                spread = self.sim.set_state(self.robot.spread_state())
                assert spread.status.code == Status.OK, spread.status.message
                self.sim.step(seconds=REST)
                state = self.sim.state(BODY)
                contacts = Listener('/%s/contacts' % NODE, ContactArray)
                carried = sum(c.force.z for c in contacts.wait().contacts)
                contacts.close()
            finally:
                self.sim.pause(False)
        lengths = self.sheet.lengths(state)
        return {'height': sum(state.positions[2::3]) / len(self.sheet.rest), 'speed': self.sheet.fastest(state), 'carried': carried,
                'area': self.sheet.area(state), 'lengths': lengths, 'mass': self.sheet.total_mass(state),
                'elastic': state.elastic_energy, 'crossings': len(self.sheet.crossings(state))}

    def sample(self):
        now = time.monotonic()
        if now - self.sampled < SAMPLE:
            return
        self.sampled = now
        status, robot = self.robot.status, self.robot
        if any('last good state' in warning for warning in status.warnings):
            self.stops += 1
            self.sim.reset()
        sample = {
            'wall_s': round(now - self.began, 2), 'simulated_s': round(robot.simulated, 2), 'time_s': round(status.time, 2),
            'memory_MiB': round(allocated(self.node.pid), 3), 'descriptors': descriptors(self.node.pid),
            'real_time_factor': round(status.real_time_factor, 1), 'repeated_steps': robot.repeated,
            'energy_created_J': robot.created, 'kinetic_J': status.kinetic_energy, 'elastic_J': status.elastic_energy,
            'potential_J': status.potential_energy, 'max_strain': status.max_strain, 'residual_m_s2': status.residual,
            'max_penetration_m': status.max_penetration, 'iterations': status.iterations, 'grasps': len(robot.grasps),
            'warnings': len(status.warnings), 'rounds': robot.done.get('rounds', 0)}
        writer = csv.DictWriter(self.file, list(sample))
        if not self.samples:
            writer.writeheader()
        writer.writerow(sample)
        self.file.flush()
        self.samples.append(sample)

    def findings(self):
        robot = self.robot
        return {'rests': self.rests, 'masses': self.masses, 'mass': sum(self.sheet.mass), 'crossings': self.crossings,
                'unlike': self.unlike, 'stops': self.stops, 'flights': robot.flights, 'created': robot.created,
                'strain': robot.most_strain, 'quiet': self.quiet, 'rounds': robot.done.get('rounds', 0),
                'slowest_registration': self.slowest_registration, 'lost': robot.longest_lost,
                'missed': [kind for _, kind in self.plan],
                'robot_errors': [what for what in robot.done if what.startswith('robot: ')]}

    def story(self):
        """What was done, and what the node warned of."""
        robot = self.robot
        lines = ['to it:   ' + ', '.join('%d x %s' % (n, what) for what, n in sorted(self.done.items())),
                 'by it:   ' + ', '.join('%d x %s' % (n, what) for what, n in sorted(robot.done.items())),
                 'warned:  ' + (', '.join('%d x %s' % (n, what) for what, n in sorted(robot.warned.items())) or 'nothing'),
                 'repeated steps %d; deepest penetration %.2g m' % (robot.repeated, robot.deepest)]
        return '\n'.join(lines)
