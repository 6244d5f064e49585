"""The reports of `./run study`: what they read, what they pass, and that they need no matplotlib."""
import contextlib
import io
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

from script_loading import ROOT, load

ROWS = """A10|second, m|2|2.01|0.01|relative
A2|first, |f|/m at Gamma = 1|0|1e-9|1e-8|absolute
A2|H/W at Gamma = 1|0.5|0.5|0.01|relative
A2|H/W at Gamma = 10|1|1.1|0.01|relative
A2|H/W at Gamma = 100|5|5|0.01|relative
A2|H/W at Gamma = 1000|20|20|0.01|relative
A10|second, m|2|2.001|0.01|relative
"""


class Verification(unittest.TestCase):
    def setUp(self):
        self.report = load('scripts/verify_report')

    def test_reads_rows_whose_words_hold_bars(self):
        rows = self.report.parse_rows(ROWS)
        self.assertEqual(len(rows), 7)
        self.assertEqual(rows[1].what, 'first, |f|/m at Gamma = 1')
        self.assertEqual((rows[1].measured, rows[1].kind), (1e-9, 'absolute'))

    def test_refuses_a_line_that_is_no_row(self):
        for line in ('A1|too short|1|2', 'A1|x|1|2|0.1|sideways', 'A1|x|one|2|0.1|relative'):
            with self.assertRaises(ValueError):
                self.report.parse_rows(line + '\n')

    def test_a_row_passes_within_its_tolerance_only(self):
        row = self.report.Row
        self.assertTrue(self.report.passes(row('A', 'w', 2.0, 2.02, 0.01, 'relative')))
        self.assertFalse(self.report.passes(row('A', 'w', 2.0, 2.021, 0.01, 'relative')))
        self.assertFalse(self.report.passes(row('A', 'w', -2.0, 2.0, 0.01, 'relative')))
        self.assertTrue(self.report.passes(row('A', 'w', 0.0, 1e-9, 1e-8, 'absolute')))
        self.assertFalse(self.report.passes(row('A', 'w', 0.0, 1e-7, 1e-8, 'absolute')))
        self.assertFalse(self.report.passes(row('A', 'w', 1.0, math.nan, 1e8, 'relative')))

    def test_orders_yardsticks_by_number_and_keeps_the_last_of_a_repeated_row(self):
        groups = self.report.by_yardstick(self.report.parse_rows(ROWS))
        self.assertEqual([name for name, _ in groups], ['A2', 'A10'])
        self.assertEqual([r.measured for r in groups[1][1]], [2.001])

    def test_finds_the_curve_along_the_number_that_varies(self):
        found = self.report.families(self.report.parse_rows(ROWS))
        self.assertEqual([(words, [x for x, _ in points]) for words, points in found],
                         [('H/W at Gamma = #', [1.0, 10.0, 100.0, 1000.0])])

    def test_the_page_holds_every_row_and_marks_what_failed_without_matplotlib(self):
        groups = self.report.by_yardstick(self.report.parse_rows(ROWS))
        page = self.report.make_page(groups, [('Suite.Test', 1.5)], [], None)
        self.assertEqual(page.count('class="bad">FAILED'), 1)
        self.assertIn('6 rows of 2 yardsticks, 1 failed', page)
        self.assertIn('Suite.Test', page)


STUDY = [{'material': 'm', 'title': 'a <title>', 'kind': 'rope', 'model': 'rod', 'source': 's', 'curves': [], 'gaps': ['no twist'],
          'rows': [{'test': 'traction', 'quantity': 'EA', 'unit': 'N', 'put_in': 2.0, 'nodes': [3, 5, 9],
                    'measured': [2.2, None, 2.0], 'cpu_seconds': [0.1, 0.1, 0.1], 'limit': None, 'order': 'same',
                    'error': 0.0, 'gap': ''}]}]

# Stands in for the study program: writes the JSON it would write.
PROGRAM = '''#!%s
import json, os, sys
words = sys.argv[1:]
assert words[0] == 'material', words
folder = words[words.index('--out') + 1]
os.makedirs(folder, exist_ok=True)
json.dump(%s, open(os.path.join(folder, 'm.json'), 'w'))
'''


