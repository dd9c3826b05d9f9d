#!/usr/bin/env python3
"""The benchmark tables and the plots of cost against size.

    tests/bench/table.py [BUILD] [-o FOLDER] [--sections NAME,...] [--repetitions N] [--quick]

Runs the Google Benchmark programs of BUILD (build/release), each benchmark N times in random order, and takes medians: of
processor time, and of wall time where both cores may work. Then `borelli chart`, `peers`, and the program's whole way from
a volume to the report. What was not built (MuJoCo's) or has not its data is left out; where anything fails, nothing is
written. Leaves in FOLDER (bench):

    README.md     the tables, between the two lines that name this script where the file has them (tests/bench has)
    bodies.svg    nanoseconds per evaluation against the number of bodies, up to 10000, with fitted exponents
    voxels.svg    milliseconds of one thread's moments against voxels, up to 512 x 512 x 2000
    runs.svg      seconds of whole runs, segmentation, inertia and meshes against voxels, up to as many

With --sections (mujoco, constraints, ensemble, equations, work_precision, recording, floor, moments, volumes, whole_runs, sizes,
peers) those alone are made anew, the file's others stay; each says on which processor it was made.

The exponent of a curve is the slope of the least squares line through the logarithms of its sizes from 100 bodies or 1e7
voxels on: below that what does not grow with the size still shows. --quick leaves out the largest sizes and whole runs.
"""
import argparse
import csv
import json
import math
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Okabe & Ito (2008), as in pipeline/charts/plot.hpp
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"]
FITTED_FROM = {"bodies": 100, "voxels": 1e7}
BEGIN, END = "<!-- tests/bench/table.py: from here -->", "<!-- tests/bench/table.py: to here -->"


@dataclass
class Timing:
    """One benchmark's runs: seconds, items per second, and what it says of itself."""
    all_seconds: list = field(default_factory=list)
    all_rates: list = field(default_factory=list)
    all_counters: list = field(default_factory=list)  # dicts
    label: str = ""

    @property
    def seconds(self):
        return statistics.median(self.all_seconds)

    @property
    def rate(self):
        return statistics.median(self.all_rates)

    def counter(self, name):
        return statistics.median(run[name] for run in self.all_counters)

    @property
    def spread(self):
        return (max(self.all_seconds) - min(self.all_seconds)) / self.seconds


class Programs:
    """The programs of a build."""

    def __init__(self, build, repetitions, quick):
        self.build, self.repetitions, self.quick = build, repetitions, quick

    def path(self, name):
        """None: it was not built."""
        path = os.path.join(self.build, name)
        return path if os.access(path, os.X_OK) else None

    def run(self, *command):
        """What it prints; ends with its own last words where it fails."""
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            said = (done.stderr or done.stdout).strip().splitlines()
            sys.exit(f"{' '.join(map(str, command))} ended with {done.returncode}: {said[-1] if said else 'it said nothing'}")
        return done.stdout

    def time(self, name, only=None):
        """{benchmark: Timing} in the order of their making; none where the program or its data is not here."""
        if not self.path(name):
            return {}
        print(f"{name} ...", file=sys.stderr, flush=True)
        with tempfile.TemporaryDirectory() as scratch:
            out = os.path.join(scratch, "out.json")
            command = [self.path(name), f"--benchmark_repetitions={self.repetitions}", f"--benchmark_out={out}",
                       "--benchmark_enable_random_interleaving=true", "--benchmark_out_format=json",
                       "--benchmark_min_time=0.05"]
            if only:
                command.append(f"--benchmark_filter={only}")
            self.run(*command)
            if not os.path.exists(out) or os.path.getsize(out) == 0:  # it has nothing to time without the data
                return {}
            with open(out, encoding="utf-8") as file:
                answer = json.load(file)
        units = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}
        timings = {}
        for b in sorted(answer.get("benchmarks", []), key=lambda b: b["family_index"]):
            if b.get("error_occurred"):
                sys.exit(f"{name}: {b['run_name']}: {b['error_message']}")
            if b.get("run_type") != "iteration":
                continue
            benchmark = b["run_name"].removesuffix("/real_time")
            seconds = b["cpu_time"] if benchmark == b["run_name"] else b["real_time"]
            timing = timings.setdefault(benchmark, Timing(label=b.get("label", "")))
            timing.all_seconds.append(seconds * units[b["time_unit"]])
            timing.all_rates.append(b.get("items_per_second", 0))
            timing.all_counters.append(b)
        return timings


