#!/usr/bin/env python3
"""A short part of ./run study fuzz_messages: the node outlives hostile messages, and is not changed by them."""

import unittest

import rospy
import rostest

from message_fuzz import MessageFuzz

SEED = 20
BATCHES, MESSAGES = 6, 200


class HostileMessages(unittest.TestCase):
    def test_leave_the_node_answering_with_finite_numbers_and_the_bits_of_a_fresh_run(self):
        fuzz = MessageFuzz(SEED, 'deformable_sim', rospy.get_param('/deformable_sim/scene'))
        fuzz.settle()
        for _ in range(BATCHES):
            fuzz.batch(MESSAGES)
        self.assertEqual(fuzz.total, BATCHES * MESSAGES)
        self.assertGreater(fuzz.granted, fuzz.total // 20, 'what is always refused changes nothing')


if __name__ == '__main__':
    rospy.init_node('fuzz_test')
    rostest.rosrun('deformable_sim', 'fuzz', HostileMessages)
