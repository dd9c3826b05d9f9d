#!/usr/bin/python3
"""Trains the forest that labels voxels, from scans with known parts to the model file.

Needs scikit-learn 1.2 (Debian: python3-sklearn) and the program forest_features. README.md tells how.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile
import zlib

import numpy as np
from sklearn.ensemble import ExtraTreesClassifier

CLASSES = ["head", "trunk", "upper_arm", "forearm", "hand", "thigh", "shank", "foot"]
# class of each part label of segmentation/vocabulary/parts.hpp; label 0 is outside the body
CLASS_OF_PART = np.array([-1, 0, 1, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7])
LEAF = 255


def load(folder):
    """Features (int16, n x f), classes (n), bodies (n) and the features' names of a forest_features folder."""
    folder = pathlib.Path(folder)
    features = np.load(folder / "features.npy")
    classes = CLASS_OF_PART[np.load(folder / "parts.npy").ravel()]
    bodies = np.load(folder / "bodies.npy").ravel()
    names = (folder / "names.txt").read_text().split("\n")[0].split()
    return features, classes, bodies, names


def joined(folders):
    """The tables of several folders as one."""
    tables = [load(folder) for folder in folders]
    for table in tables[1:]:
        if table[3] != tables[0][3]:
            sys.exit("the tables have different features: draw them with one version of forest_features")
    return tuple(np.concatenate([t[n] for t in tables]) for n in range(2)) + (tables[0][3],)


def shares_of(values):
    """Class frequencies of a leaf as whole 255ths that add up to 255 (largest remainders)."""
    exact = 255 * values / values.sum()
    shares = np.floor(exact).astype(int)
    for c in np.argsort(shares - exact, kind="stable")[: 255 - shares.sum()]:
        shares[c] += 1
    return shares


def export_tree(tree):
    """A tree in preorder as bytes. Rounds its leaves and thresholds in place: the model then predicts the same."""
    out = bytearray()
    waiting = [0]
    while waiting:
        n = waiting.pop()
        if tree.children_left[n] < 0:
            shares = shares_of(tree.value[n, 0])
            tree.value[n, 0] = shares / 255
            out += bytes([LEAF]) + bytes(shares.tolist())
            continue
        # features are whole numbers: x <= t as x <= floor(t)
        threshold = int(np.floor(tree.threshold[n]))
        tree.threshold[n] = threshold
        out += bytes([tree.feature[n]]) + threshold.to_bytes(2, "little", signed=True)
        waiting += [tree.children_right[n], tree.children_left[n]]
    return bytes(out)


def export(forest, names, deviations, path):
    """Writes the model file (format: segmentation/proposal/forest.hpp)."""
    data = b"".join(export_tree(e.tree_) for e in forest.estimators_)
    packed = zlib.compress(data, 9)
    header = "borelli-forest 1\n"
    header += f"features {' '.join(names)}\nclasses {' '.join(CLASSES)}\n"
    header += "".join(f"deviation {name} {value}\n" for name, value in deviations)
    header += f"trees {len(forest.estimators_)}\n"
    header += f"bytes {len(packed)} {len(data)} {zlib.crc32(data):08x}\n"
    pathlib.Path(path).write_bytes(header.encode() + packed)
    nodes = sum(e.tree_.node_count for e in forest.estimators_)
    print(f"{path}: {len(forest.estimators_)} trees, {nodes} nodes, {len(header) + len(packed)} bytes")


def report(forest, features, classes, title):
    """Prints how often the most probable class is right, by class and by probability."""
    probability = forest.predict_proba(features)
    found, most = probability.argmax(axis=1), probability.max(axis=1)
    print(f"{title}: {np.mean(found == classes):.4f} of {len(classes)} voxels right")
    for c, name in enumerate(CLASSES):
        both = 2 * np.sum((found == c) & (classes == c))
        print(f"  {name:10s} Dice {both / max(1, np.sum(found == c) + np.sum(classes == c)):.3f}")
    for low in (0.2, 0.4, 0.6, 0.8, 0.9):
        high = {0.8: 0.9, 0.9: 1.01}.get(low, low + 0.2)
        some = (most >= low) & (most < high)
        if some.any():
            print(f"  probability {low:.1f} to {min(high, 1):.1f}: {some.mean():.3f} of the voxels, "
                  f"{np.mean(found[some] == classes[some]):.3f} right")


