#!/usr/bin/python3
"""Which room of src/ may include which: arrows point down this list only, so that there are no circles."""
import os
import re
import unittest

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "src")
ALLOWED = {  # from the bottom up; all may include include/trefoil
    "support": "", "simd": "", "filter": "simd", "rule": "", "mesh": "support", "mesh/io": "mesh support",
    "hook": "filter support", "search": "hook rule support",
    "snes": "filter hook rule search simd support", "contact": "filter", "material": "simd",
    "element": "simd", "term": "contact element filter material mesh support",
    "assembly": "contact element filter mesh simd support term", "time": "support term",
    "input": "mesh support term", "output": "mesh mesh/io support",
    "scene": "assembly contact element input mesh mesh/io output support term time",
    "solve": "assembly contact element input mesh output scene support term time",
    "program": "input output scene solve support"}
PRIVATE = {"hook", "rule", "search", "snes"}  # of libtrefoil.so; others have trefoil.h for it


class Arrows(unittest.TestCase):
    def test_no_room_includes_what_it_may_not(self):
        found = {room: set() for room in ALLOWED}
        for folder, _, names in os.walk(SOURCE):
            for name in (name for name in names if name.endswith((".cpp", ".hpp"))):
                room = os.path.relpath(folder, SOURCE)
                with open(os.path.join(folder, name), encoding="utf8") as file:
                    included = {os.path.dirname(path) for path in
                                re.findall(r'#include "(\w[\w/]*\.hpp)"', file.read())}
                self.assertIn(room, found, f"{name}: a room that the list does not have")
                found[room] |= included - {room, "trefoil"}
        for room, arrows in found.items():
            self.assertLessEqual(arrows, set(ALLOWED[room].split()), f"from src/{room}")

    def test_all_that_is_allowed_points_down(self):
        rooms = list(ALLOWED)
        for room, arrows in ALLOWED.items():
            self.assertLess({*arrows.split()}, {*rooms[:rooms.index(room)], None})
            self.assertFalse(PRIVATE & {*arrows.split()} and room not in PRIVATE)


if __name__ == "__main__":
    unittest.main()
