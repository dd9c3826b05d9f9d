"""The sections of table.py on dynamics: each gives the lines of its tables, and puts its plots into `drawings`."""
import csv
import os
import pathlib
import statistics
import sys
import tempfile

from size_plot import FITTED_FROM, fitted_exponent, plot
from timed_programs import ROOT, short, spread_of


def beside(ours, other):
    """Another program's time and its ratio to ours, as two cells."""
    return f"{short(other.seconds)} | {other.seconds / ours:.2f}" if other else "- | -"


def scene_order(name):
    scene = name.split("/")[0]
    kind = scene.rstrip("0123456789")
    return kind != "human", kind, int(scene[len(kind):] or 0)


def mujoco_section(programs, _):
    """Rows of scene x quantity with both times and their ratio."""
    timings = programs.time("mujoco_bench")
    lines = ["Compared with MuJoCo on the same files in one run (`mujoco_bench`):", "",
             "| scene | of | here | MuJoCo | ratio |", "| --- | --- | ---: | ---: | ---: |"]
    names = sorted(timings, key=lambda name: (name.split("/")[1], scene_order(name)))
    for name in names:
        if name.endswith("/mujoco") or "_by_" in name:
            continue
        scene, what = name.split("/", 1)
        ours, other = timings[name].seconds, timings.get(name + "/mujoco")
        lines.append(f"| {scene} | {what.replace('_', ' ')} | {short(ours)} | {beside(ours, other)} |")
    lines += ["", "One of eight states in a batch, compared with a single state: by the processor's widest registers (AVX-512: 8 numbers, "
              "AVX2: 4), and by narrower ones of 4 and 2:", "",
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
    """Rows of scenes with loops: time within a step, with the rank decided, MuJoCo's, and its ratio to the first."""
    timings = programs.time("constraints_bench")
    lines = ["Bodies in closed loops, one evaluation, compared with MuJoCo's soft rows (`constraints_bench`):", "",
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
    """Rows of methods: motions per second on one core and on all, and their errors."""
    timings = programs.time("ensemble_bench")
    lines = ["A second of a human's free motion from a thousand starts, wall time (`ensemble_bench`). Error: the "
             "largest of a coordinate, m or rad:", "",
             "| method | one core, 1/s | all cores, 1/s | 10 000 on one core | on all | error |",
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
    lines = ["The paper's scan (`lagrange`) and the recursive equations, one evaluation of the accelerations (`equations_bench`):", "",
             "| scene | bodies | lagrange | recursive | ratio |", "| --- | ---: | ---: | ---: | ---: |"]
    for (scene, n), pair in sorted(ratios.items()):
        if "lagrange" in pair and "recursive" in pair:
            lines.append(f"| {scene.replace('_', ' ')} | {n} | {short(pair['lagrange'])} | {short(pair['recursive'])} "
                         f"| {pair['lagrange'] / pair['recursive']:.2f} |")
    nearer = {name: fitted_exponent([p for p in points if p[0] <= 1000], FITTED_FROM["bodies"])
              for name, points in shown.items()}
    fitted = ", ".join(f"{name} {e:.2f}" for name, e in sorted(nearer.items()) if e is not None)
    of_all = ", ".join(f"{name} {e:.2f}" for name, e in sorted(exponents.items()))
    far = f" From all sizes above {FITTED_FROM['bodies']}, the largest of which exceed the processor's cache: {of_all}."
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
    lines = ["Cost of recording every step, compared with recording the end alone, in alternating runs, wall time (`recording_bench`; "
             "`adds` is the median of pairs, in brackets the least and most of the runs):", "",
             "| scene | steps | the end | every step | adds |", "| --- | ---: | ---: | ---: | ---: |"]
    for name, timing in timings.items():
        adds = sorted(100 * (run["ratio"] - 1) for run in timing.all_counters)
        lines.append(f"| {name.replace('_', ' ')} | {timing.label} | {short(timing.counter('end'))} | {short(timing.counter('every_step'))} | "
                     f"{statistics.median(adds):.1f} % ({adds[0]:.1f}, {adds[-1]:.1f}) |")
    return lines if timings else []


def floor_section(programs, _):
    """One table per model, with rows of steps: times and errors of twelve falls."""
    timings = programs.time("floor_bench")
    lines = ["A human falls on the floor, 5 s without damping, from twelve heights a millimetre apart (`floor_bench`): processor "
             "time of a fall. Overlap, energy error and energy moved by separating overlaps are the worst of the twelve. Momentum is "
             "the horizontal one on a floor without friction, exactly 0 in theory."]
    model = ""
    for name, timing in timings.items():
        if name.split("/")[0] != model:
            model = name.split("/")[0]
            lines += ["", f"{model}:", "",
                      "| step | steps (rejected) | median (least, most) | real-time factor | overlap | energy error | separation "
                      "| momentum error | trusted |",
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


def peers_section(programs, _):
    """From the page of `peers`: rows of scenes with the time of the others' fastest run over ours, and the contact scenes."""
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
    lines = [f"Whole simulations compared with {', '.join(entered)} in one process (`peers`, with the methods and scenes of [its page]"
             "(peers/README.md)). Ratio of the others' fastest time to that of our fastest trusted run (medians of three), for each largest "
             "allowed error of position (over the scene's length) and orientation (rad); with contacts, of four errors. Bold: ours loses. "
             "Alone: no other run of at most 0.1 s (or the first longer one) reaches that error. -: below ten times the reference's "
             "error.", "", *page[first:end]]
    lines += ["", "The run with the smallest of the four errors, per method with contacts. Energy: largest difference from ours at the "
              "outputs, over the energy turned over. Momentum of all bodies together: largest difference from ours, over the largest "
              "momentum. Times of impacts: of balls."]
    scene = ""
    for n, line in enumerate(page):
        if line.startswith("## "):
            scene = line.removeprefix("## ")
        elif line.startswith("| method | ms | position | times of impacts"):
            lines += ["", f"{scene[0].upper()}{scene[1:]}:", "", *page[n:page.index("", n)]]
    return lines