def spread_of(timings):
    """How far apart the runs of one benchmark lie, of its median."""
    spreads = [t.spread for t in timings.values()]
    return (f"Runs of one benchmark differ by {100 * statistics.median(spreads):.1f} % of their median (the middle one of these; "
            f"at most by {100 * max(spreads):.0f} %).")


def fitted_exponent(points, start):
    """Of y = factor x^exponent, over the points with x >= start; None below three of them."""
    logs = [(math.log(x), math.log(y)) for x, y in points if x >= start]
    if len(logs) < 3:
        return None
    mx = sum(x for x, _ in logs) / len(logs)
    my = sum(y for _, y in logs) / len(logs)
    return sum((x - mx) * (y - my) for x, y in logs) / sum((x - mx) ** 2 for x, _ in logs)


def plot(title, x_label, y_label, curves, start):
    """Curves {name: [(x, y)]} on two logarithmic axes: an SVG and {name: fitted exponent}."""
    width, height, left, right, top, bottom = 760, 460, 80, 290, 40, 60
    xs = [x for points in curves.values() for x, _ in points]
    ys = [y for points in curves.values() for _, y in points]
    low_x, high_x = math.floor(math.log10(min(xs))), math.ceil(math.log10(max(xs)))
    low_y, high_y = math.floor(math.log10(min(ys))), math.ceil(math.log10(max(ys)))

    def at(x, y):
        return (left + (math.log10(x) - low_x) / (high_x - low_x) * (width - left - right),
                height - bottom - (math.log10(y) - low_y) / (high_y - low_y) * (height - top - bottom))

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
           f'font-size="12"><rect width="{width}" height="{height}" fill="white"/>',
           f'<text x="{left}" y="22" font-size="15">{title}</text>']
    for n in range(low_x, high_x + 1):
        x = at(10.0 ** n, 10.0 ** low_y)[0]
        out.append(f'<path d="M{x:.1f} {top}V{height - bottom}" stroke="#ddd"/>'
                   f'<text x="{x:.1f}" y="{height - bottom + 16}" text-anchor="middle">10<tspan dy="-4" '
                   f'font-size="9">{n}</tspan></text>')
    for n in range(low_y, high_y + 1):
        y = at(10.0 ** low_x, 10.0 ** n)[1]
        out.append(f'<path d="M{left} {y:.1f}H{width - right}" stroke="#ddd"/><text x="{left - 8}" y="{y + 4:.1f}" '
                   f'text-anchor="end">10<tspan dy="-4" font-size="9">{n}</tspan></text>')
    out.append(f'<text x="{(left + width - right) / 2}" y="{height - 16}" text-anchor="middle">{x_label}</text>'
               f'<text transform="translate(22 {(top + height - bottom) / 2}) rotate(-90)" '
               f'text-anchor="middle">{y_label}</text>')
    exponents = {}
    kinds = sorted({name.split(",")[0] for name in curves})
    for number, (name, points) in enumerate(sorted(curves.items())):
        colour = COLOURS[kinds.index(name.split(",")[0]) % len(COLOURS)]
        dash = ' stroke-dasharray="5 4"' if name.endswith("lagrange") else ""
        points = sorted(points)
        path_of = " ".join(f"{'ML'[i > 0]}{at(*p)[0]:.1f} {at(*p)[1]:.1f}" for i, p in enumerate(points))
        out.append(f'<path d="{path_of}" fill="none" stroke="{colour}" stroke-width="2"{dash}/>')
        out += [f'<circle cx="{at(*p)[0]:.1f}" cy="{at(*p)[1]:.1f}" r="3" fill="{colour}"/>' for p in points]
        exponent = fitted_exponent(points, start)
        text = name
        if exponent is not None:
            exponents[name] = exponent
            text += f": exponent {exponent:.2f}"
        y = top + 16 + 20 * number
        out.append(f'<path d="M{width - right + 12} {y - 4}h26" stroke="{colour}" stroke-width="2"{dash}/>'
                   f'<text x="{width - right + 44}" y="{y}">{text}</text>')
    out.append("</svg>")
    return "\n".join(out) + "\n", exponents


