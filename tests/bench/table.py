#!/usr/bin/env python3
"""The benchmark tables and the plots of cost against size, from the Google Benchmark programs.

    tests/bench/table.py [BUILD] [-o FOLDER] [--repetitions N] [--quick]

Runs equations_bench, moments_bench, volumes_bench and, where they were built, mujoco_bench, constraints_bench and
ensemble_bench of BUILD (build/release), each benchmark N times in random order, and takes medians: of processor time, and
of wall time where both cores may work. Leaves in FOLDER (bench):

    README.md     the tables, between the two lines that name this script where the file has them (tests/bench has)
    bodies.svg    nanoseconds per evaluation against the number of bodies, up to 10000, with fitted exponents
    voxels.svg    milliseconds of one thread's moments against voxels, up to 512 x 512 x 2000

The exponent of a curve is the slope of the least squares line through the logarithms of its sizes from 100 bodies or 1e7
voxels on: below that what does not grow with the size still shows. --quick leaves out the largest sizes.
"""
import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile

# Okabe & Ito (2008), as in pipeline/plot.hpp
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"]
FITTED_FROM = {"bodies": 100, "voxels": 1e7}
BEGIN, END = "<!-- tests/bench/table.py: from here -->", "<!-- tests/bench/table.py: to here -->"


def run(program, repetitions, only=None):
    """Of one program, per benchmark: median seconds; its label and median rate (items per second)."""
    scratch = tempfile.TemporaryDirectory()
    out = os.path.join(scratch.name, "out.json")
    command = [program, f"--benchmark_repetitions={repetitions}", "--benchmark_enable_random_interleaving=true",
               f"--benchmark_out={out}", "--benchmark_out_format=json", "--benchmark_min_time=0.05"]
    if only:
        command.append(f"--benchmark_filter={only}")
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    if not os.path.exists(out):  # it has nothing to time without the data
        return {}, {}
    with open(out, encoding="utf-8") as file:
        answer = json.load(file)
    units = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}
    times, rates = {}, {}
    for b in sorted(answer.get("benchmarks", []), key=lambda b: b["family_index"]):  # in the order of their making
        if b.get("run_type") != "iteration" or b.get("error_occurred"):
            continue
        name = b["run_name"].removesuffix("/real_time")
        time = b["cpu_time"] if name == b["run_name"] else b["real_time"]
        times.setdefault(name, []).append(time * units[b["time_unit"]])
        rates.setdefault(name, (b.get("label", ""), []))[1].append(b.get("items_per_second", 0))
    if not times:
        sys.exit(f"{program} left no times")
    return ({name: statistics.median(t) for name, t in times.items()},
            {name: (label, statistics.median(r)) for name, (label, r) in rates.items()})


def fitted_exponent(points, start):
    """Of y = factor x^exponent, over the points with x >= start; None below three of them."""
    logs = [(math.log(x), math.log(y)) for x, y in points if x >= start]
    if len(logs) < 3:
        return None
    mx = sum(x for x, _ in logs) / len(logs)
    my = sum(y for _, y in logs) / len(logs)
    return sum((x - mx) * (y - my) for x, y in logs) / sum((x - mx) ** 2 for x, _ in logs)


def plot(path, title, x_label, y_label, curves, start):
    """Curves {name: [(x, y)]} on two logarithmic axes; returns {name: fitted exponent}."""
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
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(out) + "\n")
    return exponents


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


def scene_order(name):
    scene = name.split("/")[0]
    kind = scene.rstrip("0123456789")
    return kind != "human", kind, int(scene[len(kind):] or 0)


def mujoco_table(times):
    """Rows of scene x quantity with both times and their ratio."""
    lines = ["| scene | of | here | MuJoCo | ratio |", "| --- | --- | ---: | ---: | ---: |"]
    for name in sorted(times, key=lambda name: (name.split("/")[1], scene_order(name))):
        if name.endswith("/mujoco"):
            continue
        scene, what = name.split("/", 1)
        other = times.get(name + "/mujoco")
        lines.append(f"| {scene} | {what.replace('_', ' ')} | {short(times[name])} | "
                     f"{short(other) if other else '-'} | {f'{other / times[name]:.2f}' if other else '-'} |")
    return lines


