"""The reports of `./run study`: what they read, what they pass, and that they need no matplotlib."""
import importlib.machinery
import importlib.util
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def load(path):
    loader = importlib.machinery.SourceFileLoader(os.path.basename(path), os.path.join(ROOT, path))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module


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


if __name__ == '__main__':
    unittest.main()
