"""A progress bar on standard error of a terminal; elsewhere, and with --quiet, nothing."""
import os
import subprocess
import sys
import tempfile
import time

WIDTH = 24
SOON = 2.0  # s without a bar
LONGEST = 60


def add_quiet(parser):
    parser.add_argument('--quiet', action='store_true', help='no progress bar')


class Progress:
    """Use as a context: the bar is taken away at its end."""

    def __init__(self, quiet=False, whole=1.0):
        self.shown = sys.stderr.isatty() and not quiet
        self.whole = whole
        self.began = time.monotonic()
        self.done = 0.0
        self.drawn = False

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.wipe()

    def begin(self, what, whole):
        """A part of `whole` steps, on its own."""
        self.whole, self.done, self.began = whole, 0.0, time.monotonic()
        self.show(0.0, what)

    def show(self, done, what=''):
        """`done` of `whole`; what is done now."""
        taken = time.monotonic() - self.began
        self.done = done
        if not self.shown or taken < SOON:
            return
        share = min(1.0, max(0.0, done / self.whole)) if self.whole else 1.0
        left = '%d:%02d left  ' % divmod(int(taken * (1.0 - share) / share), 60) if share > 0.0 else ''
        full = int(round(share * WIDTH))
        self.wipe()
        sys.stderr.write('[%s%s] %s%s' % ('#' * full, '.' * (WIDTH - full), left, what[:LONGEST]))
        sys.stderr.flush()
        self.drawn = True

    def step(self, what=''):
        """One more is done."""
        self.show(self.done + 1.0, what)

    def wipe(self):
        """Before anything is printed."""
        if self.drawn:
            sys.stderr.write('\r\033[K')
            sys.stderr.flush()
        self.drawn = False


def run_benchmark(command, progress):
    """Runs a Google Benchmark program, a step for each case; (exit status, what it said on standard error)."""
    cases = subprocess.run(command + ['--benchmark_list_tests'], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                           universal_newlines=True)
    progress.begin(os.path.basename(command[0]), max(1, len(cases.stdout.splitlines())))
    with tempfile.TemporaryFile('w+') as said:
        with subprocess.Popen(['stdbuf', '-oL'] + command, stdout=subprocess.PIPE, stderr=said,
                              universal_newlines=True) as process:
            for line in process.stdout:
                if line[:1].isalpha() and '/' in line.split()[0]:
                    progress.step('%s: %s' % (os.path.basename(command[0]), line.split()[0]))
        said.seek(0)
        return process.returncode, said.read()
