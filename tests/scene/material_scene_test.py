#!/usr/bin/python3
"""Materials and regions in whole scenes: closed forms, every assembly path and number of ranks,
stiffness contrast, and the start that a material does not allow."""
import itertools
import math
import os
import tempfile
import unittest

from boxes import ENDS, PULLED, SPRING, THREE_PLANES, TIGHT, energy
from trefoil_program import record_of, run

MODELS = ("stable_neo_hookean", "neo_hookean", "mooney_rivlin", "arap", "symmetric_dirichlet",
          "corotated", "st_venant_kirchhoff")


def psi(model, stretches, young, poisson):
    """The energy densities by their principal stretches, as the books have them."""
    mu, lame = young / (2 * (1 + poisson)), young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    volume = math.prod(stretches)
    first = sum(s * s for s in stretches)
    second = sum((a * b) ** 2 for a, b in itertools.combinations(stretches, 2))
    strain = sum((s - 1) ** 2 for s in stretches)
    if model == "stable_neo_hookean":
        lame += mu
        return mu / 2 * (first - 3) + lame / 2 * (volume - 1 - mu / lame) ** 2
    if model == "neo_hookean":
        return mu / 2 * (first - 3) - mu * math.log(volume) + lame / 2 * math.log(volume) ** 2
    if model == "mooney_rivlin":
        return (mu / 4 * (first - 3 + second - 3) - 1.5 * mu * (volume - 1)
                + (lame + mu / 2) / 2 * (volume - 1) ** 2)
    if model == "arap":
        return mu * strain + lame / 2 * (volume - 1) ** 2
    if model == "symmetric_dirichlet":
        return (mu / 4 * (first + sum(s ** -2 for s in stretches) - 6)
                + lame / 2 * (volume - 1) ** 2)
    if model == "corotated":
        return mu * strain + lame / 2 * (sum(stretches) - 3) ** 2
    green = [(s * s - 1) / 2 for s in stretches]
    return mu * sum(e * e for e in green) + lame / 2 * sum(green) ** 2


def least(function, low, high):
    """The least value of a function that has one valley between low and high."""
    ratio = (math.sqrt(5) - 1) / 2
    for _ in range(100):
        a, b = high - ratio * (high - low), low + ratio * (high - low)
        low, high = (low, b) if function(a) < function(b) else (a, high)
    return function(low)


class EveryMaterial(unittest.TestCase):
    def test_uniaxial_stretch_is_the_closed_form(self):
        young, poisson = 3e6, 0.3
        for model in MODELS:
            with self.subTest(model=model):
                record = record_of(PULLED + TIGHT + [
                    "-material_model", model, "-material_young", str(young),
                    "-material_poisson", str(poisson)])
                expected = least(lambda s: psi(model, (s, s, 1.5), young, poisson), 0.5, 1.2)
                self.assertEqual(record["status"], 0)
                self.assertLess(abs(energy(record) / expected - 1), 1e-10)

    def test_lames_constants_are_youngs_and_poissons(self):
        young, poisson = 2e6, 0.25  # so lambda = mu = 8e5
        for model in ("arap", "neo_hookean"):
            one = record_of(PULLED + ["-material_model", model, "-material_young", str(young),
                                      "-material_poisson", str(poisson)])
            other = record_of(PULLED + ["-material_model", model, "-material_mu", "8e5",
                                        "-material_lambda", "8e5"])
            self.assertLess(abs(energy(one) / energy(other) - 1), 1e-12)

    def test_the_volume_term_is_lambda_unless_given(self):
        pulled = PULLED + ["-material_model", "arap", "-material_mu", "1e5", "-material_lambda"]
        given, taken = [record_of(pulled + words) for words in (
            ["0", "-material_volume", "3e6"], ["3e6"])]
        self.assertLess(abs(energy(given) / energy(taken) - 1), 1e-12)

    def test_sheared_and_pulled_on_every_path_and_rank(self):
        for model in MODELS:
            scene = ENDS + TIGHT + ["-constraint_high_move", "0.5, 0, 0.4", "-material_model",
                                    model, "-material_poisson", "0.4"]
            serial = record_of(scene)
            self.assertEqual(serial["status"], 0, model)
            for options, ranks in ((["-assembly", "plain"], 1), ([], 2)):
                with self.subTest(model=model, options=options, ranks=ranks):
                    other = record_of(scene + options, ranks)
                    self.assertLess(abs(energy(other) / energy(serial) - 1), 1e-9)
                    self.assertEqual(other["result"]["iterations"], serial["result"]["iterations"])

    def test_the_search_copes_with_infinite_energies(self):
        """A load under which the linear body would be turned inside out: full steps are infinite."""
        for model in ("neo_hookean", "symmetric_dirichlet"):
            with self.subTest(model=model):
                record = record_of(THREE_PLANES + [
                    "-material_model", model, "-material_young", "1e4", "-material_poisson", "0.3",
                    "-material_density", "1e4", "-load_gravity", "0, 0, -9.81"])
                result = record["result"]
                self.assertEqual(record["status"], 0)
                self.assertEqual(result["inverted"], 0)
                self.assertGreater(record["history"][0]["trials"], 1)
                self.assertLess(record["history"][0]["step"], 1)


