"""Bodies by gmsh: a block, a dome, an organ (a dome bent and tapered), each with discs for pads cut into its skin.

A body is drawn once and meshed as often as wanted, each time anew: the bundle's mesh and the truth's share the shape and nothing else.
Lengths in mm; the base lies in z = 0.
"""
import math

import gmsh
import numpy as np

BASE, SKIN, FIRST_PAD, TISSUE = 2, 3, 4, 1  # physical groups, numbered as in the open recordings


class Mesh:
    """points (n, 3) mm; tets (m, 4), positive volumes; facets: {group: (k, 3)} outward, groups base, skin, A1, ..."""

    def __init__(self, points, tets, facets):
        self.points, self.tets, self.facets = points, tets, facets

    def volumes(self):
        a, b, c, d = (self.points[self.tets[:, k]] for k in range(4))
        return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0


class Body:
    """shape: block, dome or organ; size (3) mm: half widths in x and y, height; pads: [(center (3), normal (3), radius)] before the map."""

    def __init__(self, shape, size, bend=0.0, taper=0.0):
        self.shape, self.size, self.bend, self.taper, self.pads = shape, np.asarray(size, float), bend, taper, []

    def mapped(self, points):
        """The organ's smooth map of a dome (points (n, 3)): bent like a kidney, thick at one end and thin at the other like a liver."""
        points = np.array(points, float).reshape(-1, 3)
        if self.shape != "organ":
            return points
        a = self.size[0]
        s = points[:, 0] / a
        out = points.copy()
        out[:, 1] = points[:, 1] * (1.0 + 0.5 * self.taper * s) + self.bend * a * (s * s - 0.4)
        out[:, 2] = points[:, 2] * (1.0 + self.taper * s)
        return out

    def skin_point(self, u, v):
        """A place and outward normal of the skin before the map: u is the share of the way from the top to the base, v an angle."""
        a, b, h = self.size
        if self.shape == "block":
            r = u ** 0.5
            return np.array([a * r * math.cos(v), b * r * math.sin(v), h]), np.array([0.0, 0.0, 1.0])
        polar = u * math.pi / 2
        p = np.array([a * math.sin(polar) * math.cos(v), b * math.sin(polar) * math.sin(v), h * math.cos(polar)])
        n = p / self.size ** 2
        return p, n / np.linalg.norm(n)

    def depth(self, point):
        """How far inside a place is, before the map, mm: exact for blocks, good enough for domes."""
        a, b, h = self.size
        p = np.asarray(point, float)
        if self.shape == "block":
            return min(a - abs(p[0]), b - abs(p[1]), p[2], h - p[2])
        level = math.sqrt(np.sum((p / self.size) ** 2))
        return min(p[2], (1.0 - level) * min(a, b, h))


def _geometry(body, roll):
    """roll, rad: how the pads' cylinders are turned, whose seams make slivers where they end close to other points."""
    occ = gmsh.model.occ
    a, b, h = body.size
    if body.shape == "block":
        volume = occ.addBox(-a, -b, 0, 2 * a, 2 * b, h)
    else:
        ball = occ.addSphere(0, 0, 0, 1)
        # A seam of the ball that meets a pad's rim makes slivers.
        angles = sorted(math.atan2(c[1] / b, c[0] / a) % (2 * math.pi) for c, _, _ in body.pads)
        gaps = [((angles[(k + 1) % len(angles)] - v) % (2 * math.pi) or 2 * math.pi, v) for k, v in enumerate(angles)]
        occ.rotate([(3, ball)], 0, 0, 0, 0, 0, 1, max(gaps)[1] + max(gaps)[0] / 2)
        occ.dilate([(3, ball)], 0, 0, 0, a, b, h)
        half = occ.addBox(-2 * a, -2 * b, 0, 4 * a, 4 * b, 2 * h)
        (_, volume), = occ.intersect([(3, ball)], [(3, half)])[0]
    patches = []
    for center, normal, radius in body.pads:
        # What a cylinder across the skin cuts out of it.
        start = np.asarray(center) - 0.45 * h * np.asarray(normal)
        cylinder = occ.addCylinder(*start, *(0.9 * h * np.asarray(normal)), radius)
        occ.rotate([(3, cylinder)], *center, *normal, roll)
        occ.synchronize()
        own = [(2, abs(tag)) for _, tag in gmsh.model.getBoundary([(3, volume)], oriented=False)]
        copies = occ.copy(own)
        patch = occ.intersect(copies, [(3, cylinder)], removeObject=True, removeTool=True)[0]
        patches.append([t for d, t in patch if d == 2])
    occ.fragment([(3, volume)], [(2, t) for patch in patches for t in patch])
    occ.synchronize()


