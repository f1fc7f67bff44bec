#!/usr/bin/python3
"""Scenes in time: closed forms of free fall and of a mode that swings, orders, momenta, energies, ranks,
what is held and moved, and what is refused."""
import csv
import math
import os
import tempfile
import unittest

from trefoil_program import record_of, run

TIGHT = ["-snes_trefoil_energy_tolerance", "1e-26", "-time_velocity_tolerance", "1e-13",
         "-snes_trefoil_monitor", "false", "-snes_max_it", "30"]
BOX = ["-mesh_generate", "box", "-mesh_resolution", "2", "-material_density", "1e3"]
SOFT = ["-material_young", "2e4", "-material_poisson", "0.3"]
GRAVITY = ["-load_gravity", "0, 0, -9.81"]
HELD = ["-constraints", "wall", "-constraint_wall_where", "x == xmin"]
INTEGRATORS = ("backward_euler", "bdf2", "newmark")


def steps_of(options, ranks=1):
    record = record_of([*options, *TIGHT], ranks)
    if record["status"] != 0:
        raise AssertionError(record["printed"])
    return record["steps"]


def timed(end, step, *more):
    return ["-time_end", str(end), "-time_step", str(step), *more]


def fall(integrator, lengths, gravity):
    """The scalar recursion of each scheme, from rest: displacement and velocity."""
    u, v, before = 0.0, 0.0, None
    for k, dt in enumerate(lengths):
        if integrator == "newmark":
            u, v = u + dt * v + dt * dt / 2 * gravity, v + dt * gravity
        else:
            r = dt / lengths[k - 1] if integrator == "bdf2" and k else 0
            now, past = (1 + r) ** 2 / (1 + 2 * r), r * r / (1 + 2 * r)
            c = dt * (1 + r) / (1 + 2 * r)
            old = before or (0, 0)
            before = (u, v)
            v = now * v - past * old[1] + c * gravity
            u = now * u - past * old[0] + c * v
    return u, v


class FreeFall(unittest.TestCase):
    def test_each_scheme(self):
        for integrator in INTEGRATORS:
            for more in ([], ["-order", "2"], ["-time_mass", "lumped"],
                         ["-mesh_generate", "square"]):
                plane = "square" in more
                gravity = ["-load_gravity", "0, -9.81"] if plane else GRAVITY
                axis = 1 if plane else 2
                last = steps_of([*BOX, *SOFT, *gravity, *timed(0.55, 0.1, "-time_integrator",
                                                              integrator), *more])[-1]
                u, v = fall(integrator, [0.1] * 5 + [0.05], -9.81)
                self.assertAlmostEqual(last["t"], 0.55, delta=1e-15)
                self.assertAlmostEqual(last["largest_displacement"]["value"], abs(u), delta=1e-12)
                self.assertAlmostEqual(last["momentum"][axis], 1e3 * v, delta=1e-9)
                self.assertAlmostEqual(last["kinetic_energy"], 500 * v * v, delta=1e-8)
                self.assertLess(last["strain_energy"], 1e-9)

    def test_backward_euler_in_closed_form(self):
        steps = steps_of([*BOX, *GRAVITY, *timed(0.5, 0.05, "-initial_velocity", "1, 0, 0")])
        for n, step in enumerate(steps):
            self.assertAlmostEqual(step["momentum"][0], 1e3, delta=1e-9)
            self.assertAlmostEqual(step["momentum"][2], -9.81e3 * n * 0.05, delta=1e-9)
            place = math.hypot(n * 0.05, 9.81 * 0.05 ** 2 * n * (n + 1) / 2)
            self.assertAlmostEqual(step["largest_displacement"]["value"], place, delta=1e-12)

    def test_momentum_of_a_free_body(self):
        """Thrown, turning and swinging: 1e-12 m v in each step."""
        for integrator in INTEGRATORS:
            steps = steps_of([*BOX, *SOFT, *timed(0.4, 0.02, "-time_integrator", integrator,
                                                  "-initial_velocity",
                                                  "1 - 3*y, 3*(x - 0.5) + z, 2 + x*x")])
            size = math.hypot(*steps[0]["momentum"])
            self.assertGreater(steps[-1]["strain_energy"], 1)
            for one, other in zip(steps, steps[1:]):
                self.assertLess(math.dist(one["momentum"], other["momentum"]), 1e-12 * size)