def constraints_table(times):
    """Rows of scenes held by loops: within a step, with the rank decided, MuJoCo's, and the ratio to the first."""
    lines = ["| scene | within a step | with the rank | MuJoCo | ratio |", "| --- | ---: | ---: | ---: | ---: |"]
    for name in sorted(times, key=lambda name: scene_order(name.replace("standing_human", "human"))):
        scene, what = name.split("/", 1)
        if what != "accelerations":
            continue
        other = times.get(name + "/mujoco")
        ratio = f"{other / times[name]:.2f}" if other else "-"
        lines.append(f"| {scene.replace('_', ' ')} | {short(times[name])} | {short(times[name + '_and_rank'])} | "
                     f"{short(other) if other else '-'} | {ratio} |")
    curve = [(float(name.split("/")[0].removeprefix("windows")), seconds) for name, seconds in times.items()
             if name.startswith("windows") and name.endswith("/accelerations")]
    exponent = fitted_exponent(curve, 5)
    if exponent is not None:
        lines += ["", f"Fitted exponent of windows, from 5 to {max(curve)[0]:.0f}: {exponent:.2f}."]
    return lines


def ensemble_table(rates):
    """Rows of methods: swings per second on one core and on all, and how far they are off."""
    lines = ["| method | one core, 1/s | all cores, 1/s | 10 000 on one core | on all | off by |",
             "| --- | ---: | ---: | ---: | ---: | --- |"]
    for name, (label, rate) in rates.items():
        if not name.endswith("/one_core"):
            continue
        every = rates.get(name.replace("one_core", "all_cores"), (None, 0))[1]
        lines.append(f"| {name.removesuffix('/one_core').replace('_', ' ').replace('/', ', ')} | {rate:.0f} | "
                     f"{f'{every:.0f}' if every else '-'} | {1e4 / rate:.1f} s | {f'{1e4 / every:.1f} s' if every else '-'} | {label} |")
    return lines


