"""Runs the snippets of one documentation page, in their order, as a reader would (CONTRIBUTING.md, Documentation).

All in one folder, which has links to everything in the checkout. What does not end by itself is started, waited for, and
stopped at the end of the page, or when a node of the same name is started.
"""

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import threading
import time

import roslaunch.config
import roslib.packages
import rosnode
import rosservice
import yaml

LIMIT = 60.0  # s, wall: of one command
SECONDS = 0.02  # s: what `simulate` steps, whatever the page says
BODY = 'bodies: [{cloth: {name: towel}}]\n'
# These build, measure or test for minutes: only that ./run knows them.
SLOW = ('', 'demo', 'build', 'test', 'bench', 'study', 'lint', 'install')
ENDLESS = re.compile(r'rostopic (echo(?!.* -n )|hz|bw)')

# Python snippets of a page are one program; one that connects to ROS begins another.
CONNECTS = re.compile(r'init_node\(|\.connect\(')
PROGRAM = '''
import json, sys, traceback
names = {'__name__': '__main__'}
for line in sys.stdin:
    status = 0
    try:
        exec(compile(json.loads(line), 'snippet', 'exec'), names)
    except SystemExit as end:
        status = end.code or 0
    except BaseException:
        traceback.print_exc()
        status = 1
    print('\\nsnippet ended with', status, flush=True)
'''


# `rosservice call` without its second of start: one process has all loaded, and makes a copy of itself for each call.
CALLS = '''
import os, sys, rosservice, rospy
import deformable_sim.srv, std_srvs.srv
for line in sys.stdin:
    path, *words = eval(line)
    child = os.fork()
    if not child:
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT), 1)
        os.dup2(1, 2)
        try:
            rosservice.rosservicemain(words)
            status = 0
        except SystemExit as end:
            status = end.code or 0
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status if isinstance(status, int) else 1)
    print(os.WEXITSTATUS(os.waitpid(child, 0)[1]), flush=True)
'''


class Broken(Exception):
    """What is wrong with a snippet."""


def programs(name):
    return roslib.packages.find_node('deformable_sim', name)[0]


def commands(text):
    """The commands of a shell snippet: lines, joined where one goes on."""
    found = ['']
    for line in text.splitlines():
        found[-1] += ('\n' if found[-1] else '') + line
        if subprocess.run(['bash', '-n', '-c', found[-1]], stderr=subprocess.DEVNULL, check=False).returncode == 0 \
                and not line.endswith('\\'):
            found.append('')
    if found[-1]:
        raise Broken('not a whole command: ' + found[-1])
    return [command for command in found if command and not command.lstrip().startswith('#')]


def scenes(text):
    """Whole scenes from what a YAML snippet says: one for each document in it."""
    for document in text.split('\n---\n'):
        content = yaml.safe_load(document)
        if isinstance(content, list):
            kind = 'bodies' if all(set(item) <= {'cloth', 'rope', 'soft'} for item in content) else 'colliders'
            document = kind + ':\n' + ''.join('  %s\n' % line for line in document.splitlines())
            content = {kind: content}
        yield document + ('' if 'bodies' in content else '\n' + BODY)


