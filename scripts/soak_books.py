"""What can be reckoned from outside about a sheet: its books of mass, momentum and energy, its edges, whether it crosses itself."""
import math

FLAT = 1e-12  # m^3: a nanometre over a triangle of a few centimetres


def sub(a, b):
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def norm(a):
    return math.sqrt(dot(a, a))


def points(numbers):
    return list(zip(numbers[0::3], numbers[1::3], numbers[2::3]))


class Sheet:
    """A grid of `cells` by `cells` with `mesh`, a shape_msgs/Mesh, at rest; mass density in kg/m^2."""

    def __init__(self, mesh, cells, density):
        self.rest = [(p.x, p.y, p.z) for p in mesh.vertices]
        self.triangles = [tuple(t.vertex_indices) for t in mesh.triangles]
        self.edges = sorted({tuple(sorted((t[i], t[i - 1]))) for t in self.triangles for i in range(3)})
        self.mass = self.masses(cells, density)
        self.neighbours = [set() for _ in self.rest]
        for a, b in self.edges:
            self.neighbours[a].add(b)
            self.neighbours[b].add(a)

    def masses(self, cells, density):
        """A quarter of every cell around a node."""
        area = sum(0.5 * norm(cross(sub(self.rest[b], self.rest[a]), sub(self.rest[c], self.rest[a])))
                   for a, b, c in self.triangles)
        ends = (0, cells)
        row = [0.5 if i in ends else 1.0 for i in range(cells + 1)]
        return [density * area / cells ** 2 * x * y for y in row for x in row]

    def momentum(self, state):
        return [sum(m * v for m, v in zip(self.mass, state.velocities[axis::3])) for axis in range(3)]

    def total_mass(self, state, gravity=9.81):
        """kg, from the potential energy that the node tells, and the height of the centre of mass."""
        height = sum(m * z for m, z in zip(self.mass, state.positions[2::3])) / sum(self.mass)
        return state.potential_energy / (gravity * height)

    def fastest(self, state):
        return max(norm(v) for v in points(state.velocities))

    def lengths(self, state):
        """m, of all edges of the mesh."""
        p = points(state.positions)
        return [norm(sub(p[a], p[b])) for a, b in self.edges]

    def area(self, state):
        p = points(state.positions)
        return sum(0.5 * norm(cross(sub(p[b], p[a]), sub(p[c], p[a]))) for a, b, c in self.triangles)

    def crossings(self, state):
        """Pairs of an edge and a triangle without a common node that intersect."""
        p = points(state.positions)
        boxes = [tuple(sorted(p[n][axis] for n in t)[::2] for axis in range(3)) for t in self.triangles]
        found = []
        for a, b in self.edges:
            box = [(min(p[a][i], p[b][i]), max(p[a][i], p[b][i])) for i in range(3)]
            for t, other in zip(self.triangles, boxes):
                if a in t or b in t or any(o[0] > m[1] or o[1] < m[0] for o, m in zip(other, box)):
                    continue
                if intersect(p[a], p[b], *(p[n] for n in t)):
                    found.append(((a, b), t))
        return found


def intersect(a, b, p, q, r):
    """Whether the segment a b passes through the triangle p q r; not when an end lies in its plane."""
    def volume(u, v, w, x):
        return dot(cross(sub(v, u), sub(w, u)), sub(x, u))
    below, above = sorted((volume(p, q, r, a), volume(p, q, r, b)))
    if below > -FLAT or above < FLAT:
        return False
    sides = [volume(a, b, *corners) > 0.0 for corners in ((p, q), (q, r), (r, p))]
    return sides[0] == sides[1] == sides[2]


def slope(times, values):
    """Of the straight line nearest to the points."""
    n = len(times)
    if n < 2:
        return 0.0
    mean_t, mean_v = sum(times) / n, sum(values) / n
    below = sum((t - mean_t) ** 2 for t in times)
    return sum((t - mean_t) * (v - mean_v) for t, v in zip(times, values)) / below if below else 0.0