def short(seconds):
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e9:.0f} ns"


def processor():
    """With its family and model: one name and clock may stand for processors that differ by a third."""
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        known = {key.strip(): value.strip() for key, _, value in (line.partition(":") for line in file)}
    return (f"{known.get('model name', 'an unknown processor')} (family {known.get('cpu family', '?')}, "
            f"model {known.get('model', '?')}) at {float(known.get('cpu MHz', 'nan')):.0f} MHz")


def beside(ours, other):
    """Another program's time and what it takes over ours, as two cells."""
    return f"{short(other.seconds)} | {other.seconds / ours:.2f}" if other else "- | -"


def scene_order(name):
    scene = name.split("/")[0]
    kind = scene.rstrip("0123456789")
    return kind != "human", kind, int(scene[len(kind):] or 0)


def mujoco_section(programs, _):
    """Rows of scene x quantity with both times and their ratio."""
    timings = programs.time("mujoco_bench")
    lines = ["Beside MuJoCo, the same files in one run (`mujoco_bench`):", "",
             "| scene | of | here | MuJoCo | ratio |", "| --- | --- | ---: | ---: | ---: |"]
    names = sorted(timings, key=lambda name: (name.split("/")[1], scene_order(name)))
    for name in names:
        if name.endswith("/mujoco") or "_by_" in name:
            continue
        scene, what = name.split("/", 1)
        ours, other = timings[name].seconds, timings.get(name + "/mujoco")
        lines.append(f"| {scene} | {what.replace('_', ' ')} | {short(ours)} | {beside(ours, other)} |")
    lines += ["", "One of eight states in a batch beside one by itself, by the processor's widest registers (AVX-512: 8 numbers, AVX2: 4), and "
              "by those of 4 and of 2 where these are narrower:", "",
              "| scene | of | alone | of eight, widest | 4 | 2 | alone over the first |", "| --- | --- | ---: | ---: | ---: | ---: | ---: |"]
    for name in names:
        if not name.endswith("_of_eight"):
            continue
        scene, what = name.removesuffix("_of_eight").split("/", 1)
        each = [timings[n].seconds / 8 if n in timings else None for n in (name, name + "_by_4", name + "_by_2")]
        alone = timings[f"{scene}/{what}"].seconds
        lines.append(f"| {scene} | {what.replace('_', ' ')} | {short(alone)} | " + " | ".join(short(t) if t else "-" for t in each)
                     + f" | {alone / each[0]:.2f} |")
    return lines + ["", spread_of(timings)] if timings else []


def constraints_section(programs, _):
    """Rows of scenes held by loops: within a step, with the rank decided, MuJoCo's, and the ratio to the first."""
    timings = programs.time("constraints_bench")
    lines = ["Bodies held by loops, one evaluation, beside MuJoCo's soft rows (`constraints_bench`):", "",
             "| scene | within a step | with the rank | MuJoCo | ratio |", "| --- | ---: | ---: | ---: | ---: |"]
    for name in sorted(timings, key=lambda name: scene_order(name.replace("standing_human", "human"))):
        scene, what = name.split("/", 1)
        if what != "accelerations":
            continue
        ours, other = timings[name].seconds, timings.get(name + "/mujoco")
        lines.append(f"| {scene.replace('_', ' ')} | {short(ours)} | {short(timings[name + '_and_rank'].seconds)} | "
                     f"{beside(ours, other)} |")
    curve = [(float(name.split("/")[0].removeprefix("windows")), timing.seconds) for name, timing in timings.items()
             if name.startswith("windows") and name.endswith("/accelerations")]
    exponent = fitted_exponent(curve, 5)
    if exponent is not None:
        lines += ["", f"Fitted exponent of windows, from 5 to {max(curve)[0]:.0f}: {exponent:.2f}. {spread_of(timings)}"]
    return lines if timings else []


