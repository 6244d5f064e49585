"""The mutants of `./run test --mutations` match the code they mutate, and the judge tells life from death."""
import os
import tempfile
import unittest

from script_loading import ROOT, load


class Mutants(unittest.TestCase):
    def setUp(self):
        self.mutations = load('scripts/mutations')
        self.mutants = self.mutations.load_mutants()

    def test_there_are_at_least_forty_over_every_part(self):
        self.assertGreaterEqual(len(self.mutants), 40)
        files = ' '.join(m['file'] for m in self.mutants)
        for part in ('element/', 'energy/', 'material/', 'integrator/', 'grasp/'):
            self.assertIn(part, files)
        keys = {self.mutations.Results.key(m) for m in self.mutants}
        self.assertEqual(len(keys), len(self.mutants))

    def test_each_text_stands_once_in_its_file(self):
        for mutant in self.mutants:
            with self.subTest(file=mutant['file'], why=mutant['why']):
                self.assertIsNone(self.mutations.problems_of(mutant))

    def test_a_mutant_that_no_longer_matches_is_named(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, 'a.cpp'), 'w', encoding='utf-8') as stream:
                stream.write('x = 1;\nx = 1;\n')
            mutant = {'file': 'a.cpp', 'find': 'y', 'replace': 'z', 'why': 'w'}
            self.assertIn('found 0 times', self.mutations.problems_of(mutant, folder))
            self.assertIn('found 2 times', self.mutations.problems_of(dict(mutant, find='x = 1'), folder))
            self.assertIn('no file', self.mutations.problems_of(dict(mutant, file='b.cpp'), folder))
            self.assertIn('needs why', self.mutations.problems_of(dict(mutant, why='')))

    def test_workers_compile_the_same_text(self):
        with open(os.path.join(ROOT, 'cmake/tests.cmake'), 'rb') as stream:
            text = self.mutations.text_for_workers('cmake/tests.cmake', stream.read())
        for of_the_worker in (b'CMAKE_CURRENT_SOURCE_DIR', b'TARGET_FILE'):
            self.assertNotIn(of_the_worker, text)

    def test_what_workers_copy_can_be_configured(self):
        with tempfile.TemporaryDirectory() as folder:
            worker = self.mutations.Worker(folder)
            worker.prepare()
            self.assertTrue(os.path.exists(os.path.join(worker.build, 'Makefile')))

    def test_results_are_kept_for_the_same_sources_only(self):
        mutant = {'file': 'a.cpp', 'find': 'y', 'replace': 'z', 'why': 'w'}
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, 'results.json')
            self.mutations.print = lambda *_, **__: None
            self.mutations.Results(path, 'one').add(mutant, 'killed', 'A.B', 1.0)
            self.assertEqual(self.mutations.Results(path, 'one').outcomes, {self.mutations.Results.key(mutant): ['killed', 'A.B', 1.0]})
            self.assertEqual(self.mutations.Results(path, 'two').outcomes, {})


class Judge(unittest.TestCase):
    """With programs that look at the mutated file themselves."""

    def setUp(self):
        self.mutations = load('scripts/mutations')
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.worker = self.mutations.Worker(folder.name)
        os.makedirs(self.worker.tree)
        os.makedirs(self.worker.build)
        self.path = os.path.join(self.worker.tree, 'a.cpp')
        with open(self.path, 'w', encoding='utf-8') as stream:
            stream.write('x = 1;')
        for program in self.mutations.PROGRAMS:
            full = os.path.join(self.worker.build, program)
            with open(full, 'w', encoding='utf-8') as stream:
                stream.write('#!/bin/sh\ngrep -q "x = 2" %s || exit 0\necho "[  FAILED  ] Suite.Name (1 ms)"\nexit 1\n' % self.path)
            os.chmod(full, 0o755)

    def judge(self, replacement, build_output=None):
        self.worker.make = lambda: build_output
        return self.worker.judge({'file': 'a.cpp', 'find': 'x = 1', 'replace': replacement, 'why': 'w', 'tests': 'Suite*'})

    def test_names_the_test_that_killed_and_restores_the_file(self):
        self.assertEqual(self.judge('x = 2'), ('killed', 'Suite.Name'))
        with open(self.path, encoding='utf-8') as stream:
            self.assertEqual(stream.read(), 'x = 1;')

    def test_tells_survivors_from_what_does_not_compile(self):
        self.assertEqual(self.judge('x = 3'), ('survived', ''))
        self.assertEqual(self.judge('x = 2', 'a.cpp:1: error: no')[0], 'broken')


if __name__ == '__main__':
    unittest.main()