def _size_field(body, size, near_pads, lump):
    """size mm; near_pads: its share at the pads; lump: (center, radius, share) or None."""
    field = gmsh.model.mesh.field
    fields = []
    for center, _, radius in body.pads:
        ball = field.add("Ball")
        for key, value in zip(("XCenter", "YCenter", "ZCenter"), center):
            field.setNumber(ball, key, float(value))
        field.setNumber(ball, "Radius", 1.25 * radius)
        field.setNumber(ball, "Thickness", 2.0 * radius)
        field.setNumber(ball, "VIn", near_pads * size)
        field.setNumber(ball, "VOut", size)
        fields.append(ball)
    if lump is not None:
        center, radius, share = lump
        ball = field.add("Ball")
        for key, value in zip(("XCenter", "YCenter", "ZCenter"), center):
            field.setNumber(ball, key, float(value))
        field.setNumber(ball, "Radius", 1.15 * radius)
        field.setNumber(ball, "Thickness", radius)
        field.setNumber(ball, "VIn", share * size)
        field.setNumber(ball, "VOut", size)
        fields.append(ball)
    least = field.add("Min")
    field.setNumbers(least, "FieldsList", fields)
    field.setAsBackgroundMesh(least)
    for option in ("Mesh.MeshSizeExtendFromBoundary", "Mesh.MeshSizeFromPoints", "Mesh.MeshSizeFromCurvature"):
        gmsh.option.setNumber(option, 0)


def _group_of(body, centroid, normal):
    """The group of a facet by where it is before the map."""
    if abs(centroid[2]) < 1e-6 and normal[2] < -0.99:
        return "base"
    for k, (center, axis, radius) in enumerate(body.pads):
        away = centroid - center
        along = away @ axis
        if np.linalg.norm(away - along * axis) < radius and abs(along) < 0.45 * body.size[2] and normal @ axis > 0:
            return f"A{k + 1}"
    return "skin"


def _read(body):
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    kinds, _, nodes = gmsh.model.mesh.getElements(3)
    tets = np.asarray(nodes[list(kinds).index(4)], int).reshape(-1, 4)
    index = np.full(int(tags.max()) + 1, -1)
    used = np.unique(tets)
    index[used] = np.arange(len(used))
    place = np.zeros((int(tags.max()) + 1, 3))
    place[np.asarray(tags, int)] = np.asarray(coordinates).reshape(-1, 3)
    points, tets = place[used], index[tets]
    flat = Mesh(points, tets, {})
    wrong = flat.volumes() < 0
    tets[wrong] = tets[wrong][:, [0, 1, 3, 2]]
    faces = np.concatenate([tets[:, [1, 2, 3]], tets[:, [0, 3, 2]], tets[:, [0, 1, 3]], tets[:, [0, 2, 1]]])
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    faces = faces[first[count == 1]]
    groups = {name: [] for name in ["base", "skin"] + [f"A{k + 1}" for k in range(len(body.pads))]}
    for face in faces:
        p = points[face]
        normal = np.cross(p[1] - p[0], p[2] - p[0])
        groups[_group_of(body, p.mean(0), normal / np.linalg.norm(normal))].append(face)
    mesh = Mesh(body.mapped(points), tets, {k: np.array(v, int).reshape(-1, 3) for k, v in groups.items()})
    if mesh.volumes().min() <= 0:
        raise ValueError("an element is inside out")
    if any(len(v) < 4 for v in mesh.facets.values()):
        raise ValueError("a pad has too few facets")
    return mesh


