#!/usr/bin/env python3
"""Every snippet of the documentation runs: scenes load, commands answer, programs end well."""

import os
import sys
import tempfile
import time
import unittest

import roslib.packages
import rospy
import rostest

from snippets import Page

ROOT = roslib.packages.get_pkg_dir('deformable_sim')
sys.path.insert(0, os.path.join(ROOT, 'test', 'lint'))

import documents  # noqa: E402

ELSEWHERE = {('doc/python.md', 'python')}  # run by python_examples_test.py, as one program

BROKEN = {
    'a key that no scene has': ('yaml', 'step: {accuracy: 0.01, speed: 2}\n', 'speed'),
    'a scene that refers to nothing': ('yaml', '- cloth: {name: a, material: no_such_fabric}\n', 'no_such_fabric'),
    'the second of two scenes': ('yaml', 'gravity: [0, 0, -1]\n---\ngravity: [0, 0]\n', 'gravity'),
    'a command that fails': ('sh', 'echo one\nls no_such_file   # a comment\n', 'no_such_file'),
    'an option that is not there': ('sh', './run simulate minimal --seconds 5 --no_such_option\n', '--no_such_option'),
    'a command of ./run': ('sh', './run fly\n', 'fly'),
    'a study that is not there': ('sh', './run study no_such_study\n', 'no_such_study'),
    'half a command': ('sh', 'echo "one\n', 'whole'),
    'a node that does not start': ('sh', 'rosrun deformable_sim sim_node __name:=gone _scene:=no_such_scene\n', 'no_such_scene'),
    'a launch file': ('xml', '<node name="a" pkg="b"/>\n', 'type'),
    'a program': ('python', 'print(undefined)\n', 'undefined'),
    'an answer': ('sh', 'echo "a: 1"   # -> a: 2\n', 'a: 2'),
    'a refusal nobody expects': ('sh', 'echo "  code: 2"\n', 'refused'),
    'a refusal that does not come': ('sh', 'echo "  code: 0"   # refused\n', 'not refused'),
}


class Documentation(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.page = Page(ROOT, self.folder.name)
        self.addCleanup(self.clean)

    def clean(self):
        self.page.close()
        if rospy.has_param('/use_sim_time'):
            rospy.delete_param('/use_sim_time')

    def check(self, page):
        start = time.monotonic()
        found = [s for s in documents.snippets(ROOT, page) if (page, s.language) not in ELSEWHERE]
        problems = []
        for snippet in found:
            problem = self.page.problem_of(snippet)
            if problem:
                problems.append(problem)
        left_out = [s for s in found if s.not_run]
        print('%s: %d snippets, %d commands and blocks run, %d of them only looked up, %d not run, %.1f s' % (
            page, len(found), self.page.ran, self.page.named, len(left_out), time.monotonic() - start))
        for snippet in left_out:
            print('  not run, line %d: %s' % (snippet.line, snippet.not_run))
        self.assertEqual(problems, [], '\n'.join([''] + problems))

    def test_broken_snippets_are_seen(self):
        for name, (language, text, word) in BROKEN.items():
            with self.subTest(name):
                problem = self.page.problem_of(documents.Snippet('page.md', 7, language, text, None, None, False, None))
                self.assertIsNotNone(problem)
                self.assertTrue(problem.startswith('page.md:7: '), problem)
                self.assertIn(word, problem)

    def test_a_saved_file_is_there_for_the_next_snippet(self):
        for language, text, file, why in (('yaml', 'gravity: [0, 0, 0]\n', 'one.yaml', None), ('sh', 'cat one.yaml\n', None, None),
                                          ('sh', 'ls no_such_file\n', None, 'it is not there')):
            self.assertIsNone(self.page.problem_of(documents.Snippet('page.md', 7, language, text, why, file, False, None)))


def of_page(page):
    return lambda self: self.check(page)


for name in documents.pages(ROOT):
    if documents.snippets(ROOT, name):
        setattr(Documentation, 'test_' + name.replace('/', '_').replace('.md', ''), of_page(name))


if __name__ == '__main__':
    rospy.init_node('documentation_test')
    rostest.rosrun('deformable_sim', 'documentation', Documentation)
