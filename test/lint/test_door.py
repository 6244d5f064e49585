"""./run and the test runner: what they refuse, what they count, and that nothing outlives them."""
import os
import subprocess
import sys
import tempfile
import unittest

from script_loading import ROOT, load


def door(*arguments, **options):
    return subprocess.run(arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True, **options)


class Door(unittest.TestCase):
    def test_lists_its_commands_from_any_directory_and_through_a_link(self):
        with tempfile.TemporaryDirectory() as folder:
            link = os.path.join(folder, 'door')
            os.symlink(os.path.join(ROOT, 'run'), link)
            done = door(link, cwd=folder)
        self.assertEqual(done.returncode, 0)
        for command in ('demo', 'test', 'build', 'simulate', 'study', 'exec', 'lint', 'bench', 'package', 'gallery'):
            self.assertIn('\n  %s ' % command, done.stdout)

    def test_refuses_an_unknown_command_by_name(self):
        done = door(os.path.join(ROOT, 'run'), 'fold')
        self.assertEqual(done.returncode, 1)
        self.assertIn("unknown command 'fold'", done.stdout)

    def test_every_package_has_a_set_and_a_name_on_both_systems(self):
        seen = set()
        with open(os.path.join(ROOT, 'scripts/packages.txt'), encoding='utf-8') as stream:
            rows = [line.split() for line in stream if line.strip() and not line.startswith('#')]
        for row in rows:
            self.assertEqual(len(row), 3, row)
            self.assertIn(row[0], ('build', 'demo', 'test', 'package', 'bench', 'fuzz', 'study', 'peers'))
            self.assertNotIn(row[1], seen)
            seen.add(row[1])


RESULTS = """<testsuites><testsuite>
  <testcase classname="A" name="passes" status="run"/>
  <testcase classname="A" name="fails" status="run"><failure message="expected 1, was 2"/></testcase>
  <testcase classname="A" name="breaks"><error type="E">traceback</error></testcase>
  <testcase classname="A" name="is_disabled" status="notrun"/>
</testsuite></testsuites>"""


class Runner(unittest.TestCase):
    def setUp(self):
        self.runner = load('scripts/run_tests')
        self.tally = self.runner.Tally()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def counts(self):
        return self.tally.passed, len(self.tally.failures), self.tally.skipped

    def test_counts_failures_and_errors_apart_from_what_did_not_run(self):
        path = os.path.join(self.folder, 'results.xml')
        with open(path, 'w', encoding='utf-8') as stream:
            stream.write(RESULTS)
        self.runner.read_results(path, self.tally)
        self.assertEqual(self.counts(), (1, 2, 1))
        self.assertEqual([p for _, p in self.tally.failures], ['expected 1, was 2', 'traceback'])

    def test_a_crash_without_results_is_a_failure(self):
        self.runner.run_gtest('crash', ['sh', '-c', 'kill -SEGV $$'], self.folder, 60, self.tally)
        self.assertEqual(self.counts(), (0, 1, 0))

    def test_a_truncated_result_file_is_a_failure(self):
        path = os.path.join(self.folder, 'results.xml')
        with open(path, 'w', encoding='utf-8') as stream:
            stream.write(RESULTS[:100])
        self.runner.read_results(path, self.tally)
        self.assertEqual(self.counts(), (0, 1, 0))

    def test_a_program_that_never_ends_is_ended_with_its_children(self):
        program = 'import subprocess as s; p = s.Popen(["sleep", "1000"]); print(p.pid, flush=True); p.wait()'
        status, output = self.runner.run([sys.executable, '-c', program], 1.0)
        self.assertIsNone(status)
        self.assertFalse(os.path.exists('/proc/%d' % int(output.split()[0])))


if __name__ == '__main__':
    unittest.main()
