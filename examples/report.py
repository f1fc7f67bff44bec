#!/usr/bin/python3
"""Writes a page to look at, from the record and the fields of a run of Trefoil: one file, for any
browser, without a network.

    python3 examples/report.py out/knot.json out/knot.xdmf -o out/knot.html
    python3 examples/report.py bracket.json bracket.xdmf --units "mm, N"

The body turns under the mouse, at rest or deformed, through all load or time steps, coloured by any
field; below it results, convergence, times, and what was run. Of large bodies and long series so
much is kept that the page stays below --size, and the page says so.
Debian: python3-numpy python3-h5py python3-matplotlib libjs-three
"""

import argparse
import html
import json
import os
import string
import sys
import xml.etree.ElementTree

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "python")]

try:
    import matplotlib
    import numpy as np

    import trefoil
    from fields import Units
    from obstacles import Obstacles
    from report_page import curves, results
    from report_page.body import Body
except ImportError as missing:
    sys.exit(f"report.py: {missing.name} is missing: apt install python3-numpy python3-h5py "
             "python3-matplotlib libjs-three, then use /usr/bin/python3")

THREE = "/usr/share/javascript/three"  # of libjs-three, where --three names no other
SCRIPTS = ("unpack.js", "body.js", "eye.js", "legend.js", "panel.js")
MAPS = {"viridis": "viridis", "cividis": "cividis", "magma": "magma", "diverging": "RdBu_r",
        "grey": "Greys_r"}


def read_part(name):
    with open(os.path.join(HERE, "report_page", name), encoding="utf-8") as file:
        return file.read()


def three_scripts(folder):
    """three.js and its camera controls, as plain scripts: modules are not allowed from a disk."""
    texts = []
    for name in ("three.min.js", "examples/js/controls/OrbitControls.js"):
        path = os.path.join(folder, name)
        try:
            with open(path, encoding="utf-8") as file:
                texts.append(file.read())
        except OSError as error:
            sys.exit(f"report.py: cannot read {path} ({error.strerror}): apt install libjs-three")
    return "\n".join(texts).replace("</script", "<\\/script")


def colour_maps():
    """256 colours each, as text of hexadecimal digits."""
    places = np.linspace(0, 1, 256)
    return {name: (matplotlib.colormaps[source](places)[:, :3] * 255).round().astype(np.uint8)
            .tobytes().hex() for name, source in MAPS.items()}


def viewer_parts(body):
    manifest = {**body.manifest, "maps": colour_maps()}
    # "<" could end the script element that holds it
    return {"manifest": json.dumps(manifest, separators=(",", ":")).replace("<", "\\u003c"),
            "pack": body.text}


def section(title, content):
    return f"<section><h2>{title}</h2>{content}</section>" if content else ""


def page(record, body, title, units, three):
    """The whole page."""
    classes, words = results.verdict(record)
    bad = "" if record["result"]["converged"] else " bad"
    step_charts = curves.step_charts(record, units)
    return string.Template(read_part("page.html")).substitute({
        "title": html.escape(title), "style": read_part("page.css"),
        "summary": results.summary(record), "verdict_class": classes, "verdict": words,
        "warnings": "".join(f'<p class="warning{bad}" role="alert">{results.sentence(sentence)}</p>'
                            for sentence in results.warnings(record)),
        "notes": "".join(f"<li>{html.escape(note)}</li>" for note in body.notes),
        "results": results.results_table(record, units), "time": results.time_bars(record),
        "forces": section("Forces", results.forces_tables(record, units)),
        "steps": section("Steps", f'<div class="charts">{step_charts}</div>' * bool(step_charts)
                         + results.steps_table(record)),
        "charts": curves.convergence_charts(record), "history": results.history_table(record),
        "run": results.what_was_run(record),
        "footer": "Made by Trefoil's examples/report.py; the body is drawn by three.js (MIT).",
        "three": three, "viewer": "".join(map(read_part, SCRIPTS)),
        **viewer_parts(body)})


def read_record(path):
    try:
        with open(path, encoding="utf-8") as file:
            record = json.load(file)
        for key in ("mesh", "solver", "result", "time", "history"):
            record[key]
        return record
    except OSError as error:
        sys.exit(f"report.py: cannot read {path}: {error.strerror}")
    except ValueError as error:
        sys.exit(f"report.py: {path} is not JSON: {error}")
    except (KeyError, TypeError) as error:
        sys.exit(f"report.py: {path} is no record of Trefoil's program: it lacks {error}")


def read_body(path, units, most_bytes, region_names):
    try:
        return Body(trefoil.read_steps(path), units, most_bytes, region_names, Obstacles(path))
    except (OSError, KeyError, ValueError, AttributeError,
            xml.etree.ElementTree.ParseError) as error:
        sys.exit(f"report.py: cannot read {path}: {error}")


def write(path, text):
    """Beside it first: what stands under the name is whole."""
    part = f"{path}.{os.getpid()}.part"
    try:
        with open(part, "w", encoding="utf-8") as file:
            file.write(text)
        os.replace(part, path)
    except OSError as error:
        if os.path.exists(part):
            os.remove(part)
        sys.exit(f"report.py: cannot write {path}: {error.strerror}")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("record", help="what -snes_trefoil_record wrote")
    parser.add_argument("xdmf", help="what -output_file wrote")
    parser.add_argument("-o", "--output", help="the page (default: beside the fields, .html)")
    parser.add_argument("--title", help="default: the name of the fields' file")
    parser.add_argument("--units", help="of length and force, such as 'mm, N': the program knows none")
    parser.add_argument("--size", type=float, default=20, help="of the page, at most [MB]")
    parser.add_argument("--three", default=THREE, help=f"folder of three.js (default {THREE})")
    arguments = parser.parse_args()
    arguments.output = arguments.output or os.path.splitext(arguments.xdmf)[0] + ".html"
    title = arguments.title or os.path.splitext(os.path.basename(arguments.xdmf))[0]
    try:
        units = Units(arguments.units)
    except ValueError as error:
        sys.exit(f"report.py: {error}")
    record, three = read_record(arguments.record), three_scripts(arguments.three)
    room = arguments.size * 1e6 - len(three) - 200e3 - 3 * os.path.getsize(arguments.record)
    if room < 100e3:
        sys.exit(f"report.py: a page of {arguments.size:g} MB has no room for a body; --size 3 has")
    regions = [region["name"] for region in record.get("regions") or []]
    body = read_body(arguments.xdmf, units, room, regions)
    write(arguments.output, page(record, body, title, units, three))


if __name__ == "__main__":
    main()