class InfiniteStart(unittest.TestCase):
    def test_it_is_an_error_that_says_what_to_do(self):
        for ranks, model in ((1, "neo_hookean"), (2, "symmetric_dirichlet")):
            result = run(ENDS + ["-material_model", model, "-constraint_high_move", "0, 0, -0.5",
                                 "-initial", "rest"], ranks)
            self.assertEqual(result.returncode, 1)
            # All tetrahedra of the uppermost layer, whose lower side the lid has passed.
            for words in ("invert 96 elements", "the first at rest position (", ", 0.8125)",
                          "-initial harmonic", "-load_steps"):
                self.assertIn(words, result.stdout)


class AutomaticStart(unittest.TestCase):
    def test_volume_is_what_rotations_ignore(self):
        """Poisson's ratio above 0.4545 (lambda = 10 mu) in any part: no local/global steps."""
        scene = ENDS + ["-constraint_high_move", "0.3, 0, 0.1"]
        half = ["-regions", "half", "-region_half_where", "z < 0.5", "-region_half_material_poisson"]
        for options, initial in ((["-material_poisson", "0.45"], "arap"),
                                 (["-material_poisson", "0.46"], "harmonic"),
                                 (["-material_poisson", "0.495", "-material_lame", "raw"], "harmonic"),
                                 (["-material_model", "mooney_rivlin"], "arap"),
                                 ([*half, "0.3"], "arap"), ([*half, "0.49"], "harmonic")):
            with self.subTest(options=options):
                solves = [record_of(scene + options + more)["result"]["guess_linear_solves"]
                          for more in ([], ["-initial", initial])]
                self.assertEqual(solves[0], solves[1])
                self.assertEqual(solves[0], 3 if initial == "harmonic" else 63)


class Words(unittest.TestCase):
    def test_linear_elements_lock_and_say_so(self):
        half = ["-regions", "half", "-region_half_where", "z < 0.5", "-region_half_material_poisson"]
        scene = ENDS + ["-constraint_high_move", "0, 0, 0.01"]
        for ranks, options, locks in ((1, ["-material_poisson", "0.45"], False),
                                      (2, ["-material_poisson", "0.46"], True),
                                      (1, ["-material_poisson", "0.46", "-order", "2"], False),
                                      (1, ["-material_poisson", "0.3", *half, "0.49"], True)):
            with self.subTest(options=options):
                record = record_of(scene + options, ranks)
                warnings = [text for text in record["result"]["warnings"] if "lock" in text]
                self.assertEqual(len(warnings), locks)
                self.assertEqual("WARNING: linear elements lock" in record["printed"], locks)
                self.assertIn("-order 2" if locks else "", "".join(warnings))

    def test_how_much_they_lock_by_poisson_and_dimension(self):
        flat = ["-mesh_generate", "square", "-mesh_resolution", "2", "-constraints", "low",
                "-constraint_low_where", "y == ymin"]
        for scene, poisson, words, excess in ((ENDS, "0.46", "0.46 a twisted cube", "8.5 %"),
                                      (ENDS, "0.4998", "0.4999 a twisted cube", "513 %"),
                                      (flat, "0.4998", "0.4999 a sheared square", "11 %")):
            with self.subTest(scene=scene, poisson=poisson):
                self.assertIn(f"At {words} of 8 cells an edge stores {excess} too much", run([*scene, "-material_poisson", poisson, "-check"]).stdout)

    def test_the_default_material_is_said(self):
        scene = ["-mesh_generate", "box", "-mesh_resolution", "2", "-constraints", "low",
                 "-constraint_low_where", "z == zmin"]
        self.assertIn("material: none is named", record_of(scene)["printed"])
        for option in (["-material_young", "2"], ["-material_model", "stable_neo_hookean"]):
            self.assertNotIn("none is named", record_of(scene + option)["printed"])


