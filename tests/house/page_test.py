#!/usr/bin/python3
"""The table of options in include/README.md is the plugin's. With --write it is made so."""
import ctypes
import os
import re
import sys
import unittest

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
PAGE = os.path.join(ROOT, "include", "README.md")
LIBRARY = os.environ.get("TREFOIL_LIBRARY", os.path.join(ROOT, "build", "libtrefoil.so"))
HEAD = "| option | default | |\n|---|---|---|\n"


def table():
    """Markdown, a row an option, from the lines `-name <default> - what it is` of the library."""
    lines = ctypes.c_char_p()
    assert ctypes.CDLL(LIBRARY).TrefoilGetOptionsManual(ctypes.byref(lines)) == 0
    rows = HEAD
    for line in lines.value.decode().splitlines():
        name, default, what = re.fullmatch(r"-(\S+) <(.*?)> - (.*)", line).groups()
        what = what.replace("|", "\\|")
        rows += f"| `{name}` | {default and f'`{default}`'} | {what} |\n"
    return rows


def split_page():
    """What stands before the table, the table, and what stands behind it."""
    with open(PAGE, encoding="utf8") as file:
        page = file.read()
    begin = page.index(HEAD)
    end = page.index("\n\n", begin) + 1
    return page[:begin], page[begin:end], page[end:]


class Page(unittest.TestCase):
    def test_the_options_are_the_plugins(self):
        self.assertEqual(split_page()[1], table(), "run tests/house/page_test.py --write")


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        before, _, behind = split_page()
        with open(PAGE, "w", encoding="utf8") as page:
            page.write(before + table() + behind)
    else:
        unittest.main()