def ensemble_section(programs, _):
    """Rows of methods: swings per second on one core and on all, and how far they are off."""
    timings = programs.time("ensemble_bench")
    lines = ["A second of a human's free motion from a thousand starts, wall time (`ensemble_bench`); off by: the largest "
             "error of a coordinate, m or rad:", "",
             "| method | one core, 1/s | all cores, 1/s | 10 000 on one core | on all | off by |",
             "| --- | ---: | ---: | ---: | ---: | --- |"]
    for name, timing in timings.items():
        if not name.endswith("/one_core"):
            continue
        every = timings.get(name.replace("one_core", "all_cores"))
        lines.append(f"| {name.removesuffix('/one_core').replace('_', ' ').replace('/', ', ')} | {timing.rate:.0f} | "
                     f"{f'{every.rate:.0f}' if every else '-'} | {1e4 / timing.rate:.1f} s | "
                     f"{f'{1e4 / every.rate:.1f} s' if every else '-'} | {timing.label} |")
    return lines + ["", spread_of(timings)] if timings else []


def equations_section(programs, drawings):
    timings = programs.time("equations_bench", "[a-z]*/(lagrange|recursive)/[0-9]{1,3}$" if programs.quick else None)
    curves, ratios = {}, {}
    for name, timing in timings.items():
        scene, *rest = name.split("/")
        if len(rest) != 2:
            continue
        curves.setdefault(f"{scene.replace('_', ' ')}, {rest[0]}", []).append((float(rest[1]), timing.seconds * 1e9))
        ratios.setdefault((scene, int(rest[1])), {})[rest[0]] = timing.seconds
    shown = {name: points for name, points in curves.items() if max(x for x, _ in points) >= 100}
    drawings["bodies.svg"], exponents = plot("Accelerations: cost against the number of bodies", "bodies", "ns per evaluation",
                                             shown, FITTED_FROM["bodies"])
    lines = ["The paper's scan (`lagrange`) beside the recursions, one evaluation of the accelerations (`equations_bench`):", "",
             "| scene | bodies | lagrange | recursive | ratio |", "| --- | ---: | ---: | ---: | ---: |"]
    for (scene, n), pair in sorted(ratios.items()):
        if "lagrange" in pair and "recursive" in pair:
            lines.append(f"| {scene.replace('_', ' ')} | {n} | {short(pair['lagrange'])} | {short(pair['recursive'])} "
                         f"| {pair['lagrange'] / pair['recursive']:.2f} |")
    nearer = {name: fitted_exponent([p for p in points if p[0] <= 1000], FITTED_FROM["bodies"])
              for name, points in shown.items()}
    fitted = ", ".join(f"{name} {e:.2f}" for name, e in sorted(nearer.items()) if e is not None)
    of_all = ", ".join(f"{name} {e:.2f}" for name, e in sorted(exponents.items()))
    far = f" Of all from {FITTED_FROM['bodies']} on, which no longer lie in the processor's cache: {of_all}."
    return lines + ["", "![Cost against the number of bodies](bodies.svg)", "",
                    f"Fitted exponents of bodies from 100 to 1000: {fitted or 'too few were run'}."
                    + (far if of_all and not programs.quick else "") + f" {spread_of(timings)}"]


