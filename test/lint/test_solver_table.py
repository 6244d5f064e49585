"""The table that `solver: auto` chooses from: what of a study goes into it, and what never does."""
import importlib.util
import os
import sys
import unittest

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SPEC = importlib.util.spec_from_file_location('solver_table', os.path.join(ROOT, 'scripts/solver_table.py'))
solver_table = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(solver_table)

FRAME = 1.0 / 60.0


def run(integrator, error, cpu, dt=FRAME, solver='', newton=0, status='done', strain=0.02):
    return {'integrator': integrator, 'linear_solver': solver, 'newton_iterations': newton, 'linear_tolerance': 0.1,
            'linear_iterations': 50 if solver == 'multigrid' else 0, 'precision': 'double', 'fraction_of_limit': 0.95,
            'dt_s': dt, 'status': status, 'position_error': error, 'strain_error': strain, 'cpu_per_second': cpu}


def study(name, bodies, runs, resolution=1e-6):
    return {'name': name, 'runs': runs, 'reference': {'resolution': resolution},
            'features': {'bodies': bodies, 'nodes': 100, 'explicit_steps_per_frame': 12.5, 'contact': False,
                         'strain_limits': True}}


def runs_of(text):
    """(configuration, error, cpu) of every line of runs."""
    numbers = [line.strip()[3:-1].split(', ') for line in text.splitlines() if line.startswith('      - [')]
    return [(int(a), float(b), float(c)) for a, b, c in numbers]


class SolverTable(unittest.TestCase):
    def test_holds_runs_near_the_front_and_names_what_diverged_elsewhere(self):
        cheap, dear = run('bdf2', 0.02, 0.1, solver='multigrid', newton=1), run('bdf2', 0.02, 0.25, solver='direct', newton=1)
        text = solver_table.text_of([
            study('one', 'sheet', [cheap, dear, run('substepped_verlet', 1e-9, 0.3)]),
            study('two', 'sheet', [run('bdf2', None, None, solver='multigrid', newton=1, status='diverged'),
                                   run('substepped_verlet', 1e-4, 0.4)])])
        self.assertEqual(text.count('integrator: bdf2'), 1, 'the one 2.5 times dearer at the same error is left out')
        self.assertIn('linear_tolerance: 0.1, linear_iterations: 50', text)
        self.assertEqual(runs_of(text), [(0, 0.02, 0.1), (1, 1e-6, 0.3), (1, 1e-4, 0.4)])
        self.assertIn('failed: [0]', text.split('name: two')[1])
        self.assertIn('strain_limits: true', text)

    def test_offers_no_unsafe_scheme_no_long_step_and_few_iterations_to_no_rope(self):
        good = run('bdf2', 0.02, 1.0, solver='banded', newton=20)
        bad = [run('implicit_midpoint', 0.001, 0.1, solver='banded', newton=20), run('rk4', 0.001, 0.1),
               run('bdf2', 0.001, 0.1, dt=1.0 / 32.0, solver='banded', newton=20),
               run('bdf2', 0.001, 0.1, solver='banded', newton=2), run('bdf2', 0.001, 0.1, solver='banded', newton=1000),
               run('bdf2', 0.001, 0.1, dt=0.007, solver='banded', newton=20)]
        self.assertEqual(runs_of(solver_table.text_of([study('rope', 'rope', [good] + bad)])), [(0, 0.02, 1.0)])

    def test_offers_dual_schemes_only_where_nothing_is_stretched_falsely(self):
        text = solver_table.text_of([study('one', 'sheet', [
            run('line_dual', 0.01, 0.1, solver='lines', newton=1), run('bdf2', 0.01, 0.3, solver='multigrid', newton=1),
            run('line_dual', 0.01, 0.2, solver='lines', newton=2, strain=0.009)])])
        self.assertEqual(sorted(cpu for _, _, cpu in runs_of(text)), [0.2, 0.3])
        self.assertIn('newton_iterations: 2', text)

    def test_knows_the_cheapest_of_all_even_where_it_is_not_offered(self):
        text = solver_table.text_of([study('rope', 'rope', [
            run('bdf2', 0.02, 1.0, solver='banded', newton=20), run('rk4', 0.001, 0.5, dt=0.001),
            run('bdf2', 0.001, 0.1, dt=1.0 / 32.0, solver='banded', newton=20)])])
        self.assertIn('cheapest: [[0.03, 0.5], [0.02, 0.5], [0.01, 0.5], [0.003, 0.5], [0.001, 0.5]]', text)

    def test_leaves_out_scenes_without_a_reference_and_without_bodies(self):
        some = [run('substepped_verlet', 0.001, 0.4)]
        text = solver_table.text_of([study('blind', 'sheet', some, resolution=None), study('golden', '', some)])
        self.assertEqual(runs_of(text), [])


if __name__ == '__main__':
    unittest.main()
