"""Makes config/solvers.yaml, which `solver: auto` chooses from, of the results of `study work_precision`."""
import glob
import json
import os

NEAR = 2.0             # a run is kept unless another was so many times cheaper at no larger error
LARGEST = 0.1          # error worth choosing
WANTED = [0.03, 0.02, 0.01, 0.003, 0.001]
SLOWEST, FASTEST = 60, 3840  # steps a second: a display and a controller ask for 60 at least
UNSAFE = ('implicit_midpoint',)  # not L-stable: blows up in other scenes where all the rest does not
DUAL = ('line_dual', 'xpbd', 'projective_dynamics')  # may stretch or freeze what they put in the right place on the whole:
MOST_STRAIN = 0.01     # offered where no edge's strain is off by more
OWN_STEP = ('explicit_euler', 'symplectic_euler', 'velocity_verlet', 'rk4')  # their steps follow the scene
AMPLE = 4              # Newton iterations; less leaves stiff ropes frozen or torn
CONVERGED = 1000       # Newton iterations that stand for a yardstick, not for a way to run a scene

HEAD = """\
# Errors and costs of solvers, measured. Written by `./run study work_precision --suite --store`; not meant to be edited.
# `solver: auto` takes from here the cheapest configuration for a scene (doc/work_precision.md).
# runs: [configuration, error, CPU s per simulated s]: RMS of the positions over a second, relative to the body's size.
# failed: configurations that diverged, or were off by too much. cheapest: [error, CPU s per simulated s] of all that was run
# with at least 60 steps a second, but for what is never chosen: implicit_midpoint, and ropes with few Newton iterations.
"""


def on_ladder(dt):
    rate = SLOWEST
    while rate <= FASTEST:
        if abs(dt * rate - 1.0) < 1e-6:
            return True
        rate *= 2
    return False


def step_of(run):
    """A scheme that divides its steps costs and errs the same in shorter ones."""
    return min(run['dt_s'], 1.0 / SLOWEST) if run['integrator'] == 'substepped_verlet' else run['dt_s']


def is_rope_left_short(run, bodies):
    """Of a rope, the tolerance has to end Newton's iterations, not their number."""
    return bodies in ('rope', 'rod') and 0 < run['newton_iterations'] < AMPLE


def configuration_of(run):
    keys = ['integrator: %s' % run['integrator']]
    if run['linear_solver']:
        keys += ['linear_solver: %s' % run['linear_solver'], 'newton_iterations: %d' % run['newton_iterations']]
        if run['linear_iterations']:
            keys += ['linear_tolerance: %g' % run['linear_tolerance'], 'linear_iterations: %d' % run['linear_iterations']]
    if run['precision'] != 'double':
        keys.append('precision: %s' % run['precision'])
    if run['fraction_of_limit'] != 0.95:
        keys.append('fraction_of_limit: %g' % run['fraction_of_limit'])
    return '{%s, dt: %.9g}' % (', '.join(keys), step_of(run))


def is_known(run):
    if run['status'] != 'done' or run['position_error'] is None or run['cpu_per_second'] is None:
        return False
    return run['integrator'] not in DUAL or (run['strain_error'] is not None and run['strain_error'] <= MOST_STRAIN)


def is_offered(run, bodies):
    """May a scene be run so?"""
    return (on_ladder(step_of(run)) and run['integrator'] not in OWN_STEP + UNSAFE
            and not is_rope_left_short(run, bodies) and run['newton_iterations'] != CONVERGED)


class Scene:
    def __init__(self, study):
        self.study = study
        self.resolution = study['reference']['resolution'] or 1.0
        self.known = [run for run in study['runs'] if is_known(run)]
        self.offered = [run for run in self.known if is_offered(run, study['features']['bodies']) and self.error(run) <= LARGEST]

    def error(self, run):
        """What can be told of it: not less than the reference resolves."""
        return max(run['position_error'], self.resolution)

    def near_front(self):
        def is_beaten(run):
            return any(NEAR * other['cpu_per_second'] < run['cpu_per_second'] and self.error(other) <= self.error(run)
                       for other in self.offered)
        return [run for run in self.offered if not is_beaten(run)]

    def cheapest(self):
        found = []
        for wanted in WANTED:
            costs = [run['cpu_per_second'] for run in self.known
                     if self.error(run) <= wanted and run['newton_iterations'] != CONVERGED
                     and run['integrator'] not in UNSAFE
                     and not is_rope_left_short(run, self.study['features']['bodies'])
                     and run['dt_s'] * SLOWEST < 1.0 + 1e-6]
            if costs:
                found.append((wanted, min(costs)))
        return found


def scene_lines(scene, number_of):
    features = scene.study['features']
    numbers = {}
    for run in sorted(scene.offered, key=lambda run: -run['dt_s']):
        key = configuration_of(run)
        if key in number_of:
            numbers[number_of[key]] = (scene.error(run), run['cpu_per_second'])
    failed = sorted({number_of[configuration_of(run)] for run in scene.study['runs']
                     if run['status'] != 'stopped' and configuration_of(run) in number_of} - set(numbers))
    lines = ['  - name: %s' % scene.study['name'],
             '    bodies: %s' % features['bodies'],
             '    nodes: %d' % features['nodes'],
             '    explicit_steps: %.4g' % features['explicit_steps_per_frame'],
             '    contact: %s' % str(features['contact']).lower(),
             '    strain_limits: %s' % str(features['strain_limits']).lower(),
             '    cheapest: [%s]' % ', '.join('[%g, %.4g]' % pair for pair in scene.cheapest()),
             '    failed: [%s]' % ', '.join(str(k) for k in failed),
             '    runs:']
    return lines + ['      - [%d, %.3g, %.3g]' % (k, error, cpu) for k, (error, cpu) in sorted(numbers.items())]


def text_of(studies):
    scenes = [Scene(study) for study in studies if study['features']['bodies']]
    scenes = [scene for scene in scenes if scene.offered]
    keys = sorted({configuration_of(run) for scene in scenes for run in scene.near_front()})
    number_of = {key: k for k, key in enumerate(keys)}
    lines = ['configurations:'] + ['  - %s' % key for key in keys] + ['scenes:']
    for scene in scenes:
        lines += scene_lines(scene, number_of)
    return HEAD + '\n'.join(lines) + '\n'


def store(folder, path):
    """FOLDER/*.json of the study to PATH."""
    studies = []
    for name in sorted(glob.glob(os.path.join(folder, '*.json'))):
        if not name.endswith('.summary.json'):
            with open(name, encoding='utf-8') as stream:
                studies.append(json.load(stream))
    with open(path, 'w', encoding='utf-8') as stream:
        stream.write(text_of(studies))
