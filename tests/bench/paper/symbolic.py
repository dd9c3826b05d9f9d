"""The symbolic treatment of Lagrange's equations: symbolic.py SCENE.toml NAME CC FOLDER

Reads a scene, derives its equations of motion with sympy, writes them as C (FOLDER/NAME.c), compiles that
with CC (FOLDER/NAME.o), and writes what both took of processor time (s, the first with Python's start) to FOLDER/NAME.seconds. The C function

    void NAME(const double *q, const double *u, double *A, double *f, double *L, double *E, double *h)

gives A (n x n, by rows) and f of A a = f + L^T lambda, and for rows h(q) = 0 of constraints L (rows x n), E
of L a + E = 0, and h. SI units.

For trees of hinges and slides with given inertias or boxes, weight, and points held in planes of the world;
all else is refused.
"""
import resource
import subprocess
import sys
import tomllib

import sympy as sp

AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}


def refuse(what):
    sys.exit(f"symbolic.py: {what} is not among what it knows")


def number(x):
    return sp.Float(repr(float(x)), 17) if x != int(x) else sp.Integer(int(x))


def vector(v):
    return sp.Matrix([number(x) for x in (AXES[v] if isinstance(v, str) else v)])


def turn(axis, angle):
    """The rotation about a unit axis (Rodrigues)."""
    x, y, z = axis
    K = sp.Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return sp.eye(3) + sp.sin(angle) * K + (1 - sp.cos(angle)) * K * K


def inertia(solid):
    """Mass, gravity centre, and tensor about the centre."""
    if "mass" in solid:
        return (number(solid["mass"]), vector(solid.get("centre", [0, 0, 0])),
                sp.diag(*[number(x) for x in solid.get("tensor", [0, 0, 0])]))
    shape = solid.get("shape", {})
    if shape.get("kind") != "box" or "mass" not in shape or "position" in shape:
        refuse(f"the inertia of '{solid['name']}'")
    m, (a, b, c) = number(shape["mass"]), [number(x) for x in shape["size"]]
    return m, sp.zeros(3, 1), m / 12 * sp.diag(b * b + c * c, a * a + c * c, a * a + b * b)


def equations(scene):
    if scene.get("effort"):
        refuse("an effort")
    gravity = vector(scene.get("gravity", [0, 0, -9.81]))
    q, u = [], []
    frames = {"world": (sp.eye(3), sp.zeros(3, 1), sp.zeros(3, 1))}  # R_WS, p_WS, angular velocity in S
    kinetic, potential = 0, 0
    for solid in scene["solid"]:
        R, p, w = frames[solid["parent"]]
        joint = solid.get("joint", [])
        for switch in joint if isinstance(joint, list) else [joint]:
            if set(switch) == {"fixed"}:
                p = p + R * vector(switch["fixed"])
                continue
            if not set(switch) <= {"rotation", "translation", "name", "value", "value_deg", "velocity"}:
                refuse(f"the joint of '{solid['name']}'")
            q.append(sp.Symbol(f"q[{len(q)}]", real=True))
            u.append(sp.Symbol(f"u[{len(u)}]", real=True))
            if "translation" in switch:
                p = p + R * vector(switch["translation"]) * q[-1]
            else:
                axis = vector(switch["rotation"])
                T = turn(axis, q[-1])
                R, w = R * T, T.T * w + axis * u[-1]
        frames[solid["name"]] = (R, p, w)
        m, centre, tensor = inertia(solid)
        at = p + R * centre
        v = at.jacobian(q) * sp.Matrix(u)
        kinetic += m * v.dot(v) / 2 + (w.T * tensor * w)[0] / 2
        potential -= m * gravity.dot(at)
    rows = []
    for constraint in scene.get("constraint", []):
        if constraint["kind"] != "point_on_plane" or constraint["plane"] != "world" or "offset" in constraint:
            refuse(f"the constraint '{constraint['name']}'")
        R, p, _ = frames[constraint["point"]["solid"]]
        rows.append(vector(constraint["normal"]).dot(p + R * vector(constraint["point"]["point"])))
    U = sp.Matrix(u)
    momenta = sp.Matrix([kinetic]).jacobian(u).T
    A = momenta.jacobian(u)
    # d/dt dK/du - dK/dq + dV/dq without the accelerations
    f = -(momenta.jacobian(q) * U - sp.Matrix([kinetic - potential]).jacobian(q).T)
    A, f = A.applyfunc(sp.trigsimp), f.applyfunc(sp.expand).applyfunc(sp.trigsimp)
    h = sp.Matrix(rows) if rows else sp.zeros(0, 1)
    L = h.jacobian(q) if rows else sp.zeros(0, len(q))
    E = (L * U).jacobian(q) * U if rows else sp.zeros(0, 1)
    return {"A": A, "f": f, "L": L, "E": E, "h": h}


def c_text(name, terms):
    targets = [(f"{key}[{i}]", e) for key, matrix in terms.items() for i, e in enumerate(matrix)]
    shared, results = sp.cse([e for _, e in targets], symbols=sp.numbered_symbols("x"), optimizations="basic")
    lines = ["#include <math.h>", f"void {name}(const double *q, const double *u, double *A, double *f, "
             "double *L, double *E, double *h) {", "  (void)q, (void)u, (void)L, (void)E, (void)h;"]
    lines += [f"  const double {symbol} = {sp.ccode(e)};" for symbol, e in shared]
    lines += [f"  {target} = {sp.ccode(e)};" for (target, _), e in zip(targets, results)]
    return "\n".join(lines + ["}", ""])


def seconds(who):
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


def main():
    scene_file, name, compiler, folder = sys.argv[1:]
    with open(scene_file, "rb") as file:
        scene = tomllib.load(file)
    with open(f"{folder}/{name}.c", "w") as file:
        file.write(c_text(name, equations(scene)))
    subprocess.run([compiler, "-O3", "-fPIC", "-c", f"{folder}/{name}.c", "-o", f"{folder}/{name}.o"], check=True)
    with open(f"{folder}/{name}.seconds", "w") as file:
        file.write(f"{seconds(resource.RUSAGE_SELF):.3f} {seconds(resource.RUSAGE_CHILDREN):.3f}\n")


main()