def work_precision_section(programs, _):
    """Rows of scenes and methods: the quickest trusted run within each error, by `borelli chart`."""
    print("borelli chart ...", file=sys.stderr, flush=True)
    errors, repeats = (1e-3, 1e-6, 1e-9), 11 if programs.quick else 101
    lines = ["Milliseconds of a whole run to an error of position (over the scene's length) and angle (rad), at 20 times and at four "
             f"(`borelli chart SCENE --methods gauss16,gbs,dop853 --equations recursive --budget 0.1 --per-decade 3 --repeats {repeats}`, "
             "and `--samples 4`):", "",
             "| scene | method | at 20: " + " | ".join(f"{e:.0e}".replace("e-0", "e-") for e in errors)
             + " | at 4: " + " | ".join(f"{e:.0e}".replace("e-0", "e-") for e in errors) + " |",
             "| --- | --- |" + " ---: |" * (2 * len(errors))]
    for scene in ("samples/double_pendulum.toml", "tests/bench/peers/scenes/chain_7.toml", "samples/roundabout.toml"):
        rows = {}
        for outputs in (20, 4):
            with tempfile.TemporaryDirectory() as folder:
                programs.run(programs.path("borelli"), "chart", ROOT / scene, "-o", folder, "--methods", "gauss16,gbs,dop853",
                             "--equations", "recursive", "--budget", "0.1", "--per-decade", "3", "--repeats", str(repeats),
                             "--samples", str(outputs))
                with open(os.path.join(folder, "chart.csv"), encoding="utf-8") as file:
                    runs = list(csv.DictReader(line for line in file if not line.startswith("#")))
            for error in errors:
                for method in dict.fromkeys(r["method"] for r in runs):
                    within = [float(r["seconds"]) for r in runs if r["method"] == method and r["trusted"] == "1"
                              and float(r["position"]) <= error and float(r["orientation_rad"]) <= error]
                    rows.setdefault(method, []).append(f"{1e3 * min(within):.3f}" if within else "-")
        lines += [f"| {pathlib.Path(scene).stem.replace('_', ' ')} | {method} | " + " | ".join(cells) + " |"
                  for method, cells in rows.items()]
    return lines


def recording_section(programs, _):
    timings = programs.time("recording_bench")
    lines = ["Every step recorded, beside the end alone, in turns, wall time (`recording_bench`; what it adds is the median of "
             "pairs, in brackets least and most of the runs):", "",
             "| scene | steps | the end | every step | adds |", "| --- | ---: | ---: | ---: | ---: |"]
    for name, timing in timings.items():
        adds = sorted(100 * (run["ratio"] - 1) for run in timing.all_counters)
        lines.append(f"| {name.replace('_', ' ')} | {timing.label} | {short(timing.counter('end'))} | {short(timing.counter('every_step'))} | "
                     f"{statistics.median(adds):.1f} % ({adds[0]:.1f}, {adds[-1]:.1f}) |")
    return lines if timings else []


