#!/usr/bin/env python3
"""What-if on copies, and grasps along trajectories: the rollout service and the follow_trajectory action."""

import threading
import time
import unittest

import actionlib
import rospy
import rostest
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from std_msgs.msg import Header

from deformable_sim.msg import (FollowGraspTrajectoryAction, FollowGraspTrajectoryGoal, FollowGraspTrajectoryResult, GraspCommand,
                                GraspTrajectory, GraspTrajectoryPoint, RolloutPlan, TimedGraspCommand)
from deformable_sim.srv import Rollout
from support import DEADLINE, Refusals, Simulation, Status, feature, node_position, wait_until


def trajectory(grasp, *points, frame=''):
    """points: (time, x, y, z)."""
    return GraspTrajectory(
        header=Header(frame_id=frame), grasp=grasp,
        points=[GraspTrajectoryPoint(rospy.Duration(t), Pose(Point(x, y, z), Quaternion(w=1.0))) for t, x, y, z in points])


def timed(when, **command):
    return TimedGraspCommand(time=rospy.Duration(when), command=GraspCommand(**command))


LIFT = (0.5, 0.15, -0.1, 1.2)


class WhatIf(Refusals, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sim = Simulation()
        cls.rollout = cls.sim._service('rollout', Rollout)
        cls.action = actionlib.SimpleActionClient('/deformable_sim/follow_trajectory', FollowGraspTrajectoryAction)
        assert cls.action.wait_for_server(rospy.Duration(DEADLINE))

    def setUp(self):
        self.assertTrue(self.sim.reset().success)
        self.sim.grasp(name='hand', body='line', selection=feature('end_1'))

    def play(self, *plans, **request):
        answer = self.rollout(plans=plans, **request)
        self.assertEqual(answer.status.code, Status.OK, answer.status.message)
        return answer.results

    # rollouts

    def test_copies_tell_what_happens(self):
        self.sim.steps(10)
        plan = RolloutPlan(trajectories=[trajectory('hand', (0.3, 0.2, 1.1, 0.9))], commands=[timed(0.4, action=2, name='hand')])
        moved, waited = self.play(plan, RolloutPlan(), seconds=0.6, sample_period=0.1, with_positions=True)
        for result in (moved, waited):
            self.assertEqual(result.status.code, Status.OK, result.status.message)
            self.assertEqual([round(s.header.stamp.to_sec(), 9) for s in result.samples],
                             [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7])
            self.assertGreater(result.cpu_seconds, 0.0)
            self.assertEqual([b.body for b in result.samples[0].bodies], ['sheet', 'line'])
        self.assertEqual(moved.samples[0].bodies, waited.samples[0].bodies)
        self.assertEqual(node_position(moved.samples[3].bodies[1], 10), (0.2, 1.1, 0.9))
        self.assertEqual([g.name for g in moved.samples[-1].grasps].count('hand'), 0)
        # The simulation itself, told the same, does the same within the tolerance of its solver.
        self.follow(trajectory('hand', (0.3, 0.2, 1.1, 0.9)))
        self.sim.steps(30)
        self.assertEqual(self.action_result().status.code, Status.OK)
        state = self.sim.state('line').positions
        for a, b in zip(state, moved.samples[3].bodies[1].positions):
            self.assertAlmostEqual(a, b, places=5)

    def test_the_simulation_goes_on_to_the_same_bits(self):
        self.sim.steps(40)
        alone = self.sim.everything()
        self.setUp()
        for _ in range(8):
            self.play(RolloutPlan(commands=[timed(0.0, action=2)]), seconds=0.05)
            self.sim.steps(5)
        self.assertEqual(alone, self.sim.everything())

    def test_numbers_only_when_asked_for(self):
        sample = self.play(RolloutPlan(), seconds=0.1)[0].samples[-1]
        self.assertEqual(len(sample.bodies[0].positions), 0)
        self.assertNotEqual(sample.bodies[0].max_strain, 0.0)
        self.assertEqual(len(sample.contacts), 0)

    def test_a_plan_that_is_refused_leaves_the_others(self):
        bad, good = self.play(RolloutPlan(commands=[timed(0.1, action=2, name='nobody')]), RolloutPlan(), seconds=0.2)
        self.assertEqual(bad.status.code, Status.NOT_FOUND)
        self.assertTrue(bad.status.message.startswith('plans[0].commands[0]: '), bad.status.message)
        self.assertEqual(len(bad.samples), 1)
        self.assertEqual(good.status.code, Status.OK)

    def test_deadline(self):
        begin = time.monotonic()
        results = self.play(*[RolloutPlan()] * 4, seconds=1000.0, deadline=0.5)
        self.assertLess(time.monotonic() - begin, 10.0)
        self.assertTrue(all(r.status.code == Status.TIMEOUT for r in results))

    def test_bad_requests_are_refused(self):
        nan = float('nan')
        bad_pose = RolloutPlan(trajectories=[trajectory('hand', (0.1, nan, 0, 0))])
        back = RolloutPlan(trajectories=[trajectory('hand', (0.2, 0, 0, 0), (0.1, 0, 0, 0))])
        lost = RolloutPlan(trajectories=[trajectory('hand', (0.2, 0, 0, 0), frame='nowhere')])
        follows = RolloutPlan(commands=[timed(0.0, action=0, name='a', body='line', follow_frame='world')])
        for code, word, call in [
                (Status.INVALID_ARGUMENT, 'plans: none', lambda: self.rollout(seconds=1.0)),
                (Status.OUT_OF_RANGE, 'seconds', lambda: self.rollout(plans=[RolloutPlan()])),
                (Status.INVALID_ARGUMENT, 'seconds', lambda: self.rollout(plans=[RolloutPlan()], seconds=nan)),
                (Status.OUT_OF_RANGE, 'steps', lambda: self.rollout(plans=[RolloutPlan()], seconds=1e9)),
                (Status.OUT_OF_RANGE, 'positions', lambda: self.rollout(plans=[RolloutPlan()] * 100, seconds=9.0,
                                                                         sample_period=0.01, with_positions=True)),
                (Status.INVALID_ARGUMENT, 'points[0].pose', lambda: self.rollout(plans=[bad_pose], seconds=1.0)),
                (Status.INVALID_ARGUMENT, 'ascend', lambda: self.rollout(plans=[back], seconds=1.0)),
                (Status.UNAVAILABLE, 'nowhere', lambda: self.rollout(plans=[lost], seconds=1.0)),
                (Status.INVALID_ARGUMENT, 'follow_frame', lambda: self.rollout(plans=[follows], seconds=1.0))]:
            self.refuse(code, word, call)

    # trajectories

    def follow(self, *trajectories, **goal):
        self.feedback = []
        self.action.send_goal(FollowGraspTrajectoryGoal(trajectories=trajectories, **goal), feedback_cb=self.feedback.append)
        state = (actionlib.GoalStatus.ACTIVE, actionlib.GoalStatus.ABORTED)
        wait_until(lambda: self.action.get_state() in state, 'an active goal')
        wait_until(lambda: self.feedback or self.action.get_state() == actionlib.GoalStatus.ABORTED, 'feedback')

    def action_result(self):
        self.assertTrue(self.action.wait_for_result(rospy.Duration(DEADLINE)))
        return self.action.get_result()

    def test_a_grasp_goes_along_and_tells(self):
        self.follow(trajectory('hand', (0.5, 0.3, 1.0, 1.0), (1.0, 0.3, 1.2, 1.1)))
        self.sim.steps(50)
        self.assertEqual(node_position(self.sim.state('line'), 10), (0.3, 1.0, 1.0))
        wait_until(lambda: any(abs(f.time_from_start - 0.5) < 1e-9 for f in self.feedback), 'feedback at 0.5 s')
        half = next(f for f in self.feedback if abs(f.time_from_start - 0.5) < 1e-9)
        self.assertAlmostEqual(half.progress, 0.5)
        self.assertEqual(half.grasps, ['hand'])
        self.assertAlmostEqual(half.actual[0].position.x, 0.3)
        self.assertGreater(half.forces[0], 0.0)
        refused = self.sim.move_grasp('hand', PoseStamped(pose=Pose(orientation=Quaternion(w=1.0))), rospy.Duration(0))
        self.assertEqual(refused.status.code, Status.UNAVAILABLE)
        self.sim.steps(50)
        result = self.action_result()
        self.assertEqual(result.status.code, Status.OK, result.status.message)
        self.assertEqual(list(result.outcomes), [FollowGraspTrajectoryResult.REACHED])
        self.assertEqual(self.action.get_state(), actionlib.GoalStatus.SUCCEEDED)
        self.assertEqual(node_position(self.sim.state('line'), 10), (0.3, 1.2, 1.1))

    def test_it_can_be_cancelled(self):
        self.follow(trajectory('hand', (1.0, 0.3, 1.0, 1.5)))
        self.sim.steps(20)
        held = node_position(self.sim.state('line'), 10)
        self.action.cancel_goal()
        self.assertEqual(list(self.action_result().outcomes), [FollowGraspTrajectoryResult.STOPPED])
        self.assertEqual(self.action.get_state(), actionlib.GoalStatus.PREEMPTED)
        self.sim.steps(20)
        self.assertEqual(node_position(self.sim.state('line'), 10), held)

    def test_a_lost_grasp_ends_it(self):
        self.follow(trajectory('hand', (1.0, 0.3, 1.0, 1.5)))
        self.sim.steps(20)
        self.sim.release('hand')
        self.sim.steps(1)
        result = self.action_result()
        self.assertEqual(result.status.code, Status.UNAVAILABLE)
        self.assertIn("'hand' was lost", result.status.message)
        self.assertEqual(self.action.get_state(), actionlib.GoalStatus.ABORTED)

    def test_reset_and_bad_goals_end_it(self):
        self.follow(trajectory('hand', (1.0, 0.3, 1.0, 1.5)))
        self.assertTrue(self.sim.reset().success)
        self.assertIn('reset', self.action_result().status.message)
        before = self.sim.everything()
        for word, goal in [('none', []), ('nobody', [trajectory('nobody', (1, 0, 0, 0))]), ('no points', [trajectory('hand')]),
                           ('nowhere', [trajectory('hand', (1, 0, 0, 0), frame='nowhere')])]:
            self.follow(*goal)
            self.assertIn(word, self.action_result().status.message)
        self.assertEqual(before, self.sim.everything())

    def test_a_new_goal_takes_the_place_of_the_old(self):
        self.follow(trajectory('hand', (1.0, 0.3, 1.0, 1.5)))
        self.sim.steps(10)
        self.follow(trajectory('hand', (0.2, 0.3, 1.0, 0.9)))
        stepper = threading.Thread(target=lambda: self.sim.steps(60))
        stepper.start()
        self.assertEqual(self.action_result().status.code, Status.OK)
        stepper.join()
        self.assertEqual(node_position(self.sim.state('line'), 10), (0.3, 1.0, 0.9))


if __name__ == '__main__':
    rospy.init_node('rollout_test')
    rostest.rosrun('deformable_sim', 'rollout', WhatIf)