class Study(unittest.TestCase):
    def test_the_page_shows_values_gaps_and_what_is_missing(self):
        page = load('scripts/study_report').make_page(STUDY, None)
        for text in ('traction', 'gap: no twist', 'a &lt;title&gt;', '2.2', 'python3-matplotlib'):
            self.assertIn(text, page)

    def test_writes_the_page_beside_the_programs_results_and_passes_its_exit_status_on(self):
        with tempfile.TemporaryDirectory() as folder:
            program = os.path.join(folder, 'study')
            with open(program, 'w', encoding='utf-8') as stream:
                stream.write(PROGRAM % (sys.executable, repr(STUDY)))
            os.chmod(program, 0o755)
            script = [sys.executable, os.path.join(ROOT, 'scripts/study_report'), '--out', os.path.join(folder, 'out')]
            subprocess.check_call(script + ['--program', program, '--', '--model', 'rod', 'm'], stderr=subprocess.DEVNULL)
            self.assertTrue(os.path.exists(os.path.join(folder, 'out', 'm.html')))
            with open(os.path.join(folder, 'out', 'm.json'), encoding='utf-8') as stream:
                self.assertEqual(json.load(stream), STUDY)
            self.assertEqual(subprocess.call(script + ['--program', '/bin/false', '--', 'm']), 1)


RUN = {'integrator': 'bdf2', 'linear_solver': 'cg', 'family': 'bdf2, cg 0.1 x 200, Newton 1', 'dt_s': 0.01, 'status': 'done', 'note': '',
       'cpu_per_second': 0.5, 'position_error': 0.02, 'position_error_end': 0.01, 'time_error': 0.015, 'solver_error': None,
       'energy_error': 0.1, 'measure_error': 0.01, 'strain_error': 0.03, 'grasp_error': None, 'force_evaluations_per_second': 100,
       'newton_per_second': 50, 'linear_per_second': 70, 'unconverged_share': 0.5, 'settled': False}
PRECISION = {'name': 'swing', 'title': 'a <swing>', 'seconds': 1, 'features': {'kind': 'rope', 'nodes': 7, 'stiffness_ratio': 40.8,
                                                                             'explicit_steps_per_frame': 3.5},
             'reference': {'method': 'rk4', 'reached': 1e-9, 'check_method': 'tr_bdf2', 'check_reached': 1e-6, 'check_difference': 1e-7,
                           'resolution': 3e-5, 'halvings': []},
             'mesh': {'position': 0.004, 'uncertain': 1e-4, 'how': 'bdf2'}, 'model': {'position': None, 'uncertain': None, 'how': 'no cloth'},
             'picks': [{'wanted': 0.02, 'run': 0, 'why': ''}, {'wanted': 0.01, 'run': None, 'why': 'no run reached it'}], 'front': [0],
             'left_out': ['rk4: not run; the budget ended it'],
             'runs': [RUN, dict(RUN, position_error=1e-6), dict(RUN, status='diverged', note='no finite state', position_error=None,
                                                                 cpu_per_second=None)]}