class Regions(unittest.TestCase):
    def test_springs_in_a_row(self):
        """A stiff lower and a soft upper half: the stress is one, the stretches are not."""
        soft, stiff, pull = 1e6, 1e12, 0.5
        stress = pull / (0.5 / soft + 0.5 / stiff)
        expected = 0.25 * stress ** 2 * (1 / soft + 1 / stiff)
        scene = PULLED + TIGHT + SPRING + [
            "-material_young", str(soft), "-regions", "stiff", "-region_stiff_where", "z < 0.5",
            "-region_stiff_material_young", str(stiff)]
        for options, ranks in (([], 1), (["-assembly", "plain"], 1), (["-assembly", "hook"], 1),
                               ([], 2), ([], 3)):
            with self.subTest(options=options, ranks=ranks):
                record = record_of(scene + options, ranks)
                self.assertEqual(record["status"], 0)
                self.assertLess(abs(energy(record) / expected - 1), 1e-9)

    def test_contrast_of_a_million_with_several_materials(self):
        """Inclusions of other materials, whose borders cut through the packs of elements."""
        scene = ENDS + TIGHT + [
            "-mesh_resolution", "6", "-constraint_high_move", "0.3, 0, 0.4",
            "-material_young", "1e4", "-material_poisson", "0.4", "-regions", "bone,fat",
            "-region_bone_where", "abs(x - 0.5) < 0.2 && abs(z - 0.5) < 0.2",
            "-region_bone_material_model", "arap", "-region_bone_material_young", "1e10",
            "-region_fat_where", "abs(x - 0.5) > 0.4", "-region_fat_material_model",
            "mooney_rivlin", "-region_fat_material_poisson", "0.3"]
        serial = record_of(scene)
        self.assertEqual(serial["status"], 0)
        for options, ranks in ((["-assembly", "plain"], 1), (["-assembly", "hook"], 2), ([], 2),
                               ([], 3)):
            with self.subTest(options=options, ranks=ranks):
                other = record_of(scene + options, ranks)
                self.assertEqual(other["status"], 0)
                self.assertEqual(other["result"]["iterations"], serial["result"]["iterations"])
                for key in ("energy", "energy_rest", "energy_scale"):
                    self.assertLess(abs(other["result"][key] / serial["result"][key] - 1), 1e-9)

    def test_a_region_of_the_same_material_changes_nothing(self):
        scene = ENDS + ["-constraint_high_move", "0.3, 0, 0.4"]
        one = record_of(scene)
        two = record_of(scene + ["-regions", "half", "-region_half_where", "x + y < 0.9"])
        self.assertEqual(one["result"]["iterations"], two["result"]["iterations"])
        self.assertLess(abs(energy(two) / energy(one) - 1), 1e-12)

    def test_physical_groups_of_a_gmsh_file(self):
        """Two cubes of six tetrahedra, one on the other: groups choose as the expression does."""
        corners = [(x, y, z) for z in range(3) for y in range(2) for x in range(2)]
        number = {corner: k + 1 for k, corner in enumerate(corners)}
        elements = []
        for z in range(2):
            for order in itertools.permutations(range(3)):
                point, nodes = [0, 0, z], [number[(0, 0, z)]]
                for axis in order:
                    point[axis] += 1
                    nodes.append(number[tuple(point)])
                if order not in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
                    nodes[:2] = nodes[1::-1]
                elements.append(f"{len(elements) + 1} 4 2 {z + 5} 1 {' '.join(map(str, nodes))}\n")
        text = ("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n3 5 \"lower half\"\n"
                f"3 6 \"upper\"\n$EndPhysicalNames\n$Nodes\n{len(corners)}\n"
                + "".join(f"{number[c]} {c[0]} {c[1]} {c[2]}\n" for c in corners)
                + f"$EndNodes\n$Elements\n{len(elements)}\n{''.join(elements)}$EndElements\n")
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "cubes.msh")
            with open(path, "w", encoding="ascii") as file:
                file.write(text)
            scene = ["-mesh_file", path, *PULLED[4:], *TIGHT, *SPRING, "-regions", "stiff",
                     "-region_stiff_material_young", "1e9"]
            by_place = record_of(scene + ["-region_stiff_where", "z < 1"])
            for choice, ranks, refine in (("5", 1, 0), ("lower half", 2, 0), ("lower half", 2, 1)):
                record = record_of(scene + ["-region_stiff_group", choice, "-mesh_refine",
                                            str(refine)], ranks)
                self.assertLess(abs(energy(record) / energy(by_place) - 1), 1e-9)
            refused = run(scene + ["-region_stiff_group", "middle"])
            self.assertEqual(refused.returncode, 1)
            self.assertIn("it has: volume 5 'lower half', volume 6 'upper'", refused.stdout)


if __name__ == "__main__":
    unittest.main(verbosity=2)
