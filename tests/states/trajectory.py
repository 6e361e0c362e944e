#!/usr/bin/env python3
"""Writes trajectory.csv: a tetrahedron of springs with memory, hung up at one node, integrated by SciPy.

The equations are written here from the formulas of the laws and share no code with springnet. DOP853 with a relative
tolerance of 1e-12 agrees with Radau at 1e-10 to 1e-10 m (printed). Needs Debian's python3-scipy:

    /usr/bin/python3 tests/states/trajectory.py > tests/states/trajectory.csv
"""
import sys

import numpy as np
from scipy.integrate import solve_ivp

GRAVITY = np.array([0.0, 0.0, -9.81])
MASS = np.array([1.0, 0.8, 0.5, 1.2])
START = np.array([[0, 0, 0], [1, 0, -0.2], [0.1, 0.9, -0.3], [0.3, 0.2, -1.0]], float)  # m; node 0 is fixed
DAMPING = 0.4  # N s/m, of every spring

# name of the law, its ends, parameters
SPRINGS = [
    ("maxwell", 0, 1, dict(k=60.0, tau=0.8)),
    ("standard_linear_solid", 0, 2, dict(k=80.0, k1=120.0, tau=0.15)),
    ("plastic", 0, 3, dict(k=150.0, Y=9.0, H=20.0, tau=0.05)),
    ("damaging", 1, 2, dict(k=90.0, e0=0.02, es=0.8, tau=0.1)),
    ("standard_linear_solid", 1, 3, dict(k=70.0, k1=40.0, tau=0.02)),
    ("plastic", 2, 3, dict(k=110.0, Y=4.0, H=0.0, tau=0.2)),
]
LENGTH = [np.linalg.norm(START[a] - START[b]) for _, a, b, _ in SPRINGS]


def law(name, x, rest, z, p):
    """Tension and rate of the state, for the elongation x."""
    if name == "maxwell":
        return p["k"] * (x - z), (x - z) / p["tau"]
    if name == "standard_linear_solid":
        return p["k"] * x + p["k1"] * (x - z), (x - z) / p["tau"]
    if name == "plastic":
        tension = p["k"] * (x - z)
        drive = tension - p["H"] * z
        over = max(abs(drive) - p["Y"], 0.0) * np.sign(drive)
        return tension, over / (p["k"] * p["tau"])
    strain = x / rest
    aim = 0.0
    if strain > p["e0"]:
        aim = min((p["e0"] + p["es"]) / p["es"] * (1.0 - p["e0"] / strain), 1.0)
    return (1.0 - z) * p["k"] * x, max(aim - z, 0.0) / p["tau"]


def rates(_, y):
    position, velocity, state = y[:12].reshape(4, 3), y[12:24].reshape(4, 3), y[24:]
    force = MASS[:, None] * GRAVITY
    change = np.zeros(len(SPRINGS))
    for s, (name, a, b, p) in enumerate(SPRINGS):
        d = position[a] - position[b]
        length = np.linalg.norm(d)
        n = d / length
        tension, change[s] = law(name, length - LENGTH[s], LENGTH[s], state[s], p)
        tension += DAMPING * n @ (velocity[a] - velocity[b])
        force[a] -= tension * n
        force[b] += tension * n
    acceleration = force / MASS[:, None]
    acceleration[0] = 0.0
    return np.concatenate([velocity.ravel(), acceleration.ravel(), change])


times = np.linspace(0.0, 2.0, 9)
start = np.concatenate([START.ravel(), np.zeros(12 + len(SPRINGS))])
runs = [
    solve_ivp(rates, (0.0, 2.0), start, method=method, t_eval=times, rtol=tolerance, atol=1e-13, max_step=step)
    for method, tolerance, step in (("DOP853", 1e-12, 2e-3), ("Radau", 1e-10, 2e-3))
]
print("greatest difference of two methods:", np.abs(runs[0].y - runs[1].y).max(), file=sys.stderr)
names = [f"{c}{k}" for k in range(4) for c in "xyz"] + [f"v{c}{k}" for k in range(4) for c in "xyz"]
print(",".join(["time"] + names + [f"z{s}" for s in range(len(SPRINGS))]))
for time, column in zip(times, runs[0].y.T):
    print(",".join(repr(float(v)) for v in [time, *column]))
