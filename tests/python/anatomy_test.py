"""Volume, segmentation, table and skeleton of the sample body equal the program's bit for bit; views; pandas."""
import gc
import json
import pathlib
import tempfile
import unittest
import warnings

import borelli
import numpy as np
import program


def address(array):
    return array.__array_interface__["data"][0]


class Body(unittest.TestCase):
    """A small sample body at 8 mm, to save time, segmented once by the program and once here."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.scan = cls.folder / "body.nii.gz"
        program.run("phantom", "-o", cls.scan, "--spacing", 8, "--stature", 1.5)
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            cls.volume = borelli.read_volume(cls.scan)
            cls.found = borelli.segment(cls.volume, step=6)
        cls.told = [str(w.message) for w in told]
        cls.parts = cls.folder / "parts"
        cls.account = program.answer("segment", cls.scan, "-o", cls.parts, "--work-grid", 6)

    def test_phantom_equals_the_programs(self):
        body = borelli.phantom(spacing=8, stature=1.5)
        np.testing.assert_array_equal(body.volume.voxels, self.volume.voxels)
        exact = borelli.read_table(self.folder / "body_table.json")
        for key in ["parts", "body"]:
            self.assertEqual(json.loads(body.table.to_json())[key], json.loads(exact.to_json())[key])
        labels = borelli.read_labels(self.folder / "body_labels.nii.gz")
        np.testing.assert_array_equal(body.labels.voxels, labels.voxels)
        self.assertEqual(body.labels.names, labels.names)

    def test_segmentation_equals_the_programs(self):
        labels = borelli.read_labels(self.parts / "labels.nii.gz")
        np.testing.assert_array_equal(self.found.labels.voxels, labels.voxels)
        theirs = json.loads((self.parts / "landmarks.json").read_text())["landmarks"]
        self.assertEqual(sorted(theirs), sorted(self.found.landmarks))
        for name, landmark in self.found.landmarks.items():
            self.assertEqual(theirs[name]["point"], landmark.point.tolist(), name)
            self.assertEqual(theirs[name]["deviation"], landmark.deviation, name)
        self.assertEqual(self.account["verdict"], self.found.verdict)
        self.assertEqual(self.account["warnings"], self.found.warnings)
        for sentence in self.found.warnings:
            self.assertIn(sentence, self.told)

    def test_table_equals_the_programs(self):
        path = self.folder / "table.json"
        program.run("inertia", "--volume", self.scan, "--labels", self.parts / "labels.nii.gz",
                    "--landmarks", self.parts / "landmarks.json", "--findings",
                    self.parts / "segmentation.json", "--sex", "male", "-o", path)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", borelli.DoubtWarning)
            table = borelli.inertia(self.volume, self.found, sex="male")
            skeleton = borelli.skeleton(table, self.found.landmarks)
        theirs, ours = json.loads(path.read_text()), json.loads(table.to_json())
        for key in theirs:
            if key != "warnings":
                self.assertEqual(theirs[key], ours[key], key)
        program.run("skeleton", path, "--landmarks", self.parts / "landmarks.json", "-o",
                    self.folder / "scene.toml")
        self.assertEqual((self.folder / "scene.toml").read_text(), skeleton.to_toml())

    def test_pandas_holds_every_entry_and_its_deviation(self):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", borelli.DoubtWarning)
            table = borelli.inertia(self.volume, self.found)
        frame = table.to_pandas()
        self.assertEqual(list(frame.index), [row.part for row in table.rows])
        row = table["thigh_left"]
        self.assertEqual(frame.loc["thigh_left", "mass_kg"], row.mass)
        self.assertEqual(frame.loc["thigh_left", "mass_kg_sd"], row.deviations["mass_kg"])
        self.assertEqual(frame.loc["thigh_left", "patient_Ixy_kgm2"], row.tensor[0, 1])
        self.assertGreater(frame.loc["body", "mass_kg_sd"], 0)
        parts = [r.mass for r in table.rows if r.part != "body"]
        self.assertAlmostEqual(frame.loc["body", "mass_kg"], sum(parts), 9)
        self.assertIn(f"{row.mass:.3f} ± ", table._repr_html_())
        self.assertIn("thigh_left", self.found._repr_html_())
        self.assertEqual(self.found.to_pandas().loc["head", "coverage"], "whole")
        with self.assertRaises(KeyError):
            table["tail"]

    def test_voxels_are_the_volumes(self):
        body = borelli.phantom(spacing=20)
        voxels = body.volume.voxels
        self.assertEqual(address(voxels), address(body.volume.voxels))
        self.assertTrue(voxels.flags.f_contiguous)
        voxels[0, 0, 0] = 77
        self.assertEqual(body.volume.voxels[0, 0, 0], 77)
        labels, kept = body.labels.voxels, body.labels.voxels.copy()
        del body
        gc.collect()
        borelli.phantom(spacing=20)
        np.testing.assert_array_equal(labels, kept)
        found_labels = self.found.labels.voxels
        self.assertEqual(address(found_labels), address(self.found.labels.voxels))

    def test_a_volume_from_an_array_is_the_same_volume(self):
        again = borelli.Volume(self.volume.voxels.astype(float), self.volume.axes, self.volume.origin)
        np.testing.assert_array_equal(again.voxels, self.volume.voxels)
        again.write(self.folder / "again.nrrd")  # NRRD holds the grid at full precision
        back = borelli.read_volume(self.folder / "again.nrrd")
        for volume in [again, back]:
            np.testing.assert_array_equal(volume.axes, self.volume.axes)
            np.testing.assert_array_equal(volume.origin, self.volume.origin)
            self.assertEqual((volume.quantity, volume.shape), (self.volume.quantity, self.volume.shape))
        np.testing.assert_array_equal(back.voxels, self.volume.voxels)
        with self.assertRaisesRegex(borelli.Error, "they must fit -32768 to 32767"):
            borelli.Volume(np.full((2, 2, 2), 1e6), [1, 1, 1])
        for kind in [object, complex]:
            with self.assertRaisesRegex(borelli.Error, "are not real numbers"):
                borelli.Labels(np.ones((2, 2, 2)).astype(kind), [1, 1, 1])
        with self.assertRaisesRegex(borelli.Error, "are not whole numbers"):
            borelli.Labels(np.full((2, 2, 2), 1.5), [1, 1, 1])
        with self.assertRaisesRegex(borelli.Error, "origin: is not finite"):
            borelli.Volume(np.zeros((2, 2, 2)), [1, 1, 1], origin=[np.nan, 0, 0])
        with self.assertRaises(TypeError):
            borelli.skeleton(None, {})
        with self.assertRaisesRegex(borelli.Error, "hip: is not finite"):
            borelli.write_landmarks("not_written.json", {"hip": [np.nan, 0, 0]})
        with self.assertRaisesRegex(borelli.Error, "which has no name"):
            borelli.Labels(np.full((2, 2, 2), 200), [1, 1, 1])

    def test_given_labels_and_landmarks_are_taken(self):
        body = borelli.phantom(spacing=8, stature=1.5)
        table = borelli.inertia(body.volume, body.labels, landmarks=body.landmarks, sampling="points")
        exact = body.table["body"].mass
        # drawn voxels of 8 mm: the sum over voxel centres errs by less than a percent of the body
        self.assertAlmostEqual(table["body"].mass / exact, 1, delta=0.01)
        points = {name: landmark.point for name, landmark in body.landmarks.items()}
        other = borelli.inertia(body.volume, body.labels, landmarks=points, sampling="points")
        self.assertEqual(other["thigh_left"].entries["length_m"], table["thigh_left"].entries["length_m"])

    def test_progress_is_told_and_stops_the_work(self):
        steps = []
        with self.assertRaisesRegex(borelli.Error, "stopped by its callback"):
            borelli.segment(self.volume, callback=lambda share, step: bool(steps.append((share, step))))
        self.assertEqual(steps, [(0.0, "finding body and bones")])
        with self.assertRaises(ZeroDivisionError):
            borelli.segment(self.volume, callback=lambda share, step: 1 // 0)

    def test_errors_name_the_file(self):
        bad = self.folder / "bad.nii"
        bad.write_bytes(b"nothing")
        for path in [bad, self.folder / "none.nii"]:
            with self.assertRaises(borelli.Error) as raised:
                borelli.read_volume(path)
            self.assertIn(path.name, str(raised.exception))


if __name__ == "__main__":
    unittest.main()
