"""What a soak has to hold, and by how much."""
import math
from collections import namedtuple

from soak_books import slope

Verdict = namedtuple('Verdict', 'what measured bound ok')

WARM_UP = 0.2          # of the run ...
SETTLED = 60.0         # s (wall): ... and at least this: caches, allocator arenas, the first of every kind of request
CREEP = 1.0            # MiB over the rest of the run, by the straight line through all samples, steps taken out
STEP = 0.25            # MiB in a second: contact keeps the room that the most tangled step so far needed, which doubles
GROWTH = 16.0          # MiB in all, steps and settling included
DESCRIPTORS = 4        # more than at the beginning, once all listeners are gone: tf, and XML-RPC with a new master
MASS = 1e-9            # relative
TOLERANCE = 0.02       # m/s^2: the scene's step.tolerance, RMS of what a step may leave unbalanced
WON = 1e-3             # of the kinetic energy, in a flight
CREATED = 0.02         # of what it takes to lift the towel by LIFT, a round
LIFT = 0.5             # m, as the robot does
# A hand of 1 m/s adds 0.02 m to an edge of 0.04 m in a step, before which the hold of 1 N had stretched it, of 10.4 N, by 0.1.
STRAIN = 0.6
LENGTH = 1e-6          # m, of edges and height of the towel at rest, at the end against the beginning
SPEED = 1e-3           # m/s, at rest
REGISTRATION = 10.0    # s (wall): two looks for a master, and what a busy machine takes
LOST = 5.0             # s (wall), likewise
WEIGHT = TOLERANCE / 9.81


def memory(samples):
    """MiB by which it crept up once it had settled, over how many simulated hours, and by which it grew in all."""
    if not samples:
        return 0.0, 0.0, 0.0
    begin, end = samples[0]['wall_s'], samples[-1]['wall_s']
    warm = [s for s in samples if s['wall_s'] >= begin + max(SETTLED, WARM_UP * (end - begin))]
    if end - begin < 2.0 * SETTLED:
        warm = warm[:0]
    sizes, stepped = [], 0.0
    for before, after in zip(warm, warm[1:]):
        grown = after['memory_MiB'] - before['memory_MiB']
        stepped += grown if abs(grown) >= STEP else 0.0
        sizes.append(after['memory_MiB'] - stepped)
    times = [s['wall_s'] for s in warm[1:]]
    hours = (warm[-1]['simulated_s'] - warm[0]['simulated_s']) / 3600.0 if warm else 0.0
    creep = slope(times, sizes) * (times[-1] - times[0]) if times else 0.0
    return creep, hours, max(s['memory_MiB'] for s in samples) - samples[0]['memory_MiB']


def difference(first, last):
    return max(abs(a - b) for a, b in zip(first, last))


def rest_verdicts(rests, mass):
    if len(rests) < 2:
        return [Verdict('towel at rest', 'not seen twice', 'at the beginning and at the end', False)]
    first, last = rests
    found = [('edges at rest, drift', difference(first['lengths'], last['lengths']), LENGTH, 'm'),
             ('height at rest, drift', abs(last['height'] - first['height']), LENGTH, 'm'),
             ('area at rest, drift', abs(last['area'] / first['area'] - 1.0), LENGTH, ''),
             ('speed at rest', max(r['speed'] for r in rests), SPEED, 'm/s'),
             ('carried by the table - weight', max(abs(r['carried'] / (9.81 * mass) - 1.0) for r in rests), WEIGHT, ''),
             ('crossings at rest', max(r['crossings'] for r in rests), 0, '')]
    return [bounded(*row) for row in found]


def bounded(what, value, bound, unit):
    return Verdict(what, '%.3g %s' % (value, unit), '<= %g %s' % (bound, unit), math.isfinite(value) and value <= bound)


def verdicts(found, samples):
    creep, hours, growth = memory(samples)
    rows = [bounded('memory, creep in %.2f h' % hours, creep, CREEP, 'MiB'), bounded('memory, growth in all', growth, GROWTH, 'MiB')]
    if len(found['quiet']) == 2:
        rows.append(bounded('descriptors, more at the end', found['quiet'][1][1] - found['quiet'][0][1], DESCRIPTORS, ''))
    numbers = [v for sample in samples for v in sample.values()]
    rows.append(bounded('numbers not finite', sum(not math.isfinite(v) for v in numbers), 0, ''))
    rows.append(bounded('stops on a last good state', found['stops'], 0, ''))
    rows.append(bounded('resets not to the bits of the first', sum(found['unlike']), 0, 'of %d' % len(found['unlike'])))
    rows.append(bounded('mass, deviation', max((abs(m / found['mass'] - 1.0) for m in found['masses']), default=math.nan), MASS, ''))
    flights = found['flights']
    rows.append(bounded('momentum in %d flights, left open' % len(flights), max((f[0] for f in flights), default=0.0), TOLERANCE,
                        'm/s^2'))
    rows.append(bounded('energy won in flight', max((f[1] for f in flights), default=0.0), WON, 'of kinetic'))
    rows.append(bounded('energy created', found['created'] / (max(1, found['rounds']) * found['mass'] * 9.81 * LIFT), CREATED, 'of a lift'))
    rows.append(bounded('strain, largest', found['strain'], STRAIN, ''))
    rows.append(bounded('crossings in %d looks' % len(found['crossings']), sum(found['crossings']), 0, ''))
    rows += rest_verdicts(found['rests'], found['mass'])
    rows.append(Verdict('rounds of the robot', str(found['rounds']), '>= 1', found['rounds'] >= 1))
    rows.append(bounded('known again to a new master after', found['slowest_registration'], REGISTRATION, 's'))
    rows.append(bounded('hand not seen though tf tells it', found['lost'], LOST, 's'))
    rows.append(Verdict('disturbances not made', ', '.join(found['missed']) or 'none', 'none', not found['missed']))
    rows.append(Verdict('robot', ', '.join(found['robot_errors']) or 'nothing', 'nothing', not found['robot_errors']))
    return rows


def table(rows):
    width = [max(len(row[i]) for row in rows) for i in range(3)]
    lines = ['%-*s  %-*s  %-*s  %s' % (width[0], r.what, width[1], r.measured, width[2], r.bound, 'ok' if r.ok else 'FAILED') for r in rows]
    return '\n'.join(lines)
