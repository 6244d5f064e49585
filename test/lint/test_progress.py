"""The bar of commands that take their time: on a terminal alone, and gone at the end."""
import io
import os
import sys
import unittest
from unittest import mock

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, 'scripts'))
import progress  # noqa: E402


class Terminal(io.StringIO):
    def isatty(self):
        return True


def bar_of(stream, quiet=False):
    with mock.patch.object(sys, 'stderr', stream), mock.patch.object(progress, 'SOON', 0.0):
        with progress.Progress(quiet, 4) as bar:
            bar.show(1, 'first')
            bar.step('second')
    return stream.getvalue()


class ProgressTest(unittest.TestCase):
    def test_draws_shares_on_a_terminal_and_takes_them_away(self):
        text = bar_of(Terminal())
        self.assertIn('[######..................]', text)
        self.assertIn('[############............]', text)
        self.assertIn('second', text)
        self.assertTrue(text.endswith('\r\033[K'))

    def test_writes_nothing_elsewhere_or_when_quiet(self):
        self.assertEqual(bar_of(io.StringIO()), '')
        self.assertEqual(bar_of(Terminal(), quiet=True), '')

    def test_says_nothing_of_what_is_soon_done(self):
        stream = Terminal()
        with mock.patch.object(sys, 'stderr', stream), progress.Progress() as bar:
            bar.show(0.5, 'half')
        self.assertEqual(stream.getvalue(), '')

    def test_counts_the_cases_of_a_benchmark(self):
        # A program that lists two cases and runs them, as Google Benchmark does.
        script = ('import sys\n'
                  'names = ("step/10", "step/20")\n'
                  'if "--benchmark_list_tests" in sys.argv: print("\\n".join(names))\n'
                  'else:\n'
                  '    print("Benchmark  Time")\n'
                  '    for name in names: print(name + "/iterations:3  5 ns")\n'
                  '    sys.exit("done")\n')
        bar = progress.Progress()
        self.assertEqual(progress.run_benchmark([sys.executable, '-c', script], bar), (1, 'done\n'))
        self.assertEqual((bar.done, bar.whole), (2.0, 2))


if __name__ == '__main__':
    unittest.main()
