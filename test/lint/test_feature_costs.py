#!/usr/bin/env python3
"""What the table of features' costs is made of, and what it refuses."""
import os
import unittest

import yaml

from script_loading import ROOT, load

TABLE = {'kind': 'cloth', 'title': 'A sheet',
         'scene': {'step': {'dt': 0.01, 'integrator': 'bdf2'}, 'body': {'name': 'it', 'material': {'damping': 0.1}}},
         'used': [{'of': 'air', 'rows': {'drag': {'air': {'drag_coefficient': 1}}}},
                  {'of': 'chosen', 'rows': {'auto': {'step': {'integrator': None}}}}],
         'unused': {'no drag': {'air': {'drag_coefficient': 0}}}}


class FeatureCosts(unittest.TestCase):
    def setUp(self):
        self.tool = load('scripts/feature_costs')

    def test_a_change_is_merged_key_by_key_and_null_takes_a_key_away(self):
        base = {'step': {'dt': 0.01, 'integrator': 'bdf2'}, 'list': [1]}
        self.assertEqual(self.tool.merged(base, {'step': {'integrator': None}, 'list': [2]}),
                         {'step': {'dt': 0.01}, 'list': [2]})
        self.assertEqual(base['step']['integrator'], 'bdf2')

    def test_rows_are_scenes_of_one_body(self):
        rows = list(self.tool.rows_of(TABLE))
        self.assertEqual([(of, what) for of, what, _ in rows],
                         [('base', 'base'), ('air', 'drag'), ('chosen', 'auto'), ('unused', 'no drag')])
        self.assertEqual(rows[1][2]['bodies'], [{'cloth': TABLE['scene']['body']}])
        self.assertEqual(rows[2][2]['step'], {'dt': 0.01})

    def test_every_row_that_is_shipped_changes_its_base(self):
        with open(os.path.join(ROOT, 'scripts/features.yaml'), encoding='utf-8') as stream:
            tables = yaml.safe_load(stream)['tables']
        for table in tables:
            scenes = [(what, scene) for _, what, scene in self.tool.rows_of(table)]
            for what, scene in scenes[1:]:
                self.assertNotEqual(scene, scenes[0][1], what)
                self.assertIn('dt', scene['step'], what)

    def test_costs_are_set_against_the_base(self):
        lines, problems = self.tool.markdown(TABLE, [1000000.0, 1250000.0, 3000000.0, 1000100.0])
        self.assertEqual(problems, [])
        self.assertIn('| drag | 1.25 M | +25.0 % |', lines)
        self.assertIn('| auto | 3 M | x 3 |', lines)
        self.assertIn('| no drag | 1 M | 0 |', lines)

    def test_what_costs_something_unused_fails(self):
        _, problems = self.tool.markdown(TABLE, [1000000.0, 1250000.0, 3000000.0, 1010000.0])
        self.assertEqual(len(problems), 1)
        self.assertIn('no drag: 1010000', problems[0])

    def test_a_scene_that_does_not_run_fails_and_has_no_row(self):
        lines, problems = self.tool.markdown(TABLE, [1000000.0, 'unknown key', 3000000.0, 1000000.0])
        self.assertEqual(problems, ['drag: unknown key'])
        self.assertFalse([line for line in lines if line.startswith('| drag')])


if __name__ == '__main__':
    unittest.main()
