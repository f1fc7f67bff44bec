#!/usr/bin/python3
"""What is installed serves from where it is put: `cmake --install build --prefix ELSEWHERE`."""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from hosts import ROOT, run
from own_material_test import SCENE

BUILD = os.environ.get("TREFOIL_BUILD", os.path.join(ROOT, "build"))


def call(*words, **variables):
    """What a command printed; it must succeed."""
    result = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                            env=dict(os.environ, **variables), check=False)
    if result.returncode:
        raise AssertionError(f"{' '.join(words)}:\n{result.stdout}")
    return result.stdout


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.prefix = pathlib.Path(cls.folder.name, "there")
        call("cmake", "--install", BUILD, "--prefix", str(cls.prefix))
        cls.packages = next(cls.prefix.rglob("trefoil.pc")).parent

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_headers_are_those_of_the_include_folder(self):
        def headers(folder):
            return {path.relative_to(folder) for path in folder.rglob("*.h*")
                    if "share" not in path.relative_to(folder).parts and path.suffix != ".html"}
        self.assertEqual(headers(self.prefix), {pathlib.Path("include", path)
                                                for path in headers(pathlib.Path(ROOT, "include"))})

    def test_pages_are_there_and_their_links_hold(self):
        pages = list(self.prefix.rglob("README.md"))
        self.assertGreaterEqual(len(pages), 5)
        for page in pages:
            for link in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf8")):
                if not link.startswith("http"):
                    self.assertTrue((page.parent / link).exists(), f"{page}: {link}")
        self.assertTrue(list(self.prefix.rglob("LICENSE")))

    def test_the_manual_page_has_every_option(self):
        page = next(self.prefix.rglob("man1/trefoil.1")).read_text(encoding="utf8")
        page = page.replace("\\-", "-")
        for name in ("mesh_file", "constraint_NAME_where", "load_NAME_pressure", "output_fields",
                     "snes_trefoil_filter", "snes_linesearch_armijo"):
            self.assertIn(f"\n.B -{name}\n", page)
        self.assertNotRegex(page, r"(?m)^[.'](?!TH|SH|SS|TP|B\b|BR|I\b|RB|nf|fi)")

    def test_a_material_of_ones_own_is_built_against_them(self):
        build = os.path.join(self.folder.name, "own_material")
        call("cmake", "-S", os.path.join(ROOT, "examples", "own_material"), "-B", build,
             f"-Dtrefoil_DIR={next(self.prefix.rglob('trefoilConfig.cmake')).parent}")
        printed = call("cmake", "--build", build)
        self.assertNotIn("warning", printed)
        printed, status, record = run(
            [str(self.prefix / "bin" / "trefoil")],
            f"{SCENE} -dll_append {build}/libown_material.so -material_model mine")
        self.assertEqual(status, 0, printed)
        self.assertTrue(record["result"]["converged"])

    def test_pkg_config_finds_the_plugin(self):
        flags = call("pkg-config", "--cflags", "--libs", "trefoil",
                     PKG_CONFIG_PATH=str(self.packages)).split()
        self.assertIn(f"-L{self.packages.parent}", [os.path.normpath(flag) for flag in flags])
        source = os.path.join(ROOT, "examples", "embed", "own_rule.c")
        program = os.path.join(self.folder.name, "own_rule")
        call("mpicc", source, "-o", program, *flags, "-lm",
             f"-Wl,-rpath,{self.packages.parent}")
        self.assertIn(str(self.packages.parent / "libtrefoil.so"), call("ldd", program))


if __name__ == "__main__":
    unittest.main(verbosity=2)
