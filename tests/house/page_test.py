#!/usr/bin/python3
"""Tables of options in the pages are the code's: the plugin's in include/README.md, a scene's in
examples/README.md. With --write they are made so."""
import ctypes
import os
import re
import subprocess
import sys
import unittest

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
LIBRARY = os.environ.get("TREFOIL_LIBRARY", os.path.join(ROOT, "build", "libtrefoil.so"))
PROGRAM = os.environ.get("TREFOIL_PROGRAM", os.path.join(ROOT, "build", "trefoil"))
PLUGIN_HEAD = "| option | default | |\n|---|---|---|\n"
SCENE_HEAD = "| key | unit | default | |\n|---|---|---|---|\n"


def code(text):
    return f"`{text}`" if text else ""


def escaped(text):
    return text.replace("|", "\\|")


def plugin_table():
    """Markdown, a row an option, from the lines `-name <default> - what it is` of the library."""
    lines = ctypes.c_char_p()
    assert ctypes.CDLL(LIBRARY).TrefoilGetOptionsManual(ctypes.byref(lines)) == 0
    rows = PLUGIN_HEAD
    for line in lines.value.decode().splitlines():
        name, default, what = re.fullmatch(r"-(\S+) <(.*?)> - (.*)", line).groups()
        rows += f"| `{name}` | {code(default)} | {escaped(what)} |\n"
    return rows


def scene_table():
    """Markdown, a row a key, from the lines of `trefoil --help keys`. The material of a region has the
    keys of `material`, which stand there once."""
    lines = subprocess.run([PROGRAM, "--help", "keys"], check=True, capture_output=True, text=True)
    rows, last_title = SCENE_HEAD, None
    for line in lines.stdout.splitlines():
        title, name, what, unit, default = line.split("\t")
        if title != last_title:
            rows += f"| **{title}** | | | |\n"
            last_title = title
        if name == "region_NAME_material_model":
            name, what = "region_NAME_material_*", "As `material_*`, from which they take what they do not say"
        elif name.startswith("region_NAME_material_"):
            continue
        rows += f"| `{name}` | {unit} | {code(default)} | {escaped(what)} |\n"
    return rows


TABLES = {
    os.path.join(ROOT, "include", "README.md"): (PLUGIN_HEAD, plugin_table),
    os.path.join(ROOT, "examples", "README.md"): (SCENE_HEAD, scene_table),
}


def split_page(path, head):
    """What stands before the table, the table, and what stands behind it."""
    with open(path, encoding="utf8") as file:
        page = file.read()
    begin = page.index(head)
    end = page.index("\n\n", begin) + 1
    return page[:begin], page[begin:end], page[end:]


class Page(unittest.TestCase):
    def test_the_options_are_the_codes(self):
        for path, (head, table) in TABLES.items():
            with self.subTest(os.path.relpath(path, ROOT)):
                self.assertEqual(split_page(path, head)[1], table(),
                                 "run tests/house/page_test.py --write")


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        for path, (head, table) in TABLES.items():
            before, _, behind = split_page(path, head)
            with open(path, "w", encoding="utf8") as page:
                page.write(before + table() + behind)
    else:
        unittest.main()