class Schemes(unittest.TestCase):
    def end(self, integrator, step, more=()):
        return steps_of([*BOX, *SOFT, *HELD, *GRAVITY, "-probes", "tip", "-probe_tip",
                         "1, 1, 1",
                         *timed(0.24, step, "-time_integrator", integrator), *more])[-1]

    def test_orders(self):
        """The tip of a block that begins to swing: orders 1, 2, 2."""
        exact = self.end("newmark", 0.00125)["probes"]["tip"]
        for integrator, order in (("backward_euler", 1), ("bdf2", 2), ("newmark", 2)):
            errors = [math.dist(self.end(integrator, step)["probes"]["tip"], exact)
                      for step in (0.02, 0.01)]
            self.assertGreater(math.log2(errors[0] / errors[1]), order - 0.2, (integrator, errors))
            self.assertLess(math.log2(errors[0] / errors[1]), order + 0.5, (integrator, errors))

    def test_energy_inequality(self):
        """Backward Euler: Psi + |v' - v|_M^2 / 2 <= Psi + |v|_M^2 / 2 before; Psi and T fall."""
        steps = steps_of([*BOX, *SOFT, *HELD, *GRAVITY, *timed(1, 0.05)])
        for one, other in zip(steps, steps[1:]):
            gain = other["strain_energy"] - other["load_work"] - (one["strain_energy"]
                                                                  - one["load_work"])
            # |v' - v|_M >= | |v'|_M - |v|_M |
            least = (math.sqrt(other["kinetic_energy"]) - math.sqrt(one["kinetic_energy"])) ** 2
            self.assertLessEqual(gain + least, one["kinetic_energy"] + 1e-9)

    def test_damping_has_its_log_decrement(self):
        """A bar's first longitudinal mode, zeta = alpha / (2 omega) + beta omega / 2. Newmark's scheme
        has no damping of its own."""
        omega = math.pi / 2 * math.sqrt(1e4 / 1e3)  # fixed and free ends, length 1, nu = 0
        scene = ["-mesh_generate", "box", "-mesh_resolution", "4", "-material_density", "1e3",
                 "-material_young", "1e4", "-material_poisson", "0", *HELD, "-probes", "tip",
                 "-probe_tip", "1, 0.5, 0.5", "-initial_velocity", "1e-3*sin(pi/2*x), 0, 0"]
        dt = 0.02
        for alpha, beta in ((0.5, 0), (0, 0.02), (0.5, 0.02)):
            zeta = alpha / (2 * omega) + beta * omega / 2
            steps = steps_of([*scene, *timed(2.6, dt, "-time_integrator", "newmark",
                                             "-time_damping_mass", str(alpha),
                                             "-time_damping_stiffness", str(beta))])
            u = [step["probes"]["tip"][0] for step in steps]
            peaks = []  # of the parabolas through three values
            for low, at, high in zip(u, u[1:], u[2:]):
                if abs(at) >= max(abs(low), abs(high)):
                    peaks.append(abs(at - (high - low) ** 2 / (8 * (high - 2 * at + low))))
            decrement = math.log(peaks[0] / peaks[2])  # of a whole period
            self.assertAlmostEqual(decrement / math.hypot(2 * math.pi, decrement), zeta,
                                   delta=0.02 * zeta, msg=f"alpha {alpha}, beta {beta}")

    def test_ranks_agree(self):
        """Over 50 steps, to 1e-9."""
        scene = [*BOX, *SOFT, *HELD, *GRAVITY, *timed(0.5, 0.01, "-time_integrator", "bdf2"),
                 "-constraint_wall_move", "0.1*sin(8*t), 0, 0", "-probes", "tip",
                 "-probe_tip", "1, 1, 1"]
        one = steps_of(scene)
        self.assertEqual(len(one), 51)
        for ranks in (2, 4):
            for step, other in zip(one, steps_of(scene, ranks)):
                self.assertLess(math.dist(step["probes"]["tip"], other["probes"]["tip"]), 1e-9)
                self.assertLess(math.dist(step["momentum"], other["momentum"]), 1e-6)
                for name in ("kinetic_energy", "strain_energy", "load_work"):
                    self.assertAlmostEqual(step[name], other[name], delta=1e-9)


