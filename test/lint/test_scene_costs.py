#!/usr/bin/env python3
"""What the check of scenes' costs lets through."""
import importlib.machinery
import importlib.util
import os
import sys
import unittest

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def load(name):
    loader = importlib.machinery.SourceFileLoader(name, os.path.join(ROOT, 'scripts', name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
    return module


def cost(instructions, *bill):
    return {'bill': list(bill), 'instructions_per_step': instructions}


class SceneCosts(unittest.TestCase):
    def setUp(self):
        self.compare = load('scene_costs').compare

    def test_two_percent_more_pass_and_three_do_not(self):
        self.assertEqual(self.compare({'towel': cost(1019)}, {'towel': cost(1000)}), [])
        self.assertEqual(self.compare({'towel': cost(500)}, {'towel': cost(1000)}), [])
        lines = self.compare({'towel': cost(1030)}, {'towel': cost(1000)})
        self.assertEqual(len(lines), 1)
        self.assertIn('towel: 1030', lines[0])
        self.assertIn('+3.0 %', lines[0])

    def test_a_part_more_or_less_on_the_bill_fails(self):
        stored = {'flag': cost(1, 'gravity: 9 elements', 'drag: 8 elements')}
        self.assertEqual(self.compare({'flag': cost(1, 'gravity: 9 elements', 'drag: 8 elements')}, stored), [])
        self.assertIn('- drag', self.compare({'flag': cost(1, 'gravity: 9 elements')}, stored)[0])
        self.assertIn('+ drag: 7', self.compare({'flag': cost(1, 'gravity: 9 elements', 'drag: 7 elements')}, stored)[0])

    def test_bills_are_compared_without_counts(self):
        self.assertEqual(self.compare({'flag': {'bill': ['a']}}, {'flag': cost(1, 'a')}), [])
        self.assertEqual(len(self.compare({'flag': {'bill': ['b']}}, {'flag': cost(1, 'a')})), 1)

    def test_a_scene_without_costs_fails(self):
        self.assertIn('flag', self.compare({'flag': cost(1)}, {})[0])


if __name__ == '__main__':
    unittest.main()
