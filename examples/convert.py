#!/usr/bin/python3
"""Writes the deformed body of an output of Trefoil (.xdmf) in another format, by the name's ending.

    python3 examples/convert.py knot.xdmf knot.msh      # Gmsh, with all fields; .vtk .vtu .mesh .inp ...
    python3 examples/convert.py knot.xdmf knot.obj      # its surface; .stl .ply .off
    python3 examples/convert.py beam.xdmf rest.mesh --rest
    python3 examples/convert.py beam.xdmf third.vtk --step 3

Vertices and cells stand in the order of the mesh that Trefoil read (see `original_vertex` where there
are more, or fewer). `meshio convert` does the same for the body at rest and a file of one step:

    meshio convert knot.xdmf knot.vtk                          # .mesh likewise; .obj of a plane body
    meshio convert knot.xdmf knot.msh --output-format gmsh

Debian: python3-numpy python3-h5py python3-meshio (and meshio-tools for the command)
"""

import argparse
import os
import sys
import xml.etree.ElementTree

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "python"))

try:
    import meshio
    import numpy as np

    import trefoil
    from surface import Surface
except ImportError as missing:
    sys.exit(f"convert.py: {missing.name} is missing: "
             "apt install python3-numpy python3-h5py python3-meshio, then use /usr/bin/python3")

CELLS = {3: "triangle", 4: "tetra", 6: "triangle6", 10: "tetra10"}
SURFACES = (".obj", ".stl", ".ply", ".off")
WITHOUT_FIELDS = (".mesh", *SURFACES)


def fail(sentence):
    sys.exit(f"convert.py: {sentence}")


def step_of(arguments):
    try:
        steps = trefoil.read_steps(arguments.output)
    except (OSError, ValueError, xml.etree.ElementTree.ParseError) as error:
        fail(f"cannot read '{arguments.output}': {error}")
    if arguments.step is None:
        return steps[-1]
    if not 1 <= arguments.step <= len(steps):
        fail(f"--step {arguments.step}: '{arguments.output}' has steps 1 to {len(steps)}")
    return steps[arguments.step - 1]


def surface_of(rest, moved, cells):
    """The surface alone: found at rest, where no cell is inverted. Of a plane body all vertices
    stay; of others those of the surface, in their order."""
    triangles = Surface(rest, cells).triangles
    if cells.shape[1] in (3, 6):
        return meshio.Mesh(moved, [("triangle", triangles)])
    used, corners = np.unique(triangles, return_inverse=True)
    return meshio.Mesh(moved[used], [("triangle", corners.reshape(-1, 3))])


def body_of(step, moved, with_fields):
    on_vertices, on_cells = {}, {}
    if with_fields:
        on_vertices = dict(step.vertex_fields)
        on_cells = {name: [values] for name, values in step.cell_fields.items()}
    cells = step.cells
    return meshio.Mesh(moved, [(CELLS[cells.shape[1]], cells)], on_vertices, on_cells)


def mesh_of(step, ending, arguments):
    moved = step.points
    if not arguments.rest and "displacement" in step.fields:
        moved = moved + arguments.scale * step.fields["displacement"]
    if ending in SURFACES:
        return surface_of(step.points, moved, step.cells)
    return body_of(step, moved, ending not in WITHOUT_FIELDS)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output", help="an .xdmf file that Trefoil wrote")
    parser.add_argument("target", help="the file to write; its ending is the format")
    parser.add_argument("--rest", action="store_true", help="the body at rest")
    parser.add_argument("--scale", type=float, default=1, help="factor on displacements (1)")
    parser.add_argument("--step", type=int, help="which step, from 1; the last without")
    arguments = parser.parse_args()
    ending = os.path.splitext(arguments.target)[1].lower()
    mesh = mesh_of(step_of(arguments), ending, arguments)
    try:
        mesh.write(arguments.target, file_format="gmsh" if ending == ".msh" else None)
    except (meshio.ReadError, meshio.WriteError, OSError, KeyError) as error:
        fail(f"cannot write '{arguments.target}': {error}")


if __name__ == "__main__":
    main()