def volumes_table(times):
    """Rows of what is done with a volume: on one core and on all, ours and ITK's, and the ratio on all."""
    lines = ["| of | one core | all cores | ITK, one core | ITK, all cores | ratio |",
             "| --- | ---: | ---: | ---: | ---: | ---: |"]
    for name in times:
        if not name.endswith("/one_core"):
            continue
        row = [times.get(name.replace("one_core", cores) + of) for of in ("", "/itk")
               for cores in ("one_core", "all_cores")]
        lines.append(f"| {name.removesuffix('/one_core').replace('_', ' ')} | "
                     + " | ".join(short(t) if t else "-" for t in row)
                     + f" | {f'{row[3] / row[1]:.2f}' if row[3] else '-'} |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default="build/release")
    parser.add_argument("-o", "--out", default="bench")
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--quick", action="store_true")
    asked = parser.parse_args()
    os.makedirs(asked.out, exist_ok=True)

    def program(name):
        path = os.path.join(asked.build, name)
        return path if os.access(path, os.X_OK) else None

    for name in ("equations_bench", "moments_bench", "volumes_bench"):
        if not program(name):
            sys.exit(f"{asked.build} has no {name}: build it with the tests (BORELLI_TESTS=ON)")
    lines = [f"On {processor()}, one thread, medians of {asked.repetitions} in random order, "
             f"of processor time.", ""]
    if program("mujoco_bench"):
        times, _ = run(program("mujoco_bench"), asked.repetitions)
        lines += ["Beside MuJoCo, the same files in one run (`mujoco_bench`):", ""]
        lines += mujoco_table(times) + [""]
    if program("constraints_bench"):
        times, _ = run(program("constraints_bench"), asked.repetitions)
        lines += ["Bodies held by loops, one evaluation, beside MuJoCo's soft rows (`constraints_bench`):", ""]
        lines += constraints_table(times) + [""]
    if program("ensemble_bench"):
        _, rates = run(program("ensemble_bench"), asked.repetitions)
        if rates:
            lines += ["A second of a human's free motion from a thousand starts, wall time (`ensemble_bench`); off by: the largest "
                      "error of a coordinate, m or rad:", ""]
            lines += ensemble_table(rates) + [""]

    times, _ = run(program("equations_bench"), asked.repetitions,
                   "[a-z]*/(lagrange|recursive)/[0-9]{1,3}$" if asked.quick else None)
    curves, ratios = {}, {}
    for name, seconds in times.items():
        scene, *rest = name.split("/")
        if len(rest) != 2:
            continue
        curves.setdefault(f"{scene.replace('_', ' ')}, {rest[0]}", []).append((float(rest[1]), seconds * 1e9))
        ratios.setdefault((scene, int(rest[1])), {})[rest[0]] = seconds
    shown = {name: points for name, points in curves.items() if max(x for x, _ in points) >= 100}
    exponents = plot(os.path.join(asked.out, "bodies.svg"), "Accelerations: cost against the number of bodies",
                     "bodies", "ns per evaluation", shown, FITTED_FROM["bodies"])
    lines += ["The paper's scan (`lagrange`) beside the recursions, one evaluation of the accelerations "
              "(`equations_bench`):", "", "| scene | bodies | lagrange | recursive | ratio |",
              "| --- | ---: | ---: | ---: | ---: |"]
    for (scene, n), pair in sorted(ratios.items()):
        if "lagrange" in pair and "recursive" in pair:
            lines.append(f"| {scene.replace('_', ' ')} | {n} | {short(pair['lagrange'])} | {short(pair['recursive'])} "
                         f"| {pair['lagrange'] / pair['recursive']:.2f} |")
    nearer = {name: fitted_exponent([p for p in points if p[0] <= 1000], FITTED_FROM["bodies"])
              for name, points in shown.items()}
    fitted = ", ".join(f"{name} {e:.2f}" for name, e in sorted(nearer.items()) if e is not None)
    lines += ["", "![Cost against the number of bodies](bodies.svg)", "",
              f"Fitted exponents of bodies from 100 to 1000: {fitted or 'too few were run'}.",
              "Of all from "
              f"{FITTED_FROM['bodies']} on, which no longer lie in the processor's cache: "
              + ", ".join(f"{name} {e:.2f}" for name, e in sorted(exponents.items())) + ".", ""]

    times, rates = run(program("moments_bench"), asked.repetitions,
                       "^(read_bytes|borelli_moments|itk.*)/[01]$|^moments_of_size/[0-9]{1,3}$" if asked.quick else None)
    lines += ["Moments of 16 labels, one thread (`moments_bench`):", "",
              "| of | volume | Gvoxel/s | ours over it |", "| --- | --- | ---: | ---: |"]
    ours = {label: rate for name, (label, rate) in rates.items() if name.startswith("borelli_moments")}
    for name, (label, rate) in sorted(rates.items()):
        if label in ours and "size" not in name:
            lines.append(f"| {name.split('/')[0].replace('_', ' ')} | {label} | {rate * 1e-9:.2f} | {ours[label] / rate:.2f} |")
    sizes = [(512.0 * 512 * int(name.split("/")[1]), 1e3 * seconds) for name, seconds in times.items()
             if name.startswith("moments_of_size")]
    exponents = plot(os.path.join(asked.out, "voxels.svg"), "Moments of 512 x 512 x n voxels, one thread", "voxels", "ms",
                     {"16 parts": sizes}, FITTED_FROM["voxels"])
    lines += ["", "![Cost against voxels](voxels.svg)", "", "Cost against voxels up to 512 x 512 x "
              f"{int(max(sizes)[0] / 512 / 512)}, fitted exponent: {exponents.get('16 parts', float('nan')):.2f}.", ""]
    times, _ = run(program("volumes_bench"), asked.repetitions)
    lines += ["What else is done with a volume, the sample phantom of 3 mm, wall time (`volumes_bench`). Not quite the same are "
              "the distances (ours to the mask, also only up to 20 voxels, ITK's within it, too) and `coarser` (ours along the "
              "patient's axes, wherever the scan's lie, ITK's along the scan's):", ""]
    lines += volumes_table(times) + [""]
    put(os.path.join(asked.out, "README.md"), "\n".join(lines))
    print("\n".join(lines))


def put(path, text):
    """Writes the tables: between the two lines that name this script, or as a file of their own."""
    before, after = "", ""
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            whole = file.read()
        if BEGIN not in whole or END not in whole:
            sys.exit(f"{path} is there and does not say where the tables belong: give another folder (-o)")
        before, after = whole.split(BEGIN)[0], whole.split(END)[1]
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"{before}{BEGIN}\n{text}\n{END}{after or chr(10)}")


if __name__ == "__main__":
    main()
