#!/usr/bin/env python3
"""How near each sample's run comes by its own settings, and what it costs: tests/bench/samples.py [BORELLI]

Runs every scene of samples/ as it stands, and again by dop853 (arkode where that does not come through) at a tolerance
of 1e-13, and prints the largest difference of a solid's position (m) and orientation (rad) at 20 times, and the
evaluations of the equations that the first takes. Motions that are chaotic differ by anything after a while. What the tight runs
agree with (closed forms, published figures) is said by the tests of each scene.
"""
import csv, json, math, pathlib, subprocess, sys, tempfile

root = pathlib.Path(__file__).resolve().parents[2]
borelli = sys.argv[1] if len(sys.argv) > 1 else str(root / "build/release/borelli")


def motion(scene, folder, *options):
    """Rows of (name, value) by column, and the answer's certificate; None: no motion."""
    out = folder / "motion.csv"
    done = subprocess.run([borelli, "simulate", scene, "--json", "--allow-untrusted", "-o", out, *options],
                          capture_output=True, text=True)
    if done.returncode != 0:
        return None, done.stderr.strip().split("\n")[-1]
    answer = json.loads(done.stdout)
    with open(out) as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return rows, answer.get("certificate", answer)


def apart(a, b):
    """The largest distance (m) and angle (rad) between two rows' solids."""
    far = turned = 0.0
    for name in a:
        if name.startswith("position ") and name.endswith(".x [m]"):
            stem = name[:-5]
            far = max(far, math.dist([float(a[stem + c + " [m]"]) for c in "xyz"], [float(b[stem + c + " [m]"]) for c in "xyz"]))
        if name.startswith("orientation ") and name.endswith(".w [1]"):
            stem = name[:-5]
            p, q = ([float(row[stem + c + " [1]"]) for c in "wxyz"] for row in (a, b))
            chord = min(math.dist(p, q), math.dist(p, [-x for x in q]))
            turned = max(turned, 4 * math.asin(min(1, chord / 2)))
    return far, turned


print("| scene | method | off by (m) | off by (rad) | evaluations |\n| --- | --- | ---: | ---: | ---: |")
with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    for scene in sorted((root / "samples").glob("*.toml")):
        probe, first = motion(scene, folder)
        if probe is None:
            print(f"| {scene.stem} | | | | {first} |")
            continue
        each = ["--output-interval", repr((float(probe[-1]["time [s]"]) - float(probe[0]["time [s]"])) / 20)]
        own, _ = motion(scene, folder, *each)
        for method in ("dop853", "arkode"):
            tight, _ = motion(scene, folder, *each, "--method", method, "--tolerance", "1e-13")
            if tight is not None:
                break
        worst = (float("nan"),) * 2
        if own and tight and len(own) == len(tight):
            worst = tuple(max(x) for x in zip(*(apart(a, b) for a, b in zip(own, tight))))
        print(f"| {scene.stem} | {first['method']} | {worst[0]:.1e} | {worst[1]:.1e} | {first['evaluations']} |", flush=True)