class WorkPrecision(unittest.TestCase):
    def setUp(self):
        self.report = load('scripts/work_precision_report')

    def test_the_page_marks_what_diverged_what_is_unresolved_and_what_did_not_converge(self):
        page = self.report.scene_section(PRECISION, None)
        for text in ('diverged: no finite state', '0.0001 % (unresolved)', 'Newton not converged in 50 % of the steps', 'mesh: 0.4 %',
                     'model: not measured, no cloth', 'no run reached it', 'the budget ended it', 'python3-matplotlib'):
            self.assertIn(text, page)
        self.assertEqual(page.count('(unresolved)'), 1)

    def test_orders_runs_by_error_with_what_diverged_at_the_end(self):
        table = self.report.run_table(PRECISION)
        places = [table.index(text) for text in ('(unresolved)', '>2 %<', 'no finite state')]
        self.assertEqual(places, sorted(places))

    def test_collects_a_suite_for_people_and_for_programs(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in (('swing.json', PRECISION), ('swing.summary.json', {'name': 'swing', 'front': []})):
                with open(os.path.join(folder, name), 'w', encoding='utf-8') as stream:
                    json.dump(text, stream)
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                study = self.report.write_scene(os.path.join(folder, 'swing'), None)
                self.report.write_suite(folder, [study])
            with open(os.path.join(folder, 'suite.html'), encoding='utf-8') as stream:
                self.assertIn('bdf2, cg 0.1 x 200, Newton 1', stream.read())
            with open(os.path.join(folder, 'suite.summary.json'), encoding='utf-8') as stream:
                self.assertEqual(json.load(stream), [{'name': 'swing', 'front': []}])

    def test_passes_the_exit_status_on_and_names_the_folder(self):
        script = [sys.executable, os.path.join(ROOT, 'scripts/work_precision_report'), '--out', 'somewhere']
        self.assertEqual(subprocess.call(script + ['--program', '/bin/false', '--', 'minimal']), 1)
        said = subprocess.check_output(script + ['--program', '/bin/echo', '--', '--list'], universal_newlines=True)
        self.assertEqual(said.split(), ['work_precision', '--list'])


def cell(**changes):
    row = {'slice': 'stiffness', 'body': 'rope', 'way': 'scheme', 'integrator': 'rk4', 'linear_solver': '', 'step_s': '0.01',
           'stiffness_Pa': '100', 'damping_s': '0', 'mass_ratio': '1', 'aspect': '1', 'class': 'right', 'error': '0.001', 'says': '0',
           'limit_s': '0.2', 'note': ''}
    return dict(row, **changes)


AUTO = {'way': 'auto', 'integrator': '', 'limit_s': 'inf'}
MAP = [cell(), cell(step_s='1', **{'class': 'diverged'}), cell(way='world', step_s='1', **{'class': 'wrong'}),
       cell(**AUTO), cell(step_s='1', says='1', **dict(AUTO, **{'class': 'wrong'})),
       cell(body='sheet', step_s='1', **dict(AUTO, **{'class': 'wrong'}))]
LIMITS = [{'body': 'rope', 'integrator': 'explicit_euler', 'damping_ratio': '0', 'theory_s': '0', 'fastest_motion_s': '0', 'measured_s': '0'},
          {'body': 'rope', 'integrator': 'explicit_euler', 'damping_ratio': '1', 'theory_s': '0.2', 'fastest_motion_s': '0.1',
           'measured_s': '0.201'}]


class Stability(unittest.TestCase):
    def setUp(self):
        self.report = load('scripts/stability_report')

    def test_counts_the_classes_of_each_panel_and_what_is_off_in_silence(self):
        counts = self.report.counts(MAP)
        self.assertEqual([(who, where, silent) for who, _, where, _, silent in counts],
                         [('rk4', 'rope, stiffness', 1), ('world, rk4', 'rope, stiffness', 1),
                          ('world, `solver: auto`', 'rope, stiffness', 0), ('world, `solver: auto`', 'sheet, stiffness', 1)])
        self.assertEqual(counts[0][3]['right'], 1)
        self.assertEqual(counts[0][3]['diverged'], 1)

    def test_the_tables_give_measured_over_theory_and_say_where_there_is_no_stable_step(self):
        self.assertIn('| rope, `explicit_euler` | none | 1.0050 |', self.report.markdown(MAP, LIMITS))
        self.assertNotIn('theoretical', self.report.markdown(MAP, []))

    def test_cells_meet_half_way_between_steps_in_the_logarithm(self):
        for found, expected in zip(self.report.edges([1e-2, 1e-1, 1.0]), [-2.5, -1.5, -0.5, 0.5]):
            self.assertAlmostEqual(found, expected)

    def test_puts_slices_of_worlds_alone_behind_those_of_schemes(self):
        lines = self.report.layout(MAP)
        self.assertEqual([what for _, what, _ in lines], ['scheme alone', 'as users get it'])
        self.assertEqual([title for title, _, _ in lines[0][2]], ['rk4', 'solver: auto'])
        self.assertEqual([title for title, _, _ in lines[1][2]], ['rk4', 'auto: sheet, stiffness'])

    def test_the_page_needs_no_matplotlib(self):
        page = self.report.page(MAP, LIMITS, None)
        for text in ('6 cells', 'python3-matplotlib', 'world, `solver: auto`', '0.201'):
            self.assertIn(text, page)

    def test_passes_the_exit_status_on_and_names_the_folder(self):
        script = [sys.executable, os.path.join(ROOT, 'scripts/stability_report'), '--out', 'somewhere']
        self.assertEqual(subprocess.call(script + ['--program', '/bin/false', '--', '--quick']), 1)
        said = subprocess.check_output(script + ['--program', '/bin/echo', '--', '--help'], universal_newlines=True)
        self.assertEqual(said.split(), ['stability', '--help'])


if __name__ == '__main__':
    unittest.main()
