"""The page of examples/report.py: a scene solved by the program, and series written here, looked at
in Chromium where that is installed."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
EXAMPLES = os.path.join(HERE, "..", "..", "examples")
sys.path[:0] = [os.path.join(EXAMPLES, "python"), EXAMPLES]

import numpy as np

import body_series
import browser
import fields
import surface
import trefoil
from report_page import charts, packing, results
from report_page.body import Body

THREE = "/usr/share/javascript/three/three.min.js"
# How many colours a picture has, and whether it holds a strong one: drawn into a canvas that can be read.
LOOK = """(() => {
  eye.drawNow();
  const copy = document.createElement("canvas"), source = eye.canvas;
  [copy.width, copy.height] = [600, 400];
  const pen = copy.getContext("2d");
  pen.drawImage(source, 0, 0, 600, 400);
  const pixels = pen.getImageData(0, 0, 600, 400).data, colours = new Set();
  let strong = 0, signal = 0;
  for (let k = 0; k < pixels.length; k += 4) {
    if (!pixels[k + 3]) continue;
    const [r, g, b] = pixels.subarray(k, k + 3);
    colours.add((r >> 3) * 1024 + (g >> 3) * 32 + (b >> 3));
    strong += Math.max(r, g, b) - Math.min(r, g, b) > 60;
    signal += r > 200 && g < 70 && b > 80 && b < 150;
  }
  return {colours: colours.size, strong, signal};
})()"""


def record(**result):
    """A record as short as the page allows, with what is given."""
    history = [{"k": k, "energy": 10.0 - k, "gradient_norm": 1.0, "weight": 1.0, "rho": 1.0, "step": 1.0,
                "trials": 1, "decrement": 0.1 ** k, "indefinite": 0.0, "seconds": 0.1 * k} for k in range(4)]
    return {"schema": 1, "mesh": {"vertices": 8, "elements": 6, "element": "tet4", "dofs": 24, "free_dofs": 12},
            "solver": {"filter": "adaptive", "ranks": 1, "options": {"mesh_generate": "</pre><b>"}},
            "result": {"converged": True, "reason": "done", "iterations": 3, "energy": 7.0, "energy_scale": 5.0,
                       "inverted": 0, **result},
            "time": {"total": 1.0, "assembly": 0.4, "other": 0.6}, "memory": {}, "history": history}


def report(folder, run_record, *options):
    """Writes the record, runs report.py on body.xdmf, and returns the finished process."""
    with open(os.path.join(folder, "record.json"), "w", encoding="utf-8") as file:
        json.dump(run_record, file)
    return subprocess.run(
        ["/usr/bin/python3", os.path.join(EXAMPLES, "report.py"), "record.json", "body.xdmf", *options],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)


class Parts(unittest.TestCase):
    """What needs no browser."""

    def test_surfaces_close_and_point_outwards(self):
        points, cells = body_series.box(4, 3, 2)
        for order in (1, 2):
            skin = surface.Surface(points, cells)
            volume = np.einsum("ij,ij->", points[skin.triangles[:, 0]],
                               np.cross(points[skin.triangles[:, 1]], points[skin.triangles[:, 2]])) / 6
            self.assertAlmostEqual(volume, 24, msg=f"order {order}")
            self.assertEqual(len(skin.triangles), (2 * (4 * 3 + 3 * 2 + 4 * 2)) * 2 * (4 if order == 2 else 1))
            points, cells = body_series.quadratic(points, cells)

    def test_reversed_cells_at_rest_are_no_matter(self):
        points, cells = body_series.box(2, 2, 2)
        reversed_cells = cells[:, [1, 0, 2, 3]]
        outwards = surface.Surface(points, reversed_cells).triangles
        centre = points[outwards].mean(axis=1) - 1
        self.assertTrue((np.einsum("ij,ij->i", surface.face_normals(points, outwards), centre) > 0).all())

    def test_regions_have_surfaces_of_their_own(self):
        points, cells = body_series.box(4, 1, 1)
        regions = points[cells].mean(axis=1)[:, 0] > 2
        whole, apart = surface.Surface(points, cells), surface.Surface(points, cells, regions)
        self.assertEqual(len(apart.triangles) - len(whole.triangles), 4)

    def test_normals_are_smooth_but_at_edges(self):
        points, cells = body_series.box(3, 3, 3)
        triangles = surface.Surface(points, cells).triangles
        groups = surface.smoothing_groups(points, triangles)
        self.assertEqual(groups.max() + 1, 6 * 16)  # each side has its own 4 x 4 vertices
        self.assertEqual(len(surface.feature_edges(points, triangles)), 12 * 3)

    def test_thinned_surface_stays_where_it_was(self):
        points, cells = body_series.box(12, 12, 12)
        triangles = surface.Surface(points, cells).triangles
        stay, corners = surface.thinned(points, triangles, 500)
        self.assertLessEqual(len(stay), 500)
        self.assertGreater(len(stay), 100)
        volume = np.einsum("ij,ij->", points[corners[:, 0]],
                           np.cross(points[corners[:, 1]], points[corners[:, 2]])) / 6
        self.assertLess(abs(volume / 12**3 - 1), 0.3)

    def test_numbers_are_rounded_to_16_bits(self):
        values = np.array([1 / 3, -1e-12, 1e12, 0.0, np.inf, np.nan])
        rounded = packing.rounded(values).astype(float)
        self.assertTrue((abs(rounded[:4] - values[:4]) <= 8e-6 * abs(values[:4])).all())
        self.assertTrue(np.isinf(rounded[4]) and np.isnan(rounded[5]))

    def test_magnitude_of_a_symmetric_tensor_counts_what_is_off_the_diagonal_twice(self):
        six = np.array([[1.0, 2, 3, 4, 5, 6]])
        full = np.array([[1.0, 2, 3, 2, 4, 5, 3, 5, 6]])
        self.assertAlmostEqual(fields.columns("a", six)["magnitude"][0], fields.columns("a", full)["magnitude"][0])
        self.assertEqual(list(fields.columns("principal_stretches", full[:, :3])), ["1", "2", "3"])

    def test_units(self):
        self.assertEqual(fields.unit("von_mises", fields.Units("mm, N")), "MPa")
        self.assertEqual(fields.unit("von_mises", fields.Units("m N")), "Pa")
        self.assertEqual(fields.unit("determinant_F", fields.Units("m N")), "")
        self.assertEqual(fields.unit("displacement", fields.Units()), "")
        self.assertRaises(ValueError, fields.Units, "mm")

    def test_charts_of_odd_numbers(self):
        for y in ([1.0], [0.0, 0.0], [float("nan")] * 3, [5.0, 5.0], [-1e9, 1e-9]):
            for log in (False, True):
                text = charts.line_chart("a", [charts.Series("b", list(range(len(y))), y)], "x", "y", log)
                self.assertNotIn("nan", text)

    def test_warnings(self):
        self.assertEqual(results.warnings(record()), [])
        self.assertIn("2 elements ended inverted", results.warnings(record(inverted=2))[0])
        self.assertIn("without an equilibrium", results.warnings(record(converged=False))[0])
        self.assertEqual(results.warnings(record(inverted=1, warnings=["1 inverted element"])), ["1 inverted element"])


    def test_forces_are_shown_as_far_as_the_record_has_them(self):
        units = fields.Units("mm, N")
        self.assertEqual(results.forces_tables(record(), units), "")
        some = results.forces_tables({"constraints": [{"name": "wall", "vertices": 3}]}, units)
        self.assertIn("wall", some)
        self.assertNotIn("reaction", some)
        more = results.forces_tables({
            "constraints": [{"name": "wall", "vertices": 3, "reaction": [1e-15, 0, 4.5], "moment": [0, 0, 0]}],
            "loads": [{"name": "<hook>", "facets": 2, "area": 1.0, "force": [0, 0, -4.5]}],
            "result": {"probes": {"tip": [1, 2, 3]}}}, units)
        for words in ("reaction [N]", "(0, 0, 4.5)", "&lt;hook&gt;", "area [mm²]", "(1, 2, 3)"):
            self.assertIn(words, more)


class Budget(unittest.TestCase):
    def test_a_large_body_is_kept_within_the_size_and_said(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "body.xdmf")
            body_series.bent_bar(path, 8, 1, (40, 12, 12))
            steps, units = trefoil.read_steps(path), fields.Units()
            whole = Body(steps, units, 1e9)
            small = Body(steps, units, len(whole.text) / 12)
            self.assertEqual(whole.notes, [])
            self.assertEqual(len(whole.steps), 8)
            self.assertLessEqual(len(small.text), len(whole.text) / 12)
            self.assertEqual((small.steps[0], small.steps[-1]), (0, 7))
            self.assertIn("of 8 steps", " ".join(small.notes))


@unittest.skipUnless(os.path.exists(THREE), "needs libjs-three")
class Program(unittest.TestCase):
    """report.py as a command."""

    def test_bad_input_is_one_sentence(self):
        with tempfile.TemporaryDirectory() as folder:
            missing = report(folder, record())
            self.assertEqual(missing.returncode, 1)
            self.assertRegex(missing.stdout, r"^report.py: cannot read body.xdmf: .*\n$")
            body_series.bent_bar(os.path.join(folder, "body.xdmf"), 1, 1)
            wrong = report(folder, {"mesh": {}})
            self.assertRegex(wrong.stdout, r"^report.py: record.json is no record .*lacks 'solver'\n$")
            self.assertRegex(report(folder, record(), "--units", "mm").stdout, r"^report.py: units are .*\n$")
            self.assertRegex(report(folder, record(), "--size", "1").stdout, r"^report.py: .* has no room .*\n$")
            self.assertRegex(report(folder, record(), "-o", "no/where.html").stdout, r"^report.py: cannot write .*\n$")
            self.assertRegex(report(folder, record(), "--three", ".").stdout, r"^report.py: .*libjs-three\n$")
            self.assertEqual(sorted(os.listdir(folder)), ["body.h5", "body.xdmf", "record.json"])

    def test_the_page_is_one_file_below_its_size(self):
        with tempfile.TemporaryDirectory() as folder:
            body_series.bent_bar(os.path.join(folder, "body.xdmf"), 12, 1, (60, 20, 20))
            self.assertEqual(report(folder, record(), "--size", "2").stdout, "")
            with open(os.path.join(folder, "body.html"), encoding="utf-8") as file:
                page = file.read()
            self.assertLess(len(page.encode()), 2e6)
            self.assertNotRegex(page.split("<script>")[0], r"(src|href)=")
            self.assertIn("&lt;/pre&gt;&lt;b&gt;", page)  # what the options hold is text


@unittest.skipUnless(browser.PROGRAM and os.path.exists(THREE), "needs chromium and libjs-three")
class Page(unittest.TestCase):
    """The page in Chromium, from the disk."""

    def look(self, folder, act=None, width=1400):
        with browser.Browser(os.path.join(folder, "body.html"), width) as page:
            self.assertEqual(page.wait_for("document.documentElement.dataset.viewer"), "ready")
            seen = page.evaluate(LOOK)
            self.assertGreater(seen["colours"], 30, "the picture is blank")
            self.assertGreater(seen["strong"], 2000, "nothing is coloured")
            if act:
                act(page)
            self.assertEqual(page.errors, [])

    def test_a_scene_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = {"mesh": {"generate": "knot"}, "constraints": "held,pulled", "constraint": {
                "held": {"where": "x < xmin + 0.5", "move": "0, 0, 0"},
                "pulled": {"where": "x > xmax - 0.8", "move": "1, 0, 0"}}}
            result = trefoil.run(scene, 1, folder=folder, output_file=os.path.join(folder, "body.xdmf"))
            self.assertEqual(report(folder, result.record).stdout, "")

            def act(page):
                self.assertIn("Converged", page.evaluate("document.body.innerText"))
                self.assertEqual(page.evaluate("document.querySelectorAll('.chart').length"), 2)
                self.assertEqual(page.evaluate("element('timeline').hidden"), True)
                names = page.evaluate("manifest.fields.map(field => field.name)")
                self.assertEqual({name for name in names if not name.endswith(" of cells")}, set(result.fields))

            self.look(folder, act)

    def test_steps_fields_regions_and_inverted_elements(self):
        with tempfile.TemporaryDirectory() as folder:
            inverted = body_series.bent_bar(os.path.join(folder, "body.xdmf"), 5, 2)
            self.assertEqual(report(folder, record(inverted=inverted), "--units", "mm, N").stdout, "")

            def act(page):
                self.assertGreater(page.evaluate(LOOK)["signal"], 20, "inverted elements are not marked")
                page.evaluate("setScale(3)")
                self.assertEqual(page.evaluate("element('drawn_scale').textContent"), "displacements × 3")
                page.evaluate("setScale(1)")
                self.assertEqual(page.evaluate("element('drawn_scale').textContent"), "")
                page.evaluate("element('show_inverted').click()")
                self.assertEqual(page.evaluate(LOOK)["signal"], 0)
                page.evaluate("element('show_inverted').click()")
                self.assertEqual(page.evaluate("element('inverted_count').textContent"),
                                 f"inverted elements: {inverted}")
                page.evaluate("canvas.focus()")
                for _ in range(2):
                    page.press("[")
                self.assertIn("3 of 5", page.evaluate("element('step_name').textContent"))
                self.assertEqual(page.evaluate(LOOK)["signal"], 0)
                for name in page.evaluate("manifest.fields.map(field => field.name)"):
                    page.evaluate(f"element('field').value = '{name}'; "
                                  "element('field').dispatchEvent(new Event('change'))")
                    self.assertGreater(page.evaluate(LOOK)["colours"], 1, name)
                titles = page.evaluate("manifest.fields.map(field => field.title)")
                self.assertIn("von Mises stress", titles)
                self.assertIn("von Mises stress, by cell", titles)
                page.evaluate("chooseField('cauchy_stress'); element('column').value = 'yz'; "
                              "element('column').dispatchEvent(new Event('change'))")
                self.assertEqual(page.evaluate("element('legend_title').textContent"), "Cauchy stress, yz [MPa]")
                before = page.evaluate("picture.geometry.index ? picture.geometry.index.count : 3 * picture.count")
                page.evaluate("element('regions').querySelectorAll('input')[1].click()")
                self.assertLess(page.evaluate("picture.geometry.index.count"), before)
                place = "eye.camera.position.toArray()"
                before = page.evaluate(place)
                page.press("ArrowLeft")
                self.assertNotEqual(page.evaluate(place), before)

            self.look(folder, act)

    def test_values_under_the_mouse(self):
        with tempfile.TemporaryDirectory() as folder:
            points, cells = body_series.square(6)
            body_series.write(os.path.join(folder, "body.xdmf"), points, cells, [
                (None, {"displacement": (True, np.zeros_like(points)), "height": (True, points[:, 1]),
                        "whole": (False, np.arange(len(cells)))})])
            self.assertEqual(report(folder, record()).stdout, "")

            def act(page):
                page.evaluate("chooseField('height')")
                spot = page.evaluate("""(() => {
                    const at = new THREE.Vector3(-1, 2, 0).project(eye.camera);  // (2, 5) at rest
                    const frame = eye.canvas.getBoundingClientRect();
                    return [frame.left + (at.x + 1) / 2 * frame.width, frame.top + (1 - at.y) / 2 * frame.height];
                })()""")
                page.evaluate(f"showReading({{clientX: {spot[0]}, clientY: {spot[1]}}})")
                self.assertRegex(page.evaluate("element('reading').textContent"),
                                 r"^height: 5\nvertex 19, at rest near \(2, 5\)$")

            with browser.Browser(os.path.join(folder, "body.html"), 700) as page:
                self.assertEqual(page.wait_for("document.documentElement.dataset.viewer"), "ready")
                act(page)
                self.assertEqual(page.errors, [])

    def test_light_and_dark(self):
        with tempfile.TemporaryDirectory() as folder:
            body_series.bent_bar(os.path.join(folder, "body.xdmf"), 2, 1)
            self.assertEqual(report(folder, record()).stdout, "")

            def act(page):
                shade = "getComputedStyle(document.body).backgroundColor"
                light = page.evaluate(shade)
                page.evaluate("element('theme').click()")
                self.assertNotEqual(page.evaluate(shade), light)

            self.look(folder, act, 420)


if __name__ == "__main__":
    unittest.main()
