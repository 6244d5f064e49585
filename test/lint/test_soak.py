"""What ./run study soak reckons and judges: a leak, a drift, a crossing and a gain are seen."""
import os
import sys
import types
import unittest

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, 'scripts'))
import soak_books  # noqa: E402
import soak_judge  # noqa: E402


def named(**fields):
    return types.SimpleNamespace(**fields)


def grid(cells, edge):
    """A flat sheet as the node tells its mesh."""
    across = cells + 1
    vertices = [named(x=edge * i, y=edge * j, z=0.0) for j in range(across) for i in range(across)]
    triangles = []
    for j in range(cells):
        for i in range(cells):
            a = j * across + i
            triangles += [named(vertex_indices=(a, a + 1, a + across)), named(vertex_indices=(a + 1, a + across + 1, a + across))]
    return named(vertices=vertices, triangles=triangles)


def state(positions, velocity=(0.0, 0.0, 0.0), energy=0.0):
    return named(positions=[c for p in positions for c in p], velocities=list(velocity) * len(positions), potential_energy=energy)


class Books(unittest.TestCase):
    def setUp(self):
        self.sheet = soak_books.Sheet(grid(4, 0.1), 4, 0.5)

    def test_mass_is_density_times_area_and_momentum_mass_times_velocity(self):
        self.assertAlmostEqual(sum(self.sheet.mass), 0.5 * 0.4 ** 2, delta=1e-15)
        self.assertAlmostEqual(self.sheet.momentum(state(self.sheet.rest, (0.0, 2.0, -1.0)))[1], 0.16, delta=1e-15)

    def test_mass_is_read_from_the_potential_energy(self):
        raised = [(x, y, 2.0) for x, y, _ in self.sheet.rest]
        self.assertAlmostEqual(self.sheet.total_mass(state(raised, energy=0.08 * 9.81 * 2.0)), 0.08, delta=1e-15)

    def test_a_sheet_drawn_through_itself_crosses_and_a_folded_one_does_not(self):
        folded = [(x, y, 0.0) if x <= 0.2 else (0.4 - x, y, 0.003) for x, y, _ in self.sheet.rest]
        self.assertEqual(self.sheet.crossings(state(folded)), [])
        through = [(0.05, 0.04, 0.01)] + folded[1:]
        self.assertGreater(len(self.sheet.crossings(state(through))), 0)

    def test_lengths_and_area_are_those_of_the_grid(self):
        flat = state(self.sheet.rest)
        self.assertAlmostEqual(self.sheet.area(flat), 0.16, delta=1e-15)
        self.assertAlmostEqual(min(self.sheet.lengths(flat)), 0.1, delta=1e-15)
        self.assertEqual(len(self.sheet.lengths(flat)), 2 * 4 * 5 + 16)


def sample(second, memory, strain=0.0):
    return {'wall_s': float(second), 'simulated_s': 50.0 * second, 'memory_MiB': memory, 'max_strain': strain}


def findings(**changes):
    rest = {'height': 0.75, 'speed': 0.0, 'carried': 9.81, 'area': 0.1, 'lengths': [0.1, 0.2], 'mass': 1.0, 'crossings': 0}
    found = {'rests': [rest, dict(rest)], 'masses': [1.0], 'mass': 1.0, 'crossings': [0], 'unlike': [False], 'stops': 0,
             'flights': [(1e-3, -0.1)], 'created': 0.0, 'strain': 0.1, 'quiet': [(40.0, 15), (41.0, 17)], 'rounds': 10,
             'slowest_registration': 1.0, 'lost': 0.1, 'missed': [], 'robot_errors': []}
    found.update(changes)
    return found


class Judge(unittest.TestCase):
    steady = [sample(s, 40.0 + (s % 3) * 0.1) for s in range(600)]

    def failed(self, found, samples=None):
        return [v.what for v in soak_judge.verdicts(found, samples or self.steady) if not v.ok]

    def test_a_run_that_holds_everything_passes(self):
        self.assertEqual(self.failed(findings()), [])

    def test_each_thing_that_goes_wrong_fails_alone(self):
        rest = findings()['rests'][0]
        for change, word in (({'masses': [1.0, 1.0 + 1e-8]}, 'mass'), ({'crossings': [0, 2]}, 'crossings in'),
                             ({'unlike': [False, True]}, 'resets'), ({'stops': 1}, 'stops'), ({'flights': [(0.1, -0.1)]}, 'momentum'),
                             ({'flights': [(0.0, 0.1)]}, 'energy won'), ({'created': 2.0}, 'energy created'),
                             ({'strain': 0.7}, 'strain'), ({'quiet': [(40.0, 15), (40.0, 25)]}, 'descriptors'),
                             ({'rounds': 0}, 'rounds'), ({'slowest_registration': 30.0}, 'known again'), ({'lost': 60.0}, 'hand'),
                             ({'missed': ['reset']}, 'disturbances'), ({'robot_errors': ['robot: KeyError']}, 'robot'),
                             ({'rests': [rest, dict(rest, lengths=[0.1, 0.2001])]}, 'edges'),
                             ({'rests': [rest, dict(rest, height=0.751)]}, 'height'),
                             ({'rests': [rest, dict(rest, area=0.1001)]}, 'area'), ({'rests': [rest, dict(rest, speed=0.1)]}, 'speed'),
                             ({'rests': [rest, dict(rest, carried=9.0)]}, 'carried'), ({'rests': [rest]}, 'towel')):
            with self.subTest(change=change):
                failed = self.failed(findings(**change))
                self.assertEqual(len(failed), 1, failed)
                self.assertIn(word, failed[0])

    def test_a_leak_fails_and_a_rise_while_it_settles_does_not(self):
        leaking = [sample(s, 40.0 + 0.005 * s) for s in range(600)]
        self.assertEqual(['memory, creep in 6.65 h'], self.failed(findings(), leaking))
        settling = [sample(s, 40.0 + min(5.0, 0.1 * s) + (2.0 if s > 300 else 0.0)) for s in range(600)]
        self.assertEqual(self.failed(findings(), settling), [])
        piling = [sample(s, 40.0 + 2.0 * (s // 60)) for s in range(600)]
        self.assertEqual(['memory, growth in all'], self.failed(findings(), piling))

    def test_a_number_that_is_not_finite_fails(self):
        self.assertIn('not finite', self.failed(findings(), self.steady + [sample(600, 40.0, float('nan'))])[0])

    def test_the_table_says_which_failed(self):
        self.assertIn('FAILED', soak_judge.table(soak_judge.verdicts(findings(stops=1), self.steady)))


if __name__ == '__main__':
    unittest.main()
