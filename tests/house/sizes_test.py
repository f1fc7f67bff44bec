#!/usr/bin/python3
"""No room of more than 15 % of the lines of src/ and include/, no function of more than 80 lines, no
name of two types."""
import ast
import collections
import os
import re
import subprocess
import unittest

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
MOST_LINES, LARGEST_SHARE = 80, 0.15
NO_FUNCTION = re.compile(r"(namespace|class|struct|enum|union|extern|typedef|template <.*> struct)\b")


def sources(*suffixes):
    """Path below the root and lines of each file; `build` and what is hidden is no source."""
    for folder, folders, names in os.walk(ROOT):
        folders[:] = [name for name in folders if not name.startswith((".", "build", "out"))]
        for name in names:
            if name.endswith(suffixes):
                path = os.path.join(folder, name)
                with open(path, encoding="utf8") as file:
                    yield os.path.relpath(path, ROOT), file.read().split("\n")


def functions(lines):
    """First line and length of what looks like one in formatted C and C++: from the signature to the
    brace that closes at its indentation."""
    for end, line in enumerate(lines):
        indent = len(line) - len(line.lstrip())
        if indent > 4 or not line.endswith("{") and line.strip() != "{":
            continue
        begin = end
        while begin and lines[begin - 1].strip() and not re.search(r"[;{}:]$|^\s*(//|/?\*|#)",
                                                                  lines[begin - 1]):
            begin -= 1
        if "(" in "".join(lines[begin:end + 1]) and not NO_FUNCTION.match(lines[begin].strip()):
            closing = " " * indent + "}"
            for last in range(end, len(lines)):
                if lines[last].startswith(closing):
                    yield lines[begin].strip(), last - begin + 1
                    break


def types(lines):
    """Names, with that of the namespace, of what a header defines outside of other types."""
    namespace = ""
    for line in lines:
        opened = re.match(r"namespace ([\w:]+) \{", line)
        namespace = opened[1] if opened else namespace
        defined = re.match(r"(?:struct|class|enum class) (\w+)(?: final)?(?: : .*)? \{", line)
        if defined:
            yield f"{namespace}::{defined[1]}"


class Sizes(unittest.TestCase):
    def test_no_two_types_have_one_name(self):
        # The linker merges their functions, also those of the two libraries.
        first = {}
        for path, lines in sources(".hpp"):
            if not path.startswith(("src", "include")):
                continue
            for name in types(lines):
                self.assertNotIn(name, first, f"{path} and {first.get(name)}")
                first[name] = path
        self.assertGreater(len(first), 200)

    def test_no_function_is_long(self):
        seen = 0
        for path, lines in sources(".cpp", ".hpp", ".c", ".h"):
            for head, length in functions(lines):
                seen += 1
                self.assertLessEqual(length, MOST_LINES, f"{path}: {head}")
        for path, lines in sources(".py"):
            for node in ast.walk(ast.parse("\n".join(lines))):
                if isinstance(node, ast.FunctionDef):
                    seen += 1
                    self.assertLessEqual(node.end_lineno - node.lineno + 1, MOST_LINES,
                                         f"{path}: {node.name}")
        self.assertGreater(seen, 2000)

    def test_no_room_is_large(self):
        room_lines = collections.Counter()
        for path, lines in sources(".cpp", ".hpp", ".h"):
            if path.startswith(("src/", "include/")):
                room_lines[os.path.dirname(path)] += len(lines)
        for room, lines in room_lines.items():
            self.assertLessEqual(lines / room_lines.total(), LARGEST_SHARE, room)


class Format(unittest.TestCase):
    def test_clang_format_changes_nothing(self):
        try:
            subprocess.run(["clang-format", "--version"], check=True, stdout=subprocess.DEVNULL)
        except OSError:
            self.skipTest("clang-format is not installed")
        files = [path for path, _ in sources(".cpp", ".hpp")] + ["include/trefoil.h"]
        result = subprocess.run(["clang-format", "--dry-run", *files], cwd=ROOT, text=True,
                                stderr=subprocess.PIPE, check=True)
        self.assertEqual(result.stderr, "")


if __name__ == "__main__":
    unittest.main()