def floor_section(programs, _):
    """Rows of steps, a table a model: times and errors of twelve falls."""
    timings = programs.time("floor_bench")
    lines = ["A human falls on the floor, 5 s without damping, from twelve heights a millimetre apart (`floor_bench`): processor "
             "time of a fall; overlap, energy and what putting apart moved are the worst of the twelve; momentum is the horizontal "
             "one of a floor without friction, which cannot change it."]
    model = ""
    for name, timing in timings.items():
        if name.split("/")[0] != model:
            model = name.split("/")[0]
            lines += ["", f"{model}:", "",
                      "| step | steps (tried in vain) | median (least, most) | real-time factor | overlap | energy off by | put apart "
                      "| momentum strays by | trusted |",
                      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"]
        of = timing.counter
        middle = 1e3 * of("median")
        least = 1e3 * min(run["least"] for run in timing.all_counters)
        most = 1e3 * max(run["most"] for run in timing.all_counters)
        lines.append(f"| {name.split('/')[1].removesuffix('ms')} ms | {of('steps'):.0f} ({of('in_vain'):.0f}) | {middle:.0f} ({least:.0f}, "
                     f"{most:.0f}) ms | {5e3 / middle:.0f} | {1e3 * of('overlap'):.3f} mm | {100 * of('energy'):.2f} % | "
                     f"{of('moved'):.2f} J | {of('momentum'):.2g} kg m/s | {of('trusted'):.0f} of 12"
                     f"{': ' + timing.label if timing.label else ''} |")
    return [*lines, "", spread_of(timings)] if timings else []


def moments_section(programs, drawings):
    timings = programs.time("moments_bench", "^(read_bytes|borelli_moments|itk.*)/[01]$|^moments_of_size/[0-9]{1,3}$"
                            if programs.quick else None)
    lines = ["Moments of 16 labels, one thread (`moments_bench`):", "",
             "| of | volume | Gvoxel/s | ours over it |", "| --- | --- | ---: | ---: |"]
    ours = {timing.label: timing.rate for name, timing in timings.items() if name.startswith("borelli_moments")}
    for name, timing in sorted(timings.items()):
        if timing.label in ours and "size" not in name:
            lines.append(f"| {name.split('/')[0].replace('_', ' ')} | {timing.label} | {timing.rate * 1e-9:.2f} | "
                         f"{ours[timing.label] / timing.rate:.2f} |")
    sizes = [(512.0 * 512 * int(name.split("/")[1]), 1e3 * timing.seconds) for name, timing in timings.items()
             if name.startswith("moments_of_size")]
    drawings["voxels.svg"], exponents = plot("Moments of 512 x 512 x n voxels, one thread", "voxels", "ms", {"16 parts": sizes},
                                             FITTED_FROM["voxels"])
    return lines + ["", "![Cost against voxels](voxels.svg)", "", "Cost against voxels up to 512 x 512 x "
                    f"{int(max(sizes)[0] / 512 / 512)}, fitted exponent: {exponents.get('16 parts', float('nan')):.2f}. "
                    + spread_of(timings)]


def volumes_section(programs, _):
    """Rows of what is done with a volume: on one core and on all, ours and ITK's, and the ratio on all."""
    timings = programs.time("volumes_bench")
    lines = ["What else is done with a volume, the sample phantom of 3 mm, wall time (`volumes_bench`). Not quite the same are "
             "the distances (ours to the mask, also only up to 20 voxels, ITK's within it, too) and `coarser` (ours along the "
             "patient's axes, wherever the scan's lie, ITK's along the scan's):", "",
             "| of | one core | all cores | ITK, one core | ITK, all cores | ratio |",
             "| --- | ---: | ---: | ---: | ---: | ---: |"]
    for name in timings:
        if not name.endswith("/one_core"):
            continue
        row = [timings.get(name.replace("one_core", cores) + of) for of in ("", "/itk") for cores in ("one_core", "all_cores")]
        lines.append(f"| {name.removesuffix('/one_core').replace('_', ' ')} | "
                     + " | ".join(short(t.seconds) if t else "-" for t in row)
                     + f" | {f'{row[3].seconds / row[1].seconds:.2f}' if row[3] else '-'} |")
    return lines + ["", spread_of(timings)]


def peers_section(programs, _):
    """Of the page of `peers` the summary, rows of scenes, what the others' fastest run takes over ours; and how contacts fare."""
    if not programs.path("peers"):
        return []
    print("peers ...", file=sys.stderr, flush=True)
    samples = ("roundabout", "double_pendulum", "heavy_top", "spinning_plate", "shock", "andrews", "four_bar_2", "bouncing_ball",
               "block_on_slope", "four_bar_40")
    scenes = [ROOT / f"samples/{name}.toml" for name in samples[:2 if programs.quick else None]]
    own = ROOT / "tests/bench/peers/scenes"
    scenes = [*([own / "chain_7.toml"] if programs.quick else sorted(own.glob("*.toml"))), *scenes]
    with tempfile.TemporaryDirectory() as folder:
        programs.run(programs.path("peers"), *scenes, "-o", folder, "--budget", "0.1", "--equations", "recursive", "--methods",
                     "dop853,dopri5,gbs,gauss16,rk4,semi_implicit_euler,cvode")
        page = pathlib.Path(folder, "README.md").read_text(encoding="utf-8").splitlines()
    first = next(n for n, line in enumerate(page) if line.startswith("| scene |"))
    end = page.index("", first)
    entered = dict.fromkeys(line.split(": first accelerations agree")[0] for line in page if ": first accelerations agree" in line)
    lines = [f"Whole simulations beside {', '.join(entered)} in one process (`peers`, with the methods and scenes of [its page]"
             "(peers/README.md)), times medians of three: what the fastest run of the others takes over our fastest trusted one, for errors of "
             "position (over the scene's length) and orientation (rad), on the ground of its four, of at most so much. Bold: ours "
             "loses. Alone: no run of theirs that took at most 0.1 s (or the first beyond) comes to it. -: less than ten times the "
             "reference's own error.", "", *page[first:end]]
    lines += ["", "Of each method with contacts the run that is off least by their four errors. Energy: how far it is from ours at the "
              "outputs, over what is turned over. Momentum: of all bodies together, how far it is from ours there, over the largest. "
              "Times of impacts: of balls."]
    scene = ""
    for n, line in enumerate(page):
        if line.startswith("## "):
            scene = line.removeprefix("## ")
        elif line.startswith("| method | ms | position | times of impacts"):
            lines += ["", f"{scene[0].upper()}{scene[1:]}:", "", *page[n:page.index("", n)]]
    return lines


class WholeRuns:
    """`borelli run` on volumes, and what it says of itself."""

    def __init__(self, programs):
        self.programs = programs
        self.borelli = [programs.path("borelli")]

    def phantom(self, spacing, volume):
        self.programs.run(self.borelli[-1], "phantom", "--spacing", *spacing, "--noise", "20", "-o", volume)

    def voxels(self, volume):
        info = self.programs.run(self.borelli[-1], "info", volume)
        return next(line.split(maxsplit=1)[1] for line in info.splitlines() if line.split()[:1] == ["voxels"])

    def run(self, volume, folder):
        """Seconds of wall time, GiB at most, run.json."""
        out = folder / "out"
        shutil.rmtree(out, ignore_errors=True)
        begin = time.monotonic()
        with open(folder / "said", "w+", encoding="utf-8") as said:
            child = subprocess.Popen([*self.borelli, "run", volume, "--sex", "male", "--pose", "standing", "-o", out],
                                     stdout=said, stderr=said)
            _, status, usage = os.wait4(child.pid, 0)
            seconds = time.monotonic() - begin
            said.seek(0)
            if status != 0:
                sys.exit(f"borelli run on {volume} ended with {os.waitstatus_to_exitcode(status)}: {said.read().strip()[-300:]}")
        answer = json.loads(next(out.glob("*/run.json")).read_text(encoding="utf-8"))
        return seconds, usage.ru_maxrss / 2**20, answer  # (of kB)


def whole_runs_section(programs, _):
    """Rows of volumes: wall time from volume to report, median of three and each; memory; slowest stages."""
    if programs.quick:
        return []
    whole = WholeRuns(programs)
    icrp = ROOT.parent / "shared/volumes/icrp_am/AM_hu.nii.gz"
    lines = ["From a volume to the report, picture and all, wall time on all cores (`borelli run`), three runs:", "",
             "| volume | voxels | median (each) | peak memory | slowest stages |", "| --- | --- | ---: | ---: | --- |"]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for title, spacing, volume in (("sample phantom, 3 mm", ["3"], folder / "sample.nii.gz"),
                                       ("ICRP male", None, icrp),
                                       ("phantom, as many voxels as a CT of 512 x 512 x 1000", ["1.465", "0.744", "1.788"],
                                        folder / "large.nii.gz")):
            if spacing:
                whole.phantom(spacing, volume)
            elif not volume.exists():
                continue
            print(f"borelli run, {title} ...", file=sys.stderr, flush=True)
            seconds, memory, answers = zip(*(whole.run(volume, folder) for _ in range(3)))
            slowest = ", ".join(f"{stage['stage']} {100 * stage['share']:.0f} %" for stage in answers[-1]["slowest"])
            lines.append(f"| {title} | {whole.voxels(volume)} | {statistics.median(seconds):.1f} s ({', '.join(f'{s:.1f}' for s in seconds)}) | "
                         f"{max(memory):.2f} GiB | {slowest} |")
    return lines


def sizes_section(programs, drawings):
    """Whole runs and their large stages against the voxels of the volume, the phantom up to 512 x 512 x 2000."""
    if programs.quick:
        return []
    whole = WholeRuns(programs)
    curves, most = {}, 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        volume = folder / "phantom.nii.gz"
        for spacing in (["6"], ["4"], ["3"], ["2"], ["1.465", "0.744", "1.788"], ["1.465", "0.744", "0.894"]):
            whole.phantom(spacing, volume)
            voxels = math.prod(int(n) for n in whole.voxels(volume).split(" x "))
            print(f"borelli run, {voxels} voxels ...", file=sys.stderr, flush=True)
            runs = [whole.run(volume, folder) for _ in range(3 if voxels < 1e8 else 1)]
            most = max(most, *(memory for _, memory, _ in runs))
            curves.setdefault("the whole run", []).append((voxels, statistics.median(seconds for seconds, _, _ in runs)))
            for stage in ("segmentation", "inertia", "mesh"):
                seconds = [next(s["seconds"] for s in answer["stages"] if s["stage"] == stage) for _, _, answer in runs]
                curves.setdefault(stage, []).append((voxels, statistics.median(seconds)))
    drawings["runs.svg"], exponents = plot("From a volume to the report: cost against voxels", "voxels", "s", curves,
                                           FITTED_FROM["voxels"])
    return ["![Cost of whole runs against voxels](runs.svg)", "",
            "Whole runs and their large stages against voxels, the phantom up to as many as 512 x 512 x 2000 "
            f"({most:.2f} GiB), medians of three runs, from 1e8 voxels on one; fitted exponents from 1e7: " + ", ".join(f"{name} {e:.2f}" for name, e in exponents.items())
            + ". Parts are looked for on one grid of 3 mm, whatever the scan's. Inertia at 4 mm: the planes between parts are varied over a "
            "sample of the voxels, all of them there, one of eight at 3 mm, of 27 at 2."]


SECTIONS = {"mujoco": mujoco_section, "constraints": constraints_section, "ensemble": ensemble_section, "equations": equations_section,
            "work_precision": work_precision_section, "recording": recording_section, "floor": floor_section,
            "moments": moments_section, "volumes": volumes_section, "whole_runs": whole_runs_section, "sizes": sizes_section,
            "peers": peers_section}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default="build/release")
    parser.add_argument("-o", "--out", default="bench")
    parser.add_argument("--sections", default=",".join(SECTIONS))
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--quick", action="store_true")
    asked = parser.parse_args()
    if asked.repetitions < 1:
        parser.error(f"--repetitions is {asked.repetitions}; expected at least 1")
    wanted = asked.sections.split(",")
    for name in wanted:
        if name not in SECTIONS:
            parser.error(f"there is no section '{name}'; expected some of {', '.join(SECTIONS)}")
    programs = Programs(asked.build, asked.repetitions, asked.quick)
    for name in ("borelli", "equations_bench", "moments_bench", "volumes_bench"):
        if not programs.path(name):
            sys.exit(f"{asked.build} has no {name}: build it with the tests (BORELLI_TESTS=ON)")
    try:
        os.makedirs(asked.out, exist_ok=True)
    except OSError as error:
        sys.exit(f"{asked.out}: {error.strerror}")
    readme = os.path.join(asked.out, "README.md")
    before, made, after = parts_of(readme)
    drawings = {}
    for name in wanted:
        if lines := SECTIONS[name](programs, drawings):  # else what there was of it stays
            made[name] = [*lines, "", f"*{processor()}.*", ""]
    for name, drawing in drawings.items():
        with open(os.path.join(asked.out, name), "w", encoding="utf-8") as file:
            file.write(drawing)
    lines = [f"Medians of {asked.repetitions} runs in random order, of one thread's processor time, unless it is said otherwise.", ""]
    for name in SECTIONS:
        lines += [f"<!-- {name} -->", *made[name]] if made.get(name) else []
    with open(readme, "w", encoding="utf-8") as file:
        file.write("\n".join([before + BEGIN, *lines, END + after]))
    print("\n".join(lines))


def parts_of(path):
    """What a file has before the tables, {section: its lines}, and what it has after them."""
    if not os.path.exists(path):
        return "", {}, "\n"
    with open(path, encoding="utf-8") as file:
        whole = file.read()
    before, begin, rest = whole.partition(BEGIN)
    tables, end, after = rest.partition(END)
    if not begin or not end:
        sys.exit(f"{path} is there and does not say where the tables belong: give another folder (-o)")
    if tables.strip() and not any(f"<!-- {name} -->" in tables for name in SECTIONS):
        sys.exit(f"{path} has tables without a line for each section, such as <!-- mujoco -->: give another folder (-o)")
    made, name = {}, None
    for line in tables.split("\n"):
        if line.startswith("<!-- ") and line[5:-4] in SECTIONS:
            name = line[5:-4]
            made[name] = []
        elif name:
            made[name].append(line)
    for lines in made.values():
        while lines and not lines[-1]:
            lines.pop()
        lines.append("")
    return before, made, after


if __name__ == "__main__":
    main()
