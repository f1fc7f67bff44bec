"""examples/picture.py, animate.py and plot_convergence.py: what is in front, and what they refuse."""
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
EXAMPLES = os.path.join(HERE, "..", "..", "examples")
sys.path[:0] = [os.path.join(EXAMPLES, "python"), EXAMPLES]

import matplotlib

matplotlib.use("Agg")
import matplotlib.image
import numpy as np

import body_series
import history
import plot_convergence
import render
import trefoil
from report_test import record

TOP = np.eye(3)  # looks down the z axis: right x, up y


def run(name, folder, *options):
    return subprocess.run(["/usr/bin/python3", os.path.join(EXAMPLES, name), *options], cwd=folder,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)


def numbered(owner, weights):
    """A colour that tells the number of the triangle."""
    return np.stack([owner / 10, 0 * owner, 0 * owner], axis=1)


class Render(unittest.TestCase):
    def draw(self, points, triangles, **more):
        window = render.Window([-1, -1], [1, 1], 40, 40, margin=0)
        smooth = np.arange(np.size(triangles)).reshape(np.shape(triangles))
        return render.draw(np.asarray(points, float), np.asarray(triangles), smooth, TOP, window, numbered, **more)

    def test_three_bars_that_cover_each_other_in_a_ring(self):
        # No order of painting is right: each lies before one of the others and behind the third.
        points, triangles = [], []
        for k in range(3):
            turn = 2 * np.pi / 3 * k
            along, across = np.array([np.cos(turn), np.sin(turn), 0]), np.array([-np.sin(turn), np.cos(turn), 0])
            corners = [-0.9 * along, 0.9 * along + [0, 0, 0.5], 0.9 * along + 0.25 * across + [0, 0, 0.5],
                       -0.9 * along + 0.25 * across]
            points += [corner + 0.3 * across for corner in corners]
            triangles += [[4 * k, 4 * k + 1, 4 * k + 2], [4 * k, 4 * k + 2, 4 * k + 3]]
        points, triangles = np.array(points), np.array(triangles)
        image = self.draw(points, triangles)
        seen, crossings = 0, set()
        for row in range(40):
            for column in range(40):
                if image[row, column, 3] < 1:
                    continue
                x, y = (column + 0.5) / 20 - 1, 1 - (row + 0.5) / 20
                depth = {}
                for number, (a, b, c) in enumerate(points[triangles]):
                    share = np.linalg.solve(np.stack([a, b, c], 1) * [[1], [1], [0]] + [[0], [0], [1]], [x, y, 1])
                    if (share > 0.05).all():
                        depth[number] = share @ [a[2], b[2], c[2]]
                red = image[row, column, 0]
                if len(depth) > 1:
                    front = max(depth, key=depth.get)
                    crossings.add(tuple(sorted(number // 2 for number in depth)))
                    self.assertLess(abs(red - image[row, column, 1] - front / 10 * 1.0), 0.12)
                    seen += 1
        self.assertGreater(seen, 20)
        self.assertEqual(len(crossings), 3)

    def test_covers_each_pixel_once_and_leaves_the_rest(self):
        image = self.draw([[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.5, 0.5, 0], [-0.5, 0.5, 0]], [[0, 1, 2], [0, 2, 3]])
        self.assertEqual(image[..., 3].sum(), 20 * 20)
        self.assertTrue((image[10:30, 10:30, 3] == 1).all())

    def test_small_and_large_triangles_and_those_outside(self):
        rng = np.random.default_rng(1)
        for size in (1e-3, 0.05, 3, 1e3):
            points = rng.uniform(-1, 1, (60, 1, 3)) + size * rng.normal(size=(60, 3, 3))
            image = self.draw(points.reshape(-1, 3), np.arange(180).reshape(-1, 3), edges=np.ones((60, 3), bool))
            self.assertTrue(np.isfinite(image).all())


class Programs(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name):
        return os.path.join(self.folder, name)

    def test_pictures_of_every_kind_of_body(self):
        plane = body_series.square(4)
        for points, cells in (plane, body_series.quadratic(*plane), body_series.box(2, 2, 1),
                              body_series.quadratic(*body_series.box(2, 2, 1))):
            body_series.write(self.path("b.xdmf"), points, cells,
                              [(None, {"displacement": (True, 0.2 * points), "a": (False, np.arange(len(cells)))})])
            for field in ("displacement", "a"):
                done = run("picture.py", self.folder, "b.xdmf", "--field", field, "--dpi", "50")
                self.assertEqual(done.stdout, "")
                pixels = matplotlib.image.imread(self.path("b.png"))[..., :3]
                colourful = (pixels.max(axis=2) - pixels.min(axis=2) > 0.2).mean()
                self.assertGreater(colourful, 0.05)

    def test_component_scale_and_range_of_a_series(self):
        body_series.bent_bar(self.path("bar.xdmf"), 3, 1, (6, 2, 2))
        done = run("picture.py", self.folder, "bar.xdmf", "--field", "cauchy_stress", "--component", "yz",
                   "--scale", "2", "--range", "0,5", "--units", "mm, N")
        self.assertEqual(done.stdout, "")
        smooth, flat = (self.picture_of("bar.xdmf", "--field", "von_mises", *more) for more in ([], ["--cells"]))
        self.assertGreater((abs(smooth - flat).max(axis=2) > 0.1).mean(), 0.02)

    def picture_of(self, *words):
        self.assertEqual(run("picture.py", self.folder, *words, "-o", "p.png", "--dpi", "60").stdout, "")
        return matplotlib.image.imread(self.path("p.png"))[..., :3]

    def test_bad_input_is_one_sentence(self):
        body_series.bent_bar(self.path("bar.xdmf"), 1, 1, (3, 1, 1))
        for words, sentence in (
                (["picture.py", "none.xdmf"], "picture.py: cannot read none.xdmf"),
                (["picture.py", "bar.xdmf", "--field", "heat"], "picture.py: bar.xdmf has no field 'heat', but displacement"),
                (["picture.py", "bar.xdmf", "--component", "w"], "picture.py: cannot draw bar.png: displacement has no component 'w', but magnitude, x, y, z"),
                (["animate.py", "bar.xdmf", "-o", "bar.avi"], "animate.py: cannot write bar.avi: its name must end in .mp4 or .gif"),
                (["animate.py", "bar.xdmf", "-o", "no/bar.gif"], "animate.py: cannot draw no/bar.gif"),
                (["animate.py", "bar.xdmf", "--field", "heat"], "animate.py: bar.xdmf has no field 'heat'")):
            done = run(words[0], self.folder, *words[1:])
            self.assertEqual(done.returncode, 1, words)
            self.assertTrue(done.stdout.startswith(sentence), done.stdout)
            self.assertEqual(done.stdout.count("\n"), 1, done.stdout)
        self.assertEqual(sorted(os.listdir(self.folder)), ["bar.h5", "bar.xdmf"])

    def test_film_of_a_series(self):
        body_series.bent_bar(self.path("bar.xdmf"), 3, 1, (4, 2, 2))
        done = run("animate.py", self.folder, "bar.xdmf", "-o", "bar.gif", "--seconds", "1", "--fps", "6",
                   "--size", "240x180", "--turn", "30")
        self.assertEqual(done.stdout, "")
        from PIL import Image
        with Image.open(self.path("bar.gif")) as film:
            self.assertEqual((film.size, film.n_frames), ((240, 180), 6))
            frames = []
            for number in (0, 5):
                film.seek(number)
                frames.append(np.asarray(film.convert("RGB"), float))
        self.assertGreater((abs(frames[0] - frames[1]).max(axis=2) > 40).mean(), 0.02)

    @unittest.skipUnless(shutil.which("ffmpeg"), "needs ffmpeg")
    def test_film_by_ffmpeg(self):
        points, cells = body_series.square(3)
        body_series.write(self.path("b.xdmf"), points, cells, [(None, {"displacement": (True, 0.2 * points)})])
        done = run("animate.py", self.folder, "b.xdmf", "--seconds", "1", "--fps", "5", "--size", "241x180")
        self.assertEqual(done.stdout, "")
        self.assertEqual(sorted(os.listdir(self.folder)), ["b.h5", "b.mp4", "b.xdmf"])


class Convergence(unittest.TestCase):
    def test_steps_longer_than_one_are_in_the_picture(self):
        long_steps = record()
        for entry in long_steps["history"]:
            entry["step"] = 1.8
        self.assertGreater(self.step_axis(long_steps), 1.8)

    def test_load_steps_are_curves_of_their_own(self):
        steps = record(load_step_iterations=[1, 3])
        self.assertEqual(history.load_steps(steps), [(0, 1), (1, 4)])
        self.assertEqual(history.final_energies(steps), [10.0, 7.0])
        self.assertEqual(history.load_steps(record(load_step_iterations=[9])), [(0, 4)])

    def step_axis(self, data):
        """The upper end of the axis of step lengths."""
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "record.json")
            with open(path, "w", encoding="utf-8") as file:
                json.dump(data, file)
            plot_convergence.plot([plot_convergence.read(path)], os.path.join(folder, "p.png"))
            axes = plot_convergence.plt.gcf().axes
            return next(each.get_ylim()[1] for each in axes if each.get_title() == "Step length")


if __name__ == "__main__":
    unittest.main()