class HeldParts(unittest.TestCase):
    def test_a_body_that_is_carried(self):
        """All of its ends follow an accelerated frame: without stiffness against it the body keeps
        up, and the reactions accelerate its mass."""
        both = ["-constraints", "all", "-constraint_all_where", "x <= xmin || x >= xmax"]
        steps = steps_of([*BOX, *timed(1, 0.1), *both, "-material_young", "1e9",
                          "-constraint_all_move", "2*t*t, 0, 0"])
        for step in steps[2:]:  # the first knows no velocity but that of the start
            self.assertAlmostEqual(step["reaction"]["all"][0], 4e3, delta=1)

    def test_reactions_are_balance_of_momentum(self):
        """Backward Euler: what holds and pulls is the change of momentum of what is free and the
        acceleration of what is held."""
        steps = steps_of([*BOX, *SOFT, *HELD, *GRAVITY, *timed(0.3, 0.02)])
        for one, other in zip(steps, steps[1:]):
            change = [(b - a) / 0.02 for a, b in zip(one["momentum"], other["momentum"])]
            force = [sum(part[i] for part in (*other["reaction"].values(), *other["load"].values()))
                     for i in range(3)]
            self.assertLess(math.dist(change, force), 1e-6 * 9810)

    def test_nothing_is_scaled_by_t(self):
        steps = steps_of([*BOX, *GRAVITY, *HELD, *timed(0.2, 0.1, ), "-loads", "top",
                          "-load_top_where", "z == zmax", "-load_top_force", "0, 0, 7*t"])
        for step in steps:
            self.assertAlmostEqual(step["load"]["gravity"][2], -9810, delta=1e-8)
            self.assertAlmostEqual(step["load"]["top"][2], 7 * step["t"], delta=1e-12)

    def test_a_move_without_t_jumps_and_is_said(self):
        record = record_of([*BOX, *HELD, "-constraint_wall_move", "0.1, 0, 0", *timed(0.1, 0.05)])
        self.assertEqual(record["status"], 0, record["printed"])
        self.assertIn("constraint 'wall' has moved its vertices at t = 0 already, by up to 0.1",
                      record["printed"])
        self.assertTrue(any("jump" in warning for warning in record["result"]["warnings"]))

    def test_regions_have_densities(self):
        steps = steps_of([*BOX, *GRAVITY, *timed(0.1, 0.1), "-regions", "heavy",
                          "-region_heavy_where", "z < 0.5", "-region_heavy_material_density",
                          "3e3"])
        self.assertAlmostEqual(steps[-1]["momentum"][2], -0.981 * 2e3, delta=1e-9)