def draw(program, out, seed, arguments):
    """Lets forest_features draw a table into a folder."""
    out.mkdir(parents=True, exist_ok=True)
    subprocess.run([program, "--out", str(out), "--seed", str(seed)] + arguments, check=True)
    return out


def is_odd(folder):
    """Whether a body's folder bears an odd number: it is for the test alone."""
    name = pathlib.Path(folder).name
    return name.isdigit() and int(name) % 2 == 1


def drawn_tables(asked, scratch):
    """Tables to train on and to test on."""
    train, test = list(asked.tables), list(asked.test_tables)
    for n, (views, samples, *folders) in enumerate(asked.draw):
        for odd, tables in ((False, train), (True, test)):
            some = [f for f in folders if is_odd(f) == odd]
            if some:
                tables.append(draw(asked.program, scratch / f"bodies{n}{odd}", asked.seed,
                                   ["--views", views, "--samples", samples] + some))
    for seed in range(asked.phantoms[0], asked.phantoms[1] + 1):
        tables = test if seed % 2 else train
        tables.append(draw(asked.program, scratch / f"phantom{seed}", asked.seed,
                           ["--views", "4", "--samples", "3000", "--phantoms", str(seed), str(seed)]))
    return train, test


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", required=True, help="the model file")
    parser.add_argument("--program", default="build/release/forest_features")
    parser.add_argument("--draw", nargs="+", action="append", default=[], metavar="WORD",
                        help="VIEWS SAMPLES FOLDER...: bodies (folders that hold scan.nii.gz, parts.nii.gz), views of each, "
                             "voxels of each view")
    parser.add_argument("--phantoms", nargs=2, type=int, default=[1, 0], metavar=("FIRST", "LAST"))
    parser.add_argument("--tables", nargs="*", default=[], help="folders of forest_features, drawn before")
    parser.add_argument("--test-tables", nargs="*", default=[])
    parser.add_argument("--trees", type=int, default=16)
    parser.add_argument("--features", type=float, default=0.3, help="share of the features tried at a branch")
    parser.add_argument("--leaf", type=int, default=30, help="least voxels in a leaf")
    parser.add_argument("--deviations", nargs="*", default=[], metavar="JOINT=MM")
    parser.add_argument("--samples-out", help="writes 120 rows and the forest's probabilities, for the test")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()

    with tempfile.TemporaryDirectory() as scratch:
        train, test = drawn_tables(asked, pathlib.Path(scratch))
        features, classes, names = joined(train)
        tested = joined(test) if test else None
    forest = ExtraTreesClassifier(n_estimators=asked.trees, min_samples_leaf=asked.leaf, max_features=asked.features,
                                  random_state=asked.seed, n_jobs=2)
    # all classes are there for the forest's columns to be CLASSES
    if set(classes) != set(range(len(CLASSES))):
        sys.exit("the training bodies lack a class: give whole bodies")
    forest.fit(features, classes)
    deviations = [d.split("=") for d in asked.deviations]
    export(forest, names, deviations, asked.out)
    report(forest, features, classes, "trained on")
    if tested:
        report(forest, tested[0], tested[1], "unseen")
    if asked.samples_out:
        rows = np.random.default_rng(asked.seed).choice(len(features), 120, replace=False)
        write_samples(asked.samples_out, features[rows], forest.predict_proba(features[rows]))


def write_samples(path, features, probability):
    """A line per row: its features, then the probabilities that scikit-learn gives."""
    with open(path, "w") as out:
        for row, shares in zip(features, probability):
            out.write(" ".join(map(str, row)) + " " + " ".join(f"{p:.9f}" for p in shares) + "\n")


if __name__ == "__main__":
    main()