def quality(mesh):
    """(tets) 1 for a regular tetrahedron, 0 for a flat one."""
    corners = mesh.points[mesh.tets]
    squares = np.mean([((corners[:, i] - corners[:, j]) ** 2).sum(1) for i in range(4) for j in range(i)], axis=0)
    return mesh.volumes() * 6.0 * math.sqrt(2.0) / squares ** 1.5


def _generated(body, size, near_pads, lump, roll, seed):
    gmsh.initialize()
    try:
        for option, value in (("General.Terminal", 0), ("General.NumThreads", 1), ("Mesh.RandomSeed", seed), ("Mesh.OptimizeThreshold", 0.5)):
            gmsh.option.setNumber(option, value)
        gmsh.model.add("body")
        _geometry(body, roll)
        _size_field(body, size, near_pads, lump)
        gmsh.model.mesh.generate(3)
        for method in ("", "Relocate3D", ""):
            gmsh.model.mesh.optimize(method, force=True)
        return _read(body)
    finally:
        gmsh.finalize()


def mesh_of(body, wanted, near_pads=1.0, lump=None, seed=1):
    """A mesh of about `wanted` tetrahedra, smaller by the share `near_pads` at the pads and by lump's in a ball (see _size_field).

    ValueError where no mesh without slivers comes out.
    """
    a, b, h = body.size
    volume = 4 * a * b * h if body.shape == "block" else 2.0 / 3.0 * math.pi * a * b * h
    size = (volume / wanted * 8.5) ** (1.0 / 3.0) * near_pads ** -0.3
    trouble = "no attempt"
    for attempt in range(8):
        try:
            mesh = _generated(body, size, near_pads, lump, 0.7 * attempt + 0.3 * seed, seed)
        except Exception as error:  # gmsh raises plain Exceptions; another roll may do
            trouble = str(error)
            continue
        count, worst = len(mesh.tets), quality(mesh).min()
        if 0.85 < count / wanted < 1.15 and worst > 0.2:
            return mesh
        trouble = f"{count} tetrahedra for {wanted}, quality {worst:.2f}"
        if not 0.85 < count / wanted < 1.15:
            size *= (count / wanted) ** (1.0 / 3.0)
    raise ValueError(trouble)


def write_gmsh(mesh, path):
    """Gmsh 2.2 ASCII, groups as in the open recordings."""
    names = ["base", "skin"] + sorted(k for k in mesh.facets if k not in ("base", "skin"))
    with open(path, "w") as out:
        out.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n%d\n" % (len(names) + 1))
        for k, name in enumerate(names):
            out.write('2 %d "%s"\n' % (BASE + k, name))
        out.write('3 %d "tissue"\n$EndPhysicalNames\n$Nodes\n%d\n' % (TISSUE, len(mesh.points)))
        for k, p in enumerate(mesh.points):
            out.write("%d %.12g %.12g %.12g\n" % (k + 1, *p))
        out.write("$EndNodes\n$Elements\n%d\n" % (sum(len(f) for f in mesh.facets.values()) + len(mesh.tets)))
        number = 0
        for k, name in enumerate(names):
            for face in mesh.facets[name]:
                number += 1
                out.write("%d 2 2 %d %d %d %d %d\n" % (number, BASE + k, BASE + k, *(face + 1)))
        for tet in mesh.tets:
            number += 1
            out.write("%d 4 2 %d 1 %d %d %d %d\n" % (number, TISSUE, *(tet + 1)))
        out.write("$EndElements\n")
