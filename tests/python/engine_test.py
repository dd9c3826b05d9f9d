"""Scenes, equations, batches and motions equal the program's bit for bit; views, errors, threads."""
import gc
import json
import os
import pathlib
import signal
import tempfile
import threading
import time
import unittest
import warnings

import borelli
import numpy as np
import program

SCENES = ["double_pendulum", "four_bar_2", "heavy_top", "andrews"]


def address(array):
    return array.__array_interface__["data"][0]


def scene_of(name):
    return borelli.read_model(program.samples / f"{name}.toml")


class Program(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def state_file(self, state):
        path = self.folder / "state.json"
        path.write_text(json.dumps({"t": state.t, "q": state.q.tolist(), "v": state.v.tolist()}))
        return path

    def moved(self, system):
        """A state away from the start; balls change only their velocities, because quaternions have unit length."""
        state = system.state()
        for coordinate in system.coordinates:
            if coordinate["q_size"] == 1:
                state.q[coordinate["q_index"]] += 0.1
        state.v[:] = np.linspace(-1, 1, system.n_v)
        return system.assemble(state)

    def test_evaluate_equals_the_programs(self):
        for name in SCENES:
            with self.subTest(name):
                system = borelli.System(scene_of(name))
                state = self.moved(system)
                theirs = program.answer("evaluate", program.samples / f"{name}.toml", "--derivatives", "--state",
                                        self.state_file(state))
                ours = system.evaluate(state)
                # these scenes list solids in tree order, so both orders of coordinates agree
                self.assertEqual(theirs["coordinates"], ours.names)
                for entry, key in [("acceleration",) * 2, ("mass_matrix",) * 2, ("bias",) * 2, ("multipliers",) * 2,
                                   ("generalized_efforts",) * 2, ("constraint_jacobian",) * 2,
                                   ("constraint_bias",) * 2, ("constraint_position",) * 2, ("constraint_rate",) * 2,
                                   ("gravity_centre",) * 2, ("angular_momentum",) * 2]:
                    if key in theirs:
                        np.testing.assert_array_equal(getattr(ours, entry), theirs[key], entry)
                self.assertEqual((ours.kinetic_energy, ours.potential_energy), system.energy(state))
                self.assertEqual(theirs["kinetic_energy"], ours.kinetic_energy)
                np.testing.assert_array_equal(system.accelerations(state), theirs["acceleration"])
                derivatives = system.derivatives(state)
                for key in ["acceleration_by_q", "acceleration_by_v", "acceleration_by_efforts"]:
                    np.testing.assert_array_equal(getattr(derivatives, key), theirs["derivatives"][key], key)

    def test_motion_equals_the_programs(self):
        for name in SCENES:
            with self.subTest(name):
                path = self.folder / f"{name}.csv"
                program.run("simulate", program.samples / f"{name}.toml", "--end", 0.5, "--method", "dopri5",
                            "--tolerance", 1e-7, "-o", path, "--allow-untrusted")
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", borelli.DoubtWarning)
                    motion = borelli.simulate(scene_of(name), duration=0.5, method="dopri5", tolerance=1e-7)
                motion.write(self.folder / "ours.csv")
                self.assertEqual(path.read_text(), (self.folder / "ours.csv").read_text())
                rows = path.read_text().splitlines()
                table = np.array([[float(x) for x in row.split(",")] for row in rows[1:]])
                np.testing.assert_array_equal(table[:, 0], motion.times)
                np.testing.assert_array_equal(table[:, 1:1 + motion.q.shape[1]], motion.q)

    def test_foreign_models_equal_the_programs(self):
        path = program.samples / "double_pendulum.toml"
        scene = borelli.read_model(path)
        for ending, text in [("mjcf", scene.to_mjcf()), ("osim", scene.to_osim()), ("urdf", scene.to_urdf())]:
            program.run("convert", path, "-o", self.folder / f"theirs.{ending}")
            (self.folder / f"ours.{ending}").write_text(text)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", borelli.DoubtWarning)
                ours, theirs = (borelli.read_model(self.folder / f"{whose}.{ending}") for whose in ["ours", "theirs"])
            # the texts differ by the program's comment on its input
            self.assertEqual(ours.to_toml(), theirs.to_toml(), ending)
            self.assertEqual(borelli.System(ours).n_v, 2)

    def test_trajectory_files_are_read_back(self):
        motion = borelli.simulate(scene_of("heavy_top"), duration=0.1)
        motion.write(self.folder / "top.h5")
        again = borelli.read_trajectory(self.folder / "top.h5")
        np.testing.assert_array_equal(again.q, motion.q)
        self.assertEqual(again.certificate["energy_drift"], motion.certificate["energy_drift"])
        self.assertIn("<iframe", again._repr_html_())


class Equations(unittest.TestCase):
    def setUp(self):
        self.system = borelli.System(scene_of("double_pendulum"))

    def test_inverse_dynamics_undoes_accelerations(self):
        state = self.system.state(q=[0.3, -0.4], v=[1, 2])
        wanted = np.array([0.7, -3])
        held = self.system.inverse_dynamics(state, wanted)
        # rounding, relative to the largest acceleration
        np.testing.assert_allclose(self.system.accelerations(state, held), wanted, rtol=0, atol=3 * 1e-13)
        np.testing.assert_array_equal(self.system.inverse_dynamics_derivatives(state, wanted).efforts, held)

    def test_poses_are_the_pendulums(self):
        a, b = 0.3, -0.4
        R, p = self.system.poses(self.system.state(q=[a, b]))
        upper = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
        lower = np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
        np.testing.assert_allclose(R, [upper, upper @ lower], rtol=0, atol=1e-15)
        np.testing.assert_allclose(p, [[0, 0, 0], upper @ [0, 0, -1]], rtol=0, atol=1e-15)

    def test_batches_equal_single_states(self):
        for name in ["double_pendulum", "heavy_top", "four_bar_2"]:
            system = borelli.System(scene_of(name))
            count = 19  # not a multiple of the eight lanes
            start = system.assemble(system.state())
            q = np.tile(start.q, (count, 1))
            v = start.v + 0.01 * np.arange(count)[:, np.newaxis] * np.ones(system.n_v)
            efforts = np.outer(np.arange(count), np.ones(system.n_v))
            together = borelli.accelerations(system, q, v, efforts=efforts)
            for n in range(count):
                alone = system.accelerations(system.state(q[n], v[n]), efforts[n])
                # lanes differ from single states by rounding
                np.testing.assert_allclose(together[n], alone, rtol=0, atol=1e-12 * max(1, abs(alone).max()))
            if not system.rows:
                a = np.cos(np.arange(count * system.n_v)).reshape(count, -1)
                needed = borelli.inverse_dynamics(system, q, v, a)
                for n in range(count):
                    alone = system.inverse_dynamics(system.state(q[n], v[n]), a[n])
                    np.testing.assert_allclose(needed[n], alone, rtol=0, atol=1e-12 * max(1, abs(alone).max()))

    def test_an_ensemble_ends_where_single_motions_do(self):
        q = [[0.5, 0.1], [1.0, 0.7], [1.5, -0.3]]
        ends = borelli.simulate_ensemble(self.system, q=q, duration=1, method="dop853", tolerance=1e-11)
        self.assertTrue(ends.trusted.all())
        for n, start in enumerate(q):
            alone = borelli.simulate(self.system, state=self.system.state(start, [0, 0]), duration=1, accuracy=1e-9)
            np.testing.assert_allclose(ends.q[n], alone.q[-1], rtol=0, atol=2e-9)  # the accuracy asked for


class Views(unittest.TestCase):
    def test_a_states_arrays_are_the_state(self):
        system = borelli.System(scene_of("double_pendulum"))
        state = system.state()
        q = state.q
        self.assertEqual(address(q), address(state.q))
        q[0] = 0.25
        state.v = [3, 4]
        self.assertEqual(state.q[0], 0.25)
        np.testing.assert_array_equal(system.evaluate(system.state(q, state.v)).acceleration,
                                      system.evaluate(state).acceleration)
        self.assertIs(q.base, state)
        other = state.copy()
        self.assertNotEqual(address(other.q), address(q))

    def test_a_views_memory_outlives_its_owner(self):
        system = borelli.System(scene_of("double_pendulum"))
        motion = borelli.simulate(system, duration=0.2)
        q, positions, kept = motion.q, motion.positions, motion.q.copy()
        self.assertEqual(address(q), address(motion.q))
        self.assertEqual(address(motion.rotations) + 9 * 8, address(positions))
        self.assertFalse(q.flags.writeable)
        del motion
        gc.collect()
        borelli.simulate(system, duration=0.2)
        np.testing.assert_array_equal(q, kept)

    def test_positions_and_rotations_are_the_systems(self):
        system = borelli.System(scene_of("heavy_top"))
        motion = borelli.simulate(system, duration=0.2, output_interval=0.1)
        R, p = system.poses(system.state(q=motion.q[-1]))
        np.testing.assert_allclose(motion.rotations[-1], R, rtol=0, atol=1e-15)
        np.testing.assert_allclose(motion.positions[-1], p, rtol=0, atol=1e-15)


class Refusals(unittest.TestCase):
    def test_errors_carry_the_programs_sentence(self):
        with self.assertRaises(borelli.Error) as raised:
            borelli.Scene.from_toml("""
                [[solid]]
                name = "a"
                parent = "b"
                mass = 1
                centre = [0, 0, 0]
                tensor = [1, 1, 1]""", "made.toml")
        self.assertTrue(str(raised.exception).startswith("made.toml:"), raised.exception)
        self.assertIn("'b'", str(raised.exception))
        with self.assertRaises(borelli.Error) as raised:
            borelli.read_model("no_such_file.toml")
        self.assertEqual(raised.exception.kind, "use")
        self.assertIn("no_such_file.toml", raised.exception.where)

    def test_wrong_arguments_are_named(self):
        scene = scene_of("double_pendulum")
        system = borelli.System(scene)
        for words, act in [("q: has the shape (3); expected (2)", lambda: system.state(q=[1, 2, 3])),
                           ("q: is not an array of numbers", lambda: system.state(q=["a", "b"])),
                           ("efforts: has the shape (1)", lambda: system.evaluate(system.state(), [1])),
                           ("duration", lambda: borelli.simulate(scene, durations=1)),
                           ("rk4, whose steps have a fixed length",
                            lambda: borelli.simulate(scene, method="rk4", tolerance=1e-3)),
                           ("contain 'no'; known: euler", lambda: borelli.chart(scene, methods=["no"])),
                           ("projection or baumgarte", lambda: borelli.simulate(scene, constraints="none")),
                           ("is not a finite number", lambda: system.evaluate(system.state(q=[np.nan, 0]))),
                           ("duration: is not a number", lambda: borelli.simulate(scene, duration="1")),
                           ("a: contains a number that is not finite",
                            lambda: borelli.inverse_dynamics(system, [[0, 0]], [[0, 0]], [[np.nan, 0]])),
                           ("v: does not have the shape (2, 2)",
                            lambda: borelli.accelerations(system, [[0, 0], [0, 0]], [[0, 0]]))]:
            with self.assertRaises(borelli.Error) as raised:
                act()
            self.assertIn(words, str(raised.exception))
        with self.assertRaises(TypeError):
            borelli.System(None)

    def test_objects_of_another_kind_are_type_errors(self):
        scene = scene_of("double_pendulum")
        for expected, act in [("a borelli.Scene", lambda: borelli.simulate("double_pendulum.toml")),
                              ("a borelli.State", lambda: borelli.simulate(scene, state=[0, 0]))]:
            with self.assertRaisesRegex(TypeError, expected):
                act()

    def test_an_untrusted_motion_is_a_warning(self):
        with self.assertWarnsRegex(borelli.DoubtWarning, "does not trust"):
            motion = borelli.simulate(scene_of("double_pendulum"), method="euler", step=0.05, duration=5)
        self.assertFalse(motion.trusted)


class Threads(unittest.TestCase):
    def setUp(self):
        self.system = borelli.System(scene_of("double_pendulum"))

    def test_another_thread_runs_during_a_simulation(self):
        ticks, done = [], threading.Event()

        def tick():
            while not done.is_set():
                ticks.append(time.perf_counter())
                time.sleep(0.001)

        thread = threading.Thread(target=tick)
        thread.start()
        began = time.perf_counter()
        borelli.simulate(self.system, method="rk4", step=1e-5, duration=1, output_interval=1)
        ended = time.perf_counter()
        done.set()
        thread.join()
        during = [t for t in ticks if began + 0.01 < t < ended - 0.01]
        # if the lock were held, it could run only every 50 ms, when signals are checked
        self.assertGreater(len(during), (ended - began) / 0.05 + 3)

    def test_a_callback_sees_each_step_and_stops_the_run(self):
        times = []

        def callback(t):
            times.append(t)
            return len(times) < 5

        with self.assertWarns(borelli.DoubtWarning):
            motion = borelli.simulate(self.system, method="rk4", step=0.01, duration=1, callback=callback)
        self.assertEqual(len(times), 5)
        np.testing.assert_allclose(motion.times[-1], times[-1])
        self.assertLess(motion.times[-1], 0.1)

    def test_what_a_callback_raises_comes_out(self):
        with self.assertRaisesRegex(ZeroDivisionError, "by zero"):
            borelli.simulate(self.system, duration=1, callback=lambda t: 1 // 0)
        with self.assertRaises(ZeroDivisionError):
            borelli.simulate_ensemble(self.system, q=[[0, 0]], duration=1, method="rk4", step=1e-3,
                                      callback=lambda made: 1 // 0)
        with self.assertRaises(ZeroDivisionError):
            borelli.chart(scene_of("double_pendulum"), methods=["rk4"], callback=lambda share, what: 1 // 0)

    def test_control_c_stops_a_run(self):
        signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
        threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            borelli.simulate(self.system, method="rk4", step=1e-7, duration=100, output_interval=100)


if __name__ == "__main__":
    unittest.main()