class Page:
    """One page while its snippets are run."""

    def __init__(self, root, folder):
        self.root = root
        self.folder = folder
        self.running = {}  # node, or command: process, what it wrote
        self.ran = 0
        self.named = 0
        self.program = None
        self.caller = None
        for name in os.listdir(root):
            if not name.startswith('.') or name == '.build':
                os.symlink(os.path.join(root, name), os.path.join(folder, name))
        with open(os.path.join(root, 'run'), encoding='utf-8') as stream:
            self.run_script = stream.read()

    def problem_of(self, snippet):
        """None, or what is wrong with it."""
        try:
            if snippet.file:
                with open(os.path.join(self.folder, snippet.file), 'w', encoding='utf-8') as stream:
                    stream.write(snippet.text)
            if not snippet.not_run:
                if snippet.beside:
                    self.start_beside(snippet.beside)
                getattr(self, 'run_' + snippet.language)(snippet)
        except Broken as broken:
            return '%s:%d: %s' % (snippet.page, snippet.line, broken)
        return None

    def run_yaml(self, snippet):
        for text in scenes(snippet.text):
            path = os.path.join(self.folder, 'of_the_page.yaml')
            with open(path, 'w', encoding='utf-8') as stream:
                stream.write(text)
            self.finish([programs('simulate'), path, '--seconds', '0.01', '--quiet'])
        self.ran += 1

    def run_xml(self, snippet):
        text = snippet.text if '<launch>' in snippet.text else '<launch>\n%s</launch>\n' % snippet.text
        try:
            roslaunch.config.load_config_default([], None, roslaunch_strs=[text])
        except Exception as error:  # of many kinds
            raise Broken(str(error)) from error
        self.ran += 1

    def run_python(self, snippet):
        try:
            compile(snippet.text, snippet.page, 'exec')
        except SyntaxError as error:
            raise Broken(str(error)) from error
        self.ran += 1
        if not snippet.file:
            self.go_on_with(snippet.text)

    def run_console(self, snippet):
        self.run_sh(snippet._replace(text=''.join(
            line[2:] + '\n' for line in snippet.text.splitlines() if line.startswith('$ '))))

    def run_sh(self, snippet):
        for command in commands(snippet.text):
            self.run_command(command, snippet.stays)

    def run_command(self, command, stays):
        words = shlex.split(command, comments=True)
        self.ran += 1
        if words[0] == './run' and words[1:2] == ['exec']:
            command, words = command.replace('./run exec ', '', 1), words[2:]
        if words[0] == 'rostest':
            self.exists(os.path.join('test', 'ros', words[2]))
        elif words[0] == 'source':
            self.exists(words[1])
        elif words[0] == './run' and words[1:2] != ['simulate']:
            self.know(words[1:])
        elif words[0] == 'roslaunch' or words[:3] == ['rosrun', 'deformable_sim', 'sim_node']:
            self.start_node(command, words)
        elif stays:
            self.start_beside(command)
        elif ENDLESS.search(command):
            self.first_line(command)
        elif words[:2] == ['rosservice', 'call'] and not re.search(r'[|;&]|\$\(', command.split('#')[0]):
            self.judge(command, self.call(words))
        else:
            answer = self.finish(['bash', '-o', 'pipefail', '-c', self.shortened(command)])
            self.judge(command, answer)

    @staticmethod
    def shortened(command):
        command = re.sub(r'\./run simulate|rosrun deformable_sim simulate', programs('simulate'), command)
        return re.sub(r'(/simulate \S.*?--seconds) [\d.]+', r'\1 %g' % SECONDS, command)

    @staticmethod
    def judge(command, answer):
        """Answers of services are refusals where the snippet says so, and nowhere else; `# -> text` is in the answer."""
        refused = bool(re.search(r'^\s*code: [1-9]|success: False', answer, re.MULTILINE))
        if refused != ('# refused' in command):
            raise Broken('%s: %s\n%s' % (command, 'refused' if refused else 'not refused', answer))
        wanted = re.search(r'# -> (.*)', command)
        if wanted and ' '.join(wanted.group(1).split()) not in ' '.join(answer.split()):
            raise Broken('%s: answered\n%s' % (command, answer))

    def exists(self, path):
        if not os.path.exists(os.path.join(self.folder, path)):
            raise Broken('no file ' + path)
        self.named += 1

    def know(self, words):
        name = words[0] if words else ''
        if name not in SLOW:
            raise Broken('./run does not know %s' % name)
        kind = next((word for word in words[1:] if re.match(r'[a-z_]+$', word)), None)
        # What ./run does not know itself, the program `study` does.
        if name in ('bench', 'study') and words[1:] and kind == words[1] and not re.search(
                r'^ +%s\)|== %s \]\]|=~ \^\(.*\b%s\b.*\)\$ \]\]' % (kind, kind, kind), self.run_script, re.MULTILINE):
            if not re.search(r'\b%s\b' % kind, self.finish([programs('study'), '--help'], expect=(0, 2))):
                raise Broken('./run %s does not know %s' % (name, kind))
        self.named += 1

    # --- processes ------------------------------------------------------------------------------------------------

    def spawn(self, command, stdin=subprocess.DEVNULL):
        output = open(os.path.join(self.folder, '.output_%d' % self.ran), 'w+', encoding='utf-8', errors='replace')
        process = subprocess.Popen(command, cwd=self.folder, stdout=output, stderr=subprocess.STDOUT, start_new_session=True,
                                   env=dict(os.environ, PYTHONUNBUFFERED='1'), stdin=stdin)
        return process, output.name

    @staticmethod
    def written(path):
        with open(path, encoding='utf-8', errors='replace') as stream:
            return stream.read()

    def finish(self, command, expect=(0,)):
        """What it wrote."""
        process, path = self.spawn(command)
        try:
            status = process.wait(LIMIT)
        except subprocess.TimeoutExpired:
            status = 'none after %g s' % LIMIT
        finally:
            self.end(process)
        if status not in expect:
            raise Broken('%s: exit status %s\n%s' % (command[-1], status, self.written(path)))
        return self.written(path)

    def call(self, words):
        """The answer of a service, as `rosservice call` prints it."""
        if self.caller is None:
            self.caller = subprocess.Popen([sys.executable, '-c', CALLS], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                           universal_newlines=True, bufsize=1)
        path = os.path.join(self.folder, '.call_%d' % self.ran)
        self.caller.stdin.write(repr([path, *words]) + '\n')
        status = self.caller.stdout.readline().strip()
        if status != '0':
            raise Broken('%s: exit status %s\n%s' % (' '.join(words), status, self.written(path)))
        return self.written(path)

    def wait(self, condition, process, path, command):
        deadline = time.monotonic() + LIMIT
        pause = threading.Event()
        while not condition():
            if process.poll() is not None or time.monotonic() > deadline:
                text = self.written(path)
                self.end(process)
                raise Broken('%s: %s\n%s' % (command, 'ended' if process.returncode is not None else 'not there', text))
            pause.wait(0.02)

    def first_line(self, command):
        """Of what would never end: that it writes something."""
        process, path = self.spawn(['bash', '-c', command])
        try:
            words = {'echo': ':', 'hz': 'average rate', 'bw': 'average'}[ENDLESS.search(command).group(1).split()[0]]
            self.wait(lambda: words in self.written(path), process, path, command)
        finally:
            self.end(process)

    def start(self, name, command):
        process, path = self.spawn(['bash', '-c', 'exec ' + command])
        self.running[name] = process
        return process, path

    def go_on_with(self, text):
        """The page's program, by `text`."""
        if CONNECTS.search(text) or self.program is None:
            self.end_program()
            self.program = self.spawn([sys.executable, '-c', PROGRAM], stdin=subprocess.PIPE)
        process, path = self.program
        before = len(self.written(path))
        process.stdin.write((json.dumps(text) + '\n').encode())
        process.stdin.flush()
        self.wait(lambda: re.search('snippet ended with .*\n', self.written(path)[before:]), process, path, text)
        answer = self.written(path)[before:]
        if 'snippet ended with 0' not in answer:
            self.end_program()
            raise Broken(text + answer)

    def end_program(self):
        if self.program:
            self.program[0].stdin.close()
            self.end(self.program[0], first=signal.SIGTERM)
        self.program = None

    def start_beside(self, command):
        """Until the master knows one more node."""
        before = set(rosnode.get_node_names())
        process, path = self.start(command, command)
        self.wait(lambda: set(rosnode.get_node_names()) - before, process, path, command)

    def start_node(self, command, words):
        """Until it answers; the one of the same name is stopped first."""
        node = next((word.split(':=')[1] for word in words if re.match(r'(__)?name:=', word)), 'deformable_sim')
        if node in self.running:
            self.end(self.running.pop(node))
        if words[0] == 'roslaunch' and words[1] == 'deformable_sim':
            command = re.sub(r'(\.launch)', r'\1 rviz:=false', re.sub(r'rviz:=\w+', '', command), count=1)
        process, path = self.start(node, command)
        space = next((word.split(':=')[1] for word in words if word.startswith(('__ns:=', 'ns:='))), '')
        name = '/%s/describe' % '/'.join(part for part in (space.strip('/'), node) if part)

        def answers():
            try:
                return rosservice.get_service_uri(name) is not None and self.has_node(name)
            except Exception:  # the node is not there yet
                return False

        self.wait(answers, process, path, command)

    @staticmethod
    def has_node(service):
        return bool(rosservice.get_service_headers(service, rosservice.get_service_uri(service)))

    @staticmethod
    def end(process, first=signal.SIGINT):
        for number, patience in ((first, 15.0), (signal.SIGKILL, 5.0)):
            try:
                os.killpg(process.pid, number)
            except ProcessLookupError:
                break
            try:
                process.wait(patience)
            except subprocess.TimeoutExpired:
                continue

    def close(self):
        self.end_program()
        if self.caller:
            self.caller.stdin.close()
            self.caller.stdout.close()
            self.caller.wait(LIMIT)
            self.caller = None
        for process in self.running.values():
            try:
                os.killpg(process.pid, signal.SIGINT)
            except ProcessLookupError:
                pass
        for process in self.running.values():
            self.end(process)
        self.running.clear()