class Steps(unittest.TestCase):
    def test_a_step_that_fails_is_halved_and_grows_again(self):
        record = record_of([*BOX, *SOFT, *HELD, *timed(0.6, 0.2), "-constraint_wall_move",
                            "2*min(t, 0.2), 0, 0", "-snes_max_it", "3", "-material_poisson", "0.45",
                            "-initial_velocity", "0, 9*x, 0",
                            "-snes_trefoil_filter", "on_demand"])
        self.assertEqual(record["status"], 0, record["printed"])
        lengths = [step["dt"] for step in record["steps"][1:]]
        self.assertEqual(lengths[:3], [0.05, 0.05, 0.0625])
        self.assertGreater(max(lengths), 0.1)
        self.assertAlmostEqual(sum(lengths), 0.6, delta=1e-12)
        self.assertEqual(record["steps"][-1]["t"], 0.6)
        self.assertIn("is halved", record["printed"])
        self.assertTrue(any(entry.get("rejected") for entry in record["history"]))

    def test_a_step_that_fails_at_the_shortest(self):
        with tempfile.TemporaryDirectory() as folder:
            result = run([*BOX, *SOFT, *HELD, *timed(0.4, 0.1, "-time_step_min", "0.1"),
                          "-initial_velocity", "0, 400*x*t, 30*x*x", "-output_file", "a.xdmf",
                          "-output_every", "3", "-snes_max_it", "1"], folder=folder)
            self.assertEqual(result.returncode, 3, result.stdout)
            self.assertIn("-time_step_min 0.1 allows none of half its length", result.stdout)
            with open(os.path.join(folder, "a.xdmf"), encoding="utf-8") as file:
                self.assertEqual(file.read().count("<Time"), 1)

    def test_table_and_every_so_many_states(self):
        with tempfile.TemporaryDirectory() as folder:
            result = run([*BOX, *GRAVITY, *timed(0.5, 0.1), "-output_file", "a.xdmf",
                          "-output_every", "3", "-output_csv", "a.csv"], folder=folder)
            self.assertEqual(result.returncode, 0, result.stdout)
            with open(os.path.join(folder, "a.csv"), encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
            with open(os.path.join(folder, "a.xdmf"), encoding="utf-8") as file:
                text = file.read()
        self.assertEqual([round(float(row["t"]), 12) for row in rows],
                         [0, 0.1, 0.2, 0.3, 0.4, 0.5])
        self.assertEqual([float(row["dt"]) for row in rows], [0] + [0.1] * 5)
        self.assertAlmostEqual(float(rows[-1]["momentum_z"]), -4905, delta=1e-8)
        times = [float(part.split('"')[0]) for part in text.split('<Time Value="')[1:]]
        self.assertEqual([round(t, 12) for t in times], [0, 0.3, 0.5])

    def test_the_velocity_tolerance_has_two_units(self):
        """Box diagonals per time, or the mesh's length per time: the same where they say the same, and
        one line says which, and how much."""
        def iterations(*tolerance):
            scene = [*BOX, "-snes_trefoil_energy_tolerance", "1e-26", *HELD, "-initial_velocity", "0, 0, 3*x"]
            record = record_of([*scene, *timed(0.1, 0.02), *SOFT, *tolerance])
            self.assertEqual(record["status"], 0, record["printed"])
            said = [line for line in record["printed"].splitlines() if "a step in time ends" in line]
            self.assertEqual(len(said), 1)
            return record["result"]["time_step_iterations"], said[0]

        diagonal = math.sqrt(3)
        default, said = iterations()
        self.assertIn(f"is below {1e-3 * diagonal:.6g} (-time_velocity_tolerance, 0.001 of the box's "
                      "diagonal per time)", said)
        same, said = iterations("-time_velocity_tolerance_absolute", repr(1e-3 * diagonal))
        self.assertIn(f"is below {1e-3 * diagonal:.6g} (-time_velocity_tolerance_absolute, in length "
                      "per time)", said)
        self.assertEqual(default, same)
        loose, said = iterations("-time_velocity_tolerance_absolute", "10")
        self.assertIn("is below 10 (", said)
        self.assertEqual(loose, iterations("-time_velocity_tolerance", repr(10 / diagonal))[0])
        tight, _ = iterations("-time_velocity_tolerance_absolute", "1e-9")
        self.assertLess(sum(default), sum(tight))
        off, said = iterations("-time_velocity_tolerance_absolute", "0")
        self.assertIn("by its energy alone", said)
        self.assertGreater(sum(off), sum(default))

    def test_directions_are_as_long_as_a_vertex_moves(self):
        """A body in free flight, whose first direction is its velocity v times the step for every vertex:
        a tolerance below |v|, but above its components, does not end the step with it. Also where
        components are held, and eliminated, at some of the vertices."""
        def iterations(tolerance, components, *more, ranks=1):
            record = record_of([*BOX, "-snes_trefoil_energy_tolerance", "1e-26", *timed(0.1, 0.1),
                                "-snes_trefoil_monitor", "false", "-initial_velocity",
                                ", ".join(components), "-time_velocity_tolerance_absolute",
                                repr(tolerance), *more], ranks)
            self.assertEqual(record["status"], 0, record["printed"])
            return record["result"]["iterations"]

        slides = ["-constraints", "floor", "-constraint_floor_where", "z == zmin",
                  "-constraint_floor_move", "free, free, 0"]
        for components, more in ((["1e-4"] * 3, []), (["1e-4", "1e-4", "0"], slides),
                                 (["1e-4"] * 2, ["-mesh_generate", "square"])):
            size = 1e-4 * math.sqrt(sum(v != "0" for v in components))
            for ranks in (1, 2):
                with self.subTest(components=components, ranks=ranks):
                    self.assertEqual(iterations(1.01 * size, components, *more, ranks=ranks), 1)
                    self.assertEqual(iterations(0.99 * size, components, *more, ranks=ranks), 2)

    def test_what_an_iteration_lacks_is_a_dash(self):
        """A step that ends before its last direction is known has no decrement to print."""
        record = record_of([*BOX, *SOFT, *GRAVITY, "-snes_trefoil_energy_tolerance", "1e-26",
                            "-time_velocity_tolerance", "1e-13", *timed(0.2, 0.1)])
        rows = [line.split() for line in record["printed"].splitlines() if len(line.split()) == 11]
        self.assertIn("-", [row[4] for row in rows])
        self.assertNotIn("nan", record["printed"])

    def test_long_steps_are_not_ended_by_their_length(self):
        """A body pulled so slowly that inertia does not matter, in steps that are long in units of time:
        the states of rest, and a line says what bounds the direction."""
        scene = [*BOX, "-material_young", "1e6", "-material_poisson", "0.3", *HELD, "-constraints",
                 "wall,end", "-constraint_end_where", "x == xmax", "-constraint_end_move",
                 "min(t/5e3, 1), 0, 0", *timed(1e4, 2.5e3)]
        energies, said = [], []
        for tolerance in ([], ["-time_velocity_tolerance", "1e-12"]):
            record = record_of([*scene, *tolerance])
            self.assertEqual(record["status"], 0, record["printed"])
            energies.append([step["strain_energy"] for step in record["steps"]])
            said.append("and the direction itself below 0.00173205 (0.001 of the diagonal): the steps "
                        "are long" in record["printed"])
        for one, other in zip(*energies):
            self.assertAlmostEqual(one, other, delta=1e-6 * energies[1][-1])
        self.assertEqual(said, [True, False])

    def test_methods_of_petsc_end_by_their_residual(self):
        """newtonls and newtontr know no velocity: without options they end as well, at the same state."""
        ends = []
        for method in ("trefoil", "newtonls", "newtontr"):
            record = record_of([*BOX, *SOFT, *HELD, *GRAVITY, *timed(0.1, 0.02), "-snes_type", method])
            self.assertEqual(record["status"], 0, record["printed"])
            self.assertLess(record["result"]["iterations"], 40)
            ends.append(record["steps"][-1])
        for end in ends[1:]:
            self.assertAlmostEqual(end["kinetic_energy"], ends[0]["kinetic_energy"],
                                   delta=1e-4 * ends[0]["kinetic_energy"])

    def test_elements_are_clamped_by_default(self):
        for more, rule in (([], "clamp"), (["-snes_trefoil_filter", "on_demand"], "on_demand")):
            record = record_of([*BOX, *SOFT, *HELD, *GRAVITY, *timed(0.1, 0.1), *more])
            self.assertEqual(record["solver"]["filter"], rule)

    def test_check_tells_of_time(self):
        printed = run([*BOX, *timed(1, 0.1, "-time_integrator", "bdf2", "-time_damping_stiffness",
                                    "1e-3"), "--check"]).stdout
        self.assertIn("; to t = 1 in steps of 0.1 by bdf2, mass consistent, Rayleigh damping 0 and 0.001\n",
                      printed)
        self.assertNotIn("load steps", printed)

    def test_one_solver_for_all_steps(self):
        record = record_of([*BOX, *SOFT, *HELD, *GRAVITY, *timed(0.2, 0.02)])
        steps = record["result"]["time_step_iterations"]
        self.assertEqual(len(steps), 10)
        self.assertEqual(sum(steps), record["result"]["iterations"])
        self.assertEqual({entry["time_step"] for entry in record["history"]}, set(range(1, 11)))
        self.assertLessEqual(record["result"]["factorisations"], 30)


class Refused(unittest.TestCase):
    def check(self, sentence, options):
        for ranks in (1, 2):
            result = run(options, ranks)
            self.assertEqual(result.returncode, 1, result.stdout)
            self.assertIn(sentence, result.stdout)
            self.assertEqual(result.stdout.count("trefoil: "), 1, result.stdout)

    def test_one_sentence_each(self):
        light = ["-mesh_generate", "box", "-mesh_resolution", "2"]
        for sentence, options in (
                ("in time a body needs mass: give -material_density", [*light, *timed(1, 0.1)]),
                ("region 'a' has density 0", [*BOX, *timed(1, 0.1), "-regions", "a",
                                              "-region_a_where", "x < 0.5",
                                              "-region_a_material_density", "0"]),
                ("a step in time must be positive", [*BOX, *timed(1, 0)]),
                ("-time_step is -0.1", [*BOX, *timed(1, -0.1)]),
                ("-time_end is 0.05, less than one -time_step", [*BOX, *timed(0.05, 0.1)]),
                ("needs -time_end and -time_step", [*BOX, "-time_step", "0.1"]),
                ("needs -time_end and -time_step", [*BOX, "-initial_velocity", "0, 0, 1"]),
                ("-time_mass lumped is for linear cells",
                 [*BOX, "-order", "2", *timed(1, 0.1, "-time_mass", "lumped")]),
                ("-initial_velocity: ", [*BOX, *timed(1, 0.1, "-initial_velocity", "0, 1")]),
                ("'free' is for constraints; a velocity is a number",
                 [*BOX, *timed(1, 0.1, "-initial_velocity", "0, 1, free")]),
                ("-load_steps cuts the way of t", [*BOX, *timed(1, 0.1), "-load_steps", "4"]),
                ("-time_step_min is 0.2; it must lie above 0 and not above -time_step, 0.1",
                 [*BOX, *timed(1, 0.1, "-time_step_min", "0.2")]),
                ("-time_beta and -time_gamma are for -time_integrator newmark",
                 [*BOX, *timed(1, 0.1, "-time_beta", "0.3")]),
                ("stable with gamma from 0.5 on",
                 [*BOX, *timed(1, 0.1, "-time_integrator", "newmark", "-time_gamma", "0.4")]),
                ("-output_every is 0", [*BOX, *timed(1, 0.1), "-output_every", "0"]),
                ("-output_every is for steps", [*BOX, *HELD, "-output_every", "2"]),
                ("-output_every is for -output_file, which is not given",
                 [*BOX, *timed(1, 0.1), "-output_every", "2", "-output_csv", "/tmp/none.csv"]),
                ("-assembly hook watches element blocks, and masses are added as a whole matrix",
                 [*BOX, *timed(1, 0.1), "-assembly", "hook"]),
                (", 1.000000), t = 0.2\n",
                 [*BOX, *timed(1, 0.1), "-loads", "top", "-load_top_where", "z == zmax",
                  "-load_top_traction", "0, 0, t > 0.15 ? 1/0 : 0"]),
                ("-time_velocity_tolerance is -1",
                 [*BOX, *timed(1, 0.1, "-time_velocity_tolerance", "-1")]),
                ("-time_velocity_tolerance_absolute is -1",
                 [*BOX, *timed(1, 0.1, "-time_velocity_tolerance_absolute", "-1")]),
                ("-time_velocity_tolerance_absolute is '1 m/s', which is not a number",
                 [*BOX, *timed(1, 0.1, "-time_velocity_tolerance_absolute", "1 m/s")]),
                ("two units of one tolerance: leave out one or the other",
                 [*BOX, *timed(1, 0.1, "-time_velocity_tolerance_absolute", "1",
                               "-time_velocity_tolerance", "1e-3")])):
            with self.subTest(sentence):
                self.check(sentence, options)


if __name__ == "__main__":
    unittest.main()
