#!/usr/bin/python3
"""Input that makes no scene: one clear sentence from one rank, exit status 1 on all, nothing left.

The program is $TREFOIL; every case runs on one rank and on two.
"""

import concurrent.futures
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

TREFOIL = os.environ["TREFOIL"]
SECONDS = 60  # a rank that hangs fails the test

# What each rank says of itself: mpirun alone would report the first rank, and kill the others.
RANK = '"$@"; echo $? > "$STATUS_DIRECTORY/status.${OMPI_COMM_WORLD_RANK:-0}"'

TETS = "Tetrahedra 1\n1 2 3 4 0\n"
MEDIT = "MeshVersionFormatted 2\nDimension 3\n"
CORNERS = "0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n"
ONE_TET = MEDIT + "Vertices 4\n" + CORNERS + TETS + "End\n"
FAR_CORNERS = "5 0 0 0\n6 0 0 0\n5 1 0 0\n5 0 1 0\n"
# Tetrahedra 2 and 3 of four are of no use: one is flat, one is turned round.
TWO_BAD = (MEDIT + "Vertices 8\n" + CORNERS + FAR_CORNERS +
           "Tetrahedra 4\n1 2 3 4 0\n1 2 3 3 0\n1 3 2 4 0\n5 6 7 8 0\nEnd\n")
TWO_PARTS = (MEDIT + "Vertices 8\n" + CORNERS + FAR_CORNERS +
             "Tetrahedra 2\n1 2 3 4 0\n5 6 7 8 0\nEnd\n")
# The last vertex belongs to no tetrahedron.
UNUSED_VERTEX = TWO_PARTS.replace("Vertices 8\n", "Vertices 9\n").replace(
    "Tetrahedra", "9 9 9 0\nTetrahedra")
GMSH = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
NODES = "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"

FILES = {
    "empty.mesh": "",
    "truncated.mesh": ONE_TET[:60],
    "binary.mesh": bytes(range(256)) * 40,
    "zeros.msh": bytes(4096),
    "picture.mesh": "solid cube\n facet normal 0 0 1\n",
    "no_tets.mesh": MEDIT + "Vertices 4\n" + CORNERS + "End\n",
    "high_index.mesh": ONE_TET.replace("1 2 3 4 0", "1 2 3 5 0"),
    "zero_index.mesh": ONE_TET.replace("1 2 3 4 0", "0 1 2 3 0"),
    "fractional_index.mesh": ONE_TET.replace("1 2 3 4 0", "1 2 3 4.5 0"),
    "nan.mesh": ONE_TET.replace("0 0 1 0", "0 0 nan 0"),
    "huge_count.mesh": ONE_TET.replace("Vertices 4", "Vertices 4000000000"),
    "minus_count.mesh": ONE_TET.replace("Vertices 4", "Vertices -4"),
    "flat.mesh": MEDIT + "Dimension 2\nVertices 1\n0 0 0\n",
    "hexahedra.mesh": ONE_TET.replace("End", "Hexahedra 1\n1 2 3 4 1 2 3 4 0\nEnd"),
    "old.msh": "$MeshFormat\n4.0 0 8\n$EndMeshFormat\n",
    "truncated.msh": GMSH + NODES[:30],
    "undefined_node.msh": GMSH + NODES + "$Elements\n1\n1 4 2 0 1 1 2 3 7\n$EndElements\n",
    "quadratic.msh": GMSH + NODES + "$Elements\n1\n1 11 2 0 1 1 2 3 4 1 2 3 4 1 2\n$EndElements\n",
    "two_bad.mesh": TWO_BAD,
    "all_bad.mesh": ONE_TET.replace("1 2 3 4 0", "1 2 3 3 0"),
    "two_parts.mesh": TWO_PARTS,
    "unused.mesh": UNUSED_VERTEX,
    "one_tet.mesh": ONE_TET,
    "plain_file": "a file, not a directory\n",
    "open_bracket.yaml": "mesh: {generate: box\nconstraints: [\n",
    "tab.yaml": "mesh:\n\tgenerate: box\n",
    "list.yaml": "- mesh\n- material\n",
    "parts_in_a_list.yaml": "mesh: {generate: box}\nconstraints:\n  - where: \"z == zmin\"\n",
    "twice.yaml": "material: {young: 1}\nmesh: {generate: box}\nmaterial: {poisson: 0.3}\n",
    "both_forms.yaml": ("constraints: {low: {where: \"z == zmin\"}}\n"
                        "constraint: {low: {move: \"0, 0, 1\"}}\n"),
    "one_option_twice.yaml": "snes_type: trefoil\nsnes: {type: newtonls}\n",
    "young.yaml": "mesh: {generate: box}\nyoung: 1e6\n",
    "gravity.yaml": "mesh: {generate: box}\ngravity: \"0, 0, -9.81\"\n",
    "symbols.yaml": "mesh: {generate: box}\nmaterial: {E: 1e6, nu: 0.3}\n",
    "mesh_as_text.yaml": "mesh: horse.msh\n",
    "load_not_listed.yaml": ("mesh: {generate: box}\n"
                             "load: {top: {where: \"z == zmax\", traction: \"0, 0, 1\"}}\n"),
    "region_not_listed.yaml": "mesh: {generate: box}\nregion: {core: {group: 1}}\n",
    "load_called_gravity.yaml": "mesh: {generate: box}\nloads: {gravity: \"0, 0, -9.81\"}\n",
    "two_documents.yaml": "mesh: {generate: box}\n---\nmesh: {generate: knot}\n",
    "includes.yaml": "options_file: tab.yaml\n",
    "empty_section.yaml": "mesh: {generate: box}\nconstraints: {low: {where: \"z == zmin\"}}\ncontact: {}\n",
    "blank_in_a_name.yaml": "constraints: {my wall: {where: \"z == zmin\"}}\n",
    "nothing.yaml": "",
    "only_comment.yaml": "# nothing yet\n",
    "flie.yaml": "mesh: {flie: horse.mesh}\n",
    "poison.yaml": "mesh: {generate: box}\nmaterial: {poison: 0.3}\n",
    "fliter.yaml": ("mesh: {generate: box}\nconstraints: low\n"
                    "constraint:\n  low: {where: \"z == zmin\"}\nsnes: {trefoil_fliter: clamp}\n"),
    "hnid.yaml": ("mesh: {generate: box}\nconstraints: hind\n"
                  "constraint:\n  hind: {where: \"z == zmin\"}\n  hnid: {move: \"0, 0, 1\"}\n"),
    "two_a_line.petsc": "-mesh_generate box -mesh_refine 1\n",
    "yaml_by_another_name.txt": "mesh: {generate: box}\n",
    "begins_as_yaml": "---\nmesh: {flie: horse.mesh}\n",
    "right.petsc": "# the cube\n\n-mesh_generate box # stands\n-constraints low\n"
                   "\t-constraint_low_where \"z == zmin\"\n-snes_monitor\n",
    "right.yaml": "mesh: {generate: box}\nconstraints: {low: {where: \"z == zmin\"}}\n",
    "horse.mesh": ONE_TET,
}

# A scene that is right: a small cube that stands on the ground. Cases change it.
RIGHT = {"mesh_generate": "box", "mesh_resolution": "2", "constraints": "low",
         "constraint_low_where": "z == zmin", "snes_trefoil_record": "run.json",
         "output_file": "run.xdmf"}


def scene(**changes):
    """The arguments of the scene with some options changed; None takes one away."""
    generated = {"mesh_generate": None, "mesh_resolution": None} if "mesh_file" in changes else {}
    options = {**RIGHT, **generated, **changes}
    arguments = []
    for name, value in options.items():
        if value is not None:
            arguments += ["-" + name, value]
    return arguments


def low(**changes):
    """The scene with the parts of its constraint changed."""
    return scene(**{"constraint_low_" + part: value for part, value in changes.items()})


def two(where, move, first="0, 0, 0"):
    """The scene with a second constraint."""
    return scene(constraints="low,second", constraint_low_move=first,
                 constraint_second_where=where, constraint_second_move=move)


def mesh(name, **changes):
    return scene(mesh_file="../inputs/" + name, **changes)


def options_file(name):
    return ["-options_file", "../inputs/" + name]


NEWTONLS = ["-snes_type", "newtonls", "-snes_linesearch_type", "bt"]

# name, arguments, what the sentence must contain
MESHES = [
    ("no such mesh", mesh("nowhere.mesh"), ["nowhere.mesh", "no such file"]),
    ("mesh is a directory", scene(mesh_file="../inputs"), ["../inputs", "directory"]),
    ("empty mesh", mesh("empty.mesh"), ["empty.mesh", "is empty"]),
    ("truncated Medit", mesh("truncated.mesh"), ["truncated.mesh"]),
    ("truncated Gmsh", mesh("truncated.msh"), ["truncated.msh"]),
    ("binary garbage", mesh("binary.mesh"), ["binary.mesh", "format"]),
    ("zeros", mesh("zeros.msh"), ["zeros.msh", "format"]),
    ("another format", mesh("picture.mesh"), ["picture.mesh", "format"]),
    ("a scene as mesh", mesh("poison.yaml"), ["poison.yaml", "format"]),
    ("old Gmsh", mesh("old.msh"), ["old.msh", "'4.0'", "2.2 and 4.1"]),
    ("no tetrahedra", mesh("no_tets.mesh"), ["no_tets.mesh", "no Tetrahedra"]),
    ("index too high", mesh("high_index.mesh"), ["high_index.mesh", "vertex 5", "1 to 4"]),
    ("index too low", mesh("zero_index.mesh"), ["zero_index.mesh", "vertex 0"]),
    ("index a fraction", mesh("fractional_index.mesh"), ["fractional_index.mesh", "4.5"]),
    ("undefined node", mesh("undefined_node.msh"), ["undefined_node.msh", "node 7"]),
    ("quadratic tetrahedra", mesh("quadratic.msh"), ["quadratic.msh", "tetrahedron 1", "Jacobian"]),
    ("hexahedra", mesh("hexahedra.mesh"), ["hexahedra.mesh", "Hexahedra"]),
    ("coordinate not a number", mesh("nan.mesh"), ["nan.mesh", "vertex 4", "not finite"]),
    ("count too high", mesh("huge_count.mesh"), ["huge_count.mesh", "4000000000"]),
    ("count negative", mesh("minus_count.mesh"), ["minus_count.mesh", "-4"]),
    ("flat mesh", mesh("flat.mesh"), ["flat.mesh"]),
    ("bad tetrahedra", mesh("two_bad.mesh"),
     ["two_bad.mesh", "1 tetrahedron is degenerate", "1 tetrahedron is of negative volume",
      "tetrahedron 2", "-mesh_repair drop"]),
    ("only bad tetrahedra", mesh("all_bad.mesh", mesh_repair="drop"),
     ["all_bad.mesh", "nothing is left"]),
    ("unknown repair", mesh("two_bad.mesh", mesh_repair="fix"), ["-mesh_repair", "'fix'", "drop"]),
    ("two meshes", mesh("one_tet.mesh", mesh_generate="box"),
     ["-mesh_file", "-mesh_generate", "has one mesh"]),
    ("unknown kind", scene(mesh_generate="torus"), ["torus", "box", "knot"]),
    ("negative resolution", scene(mesh_resolution="-2"), ["-mesh_resolution", "negative"]),
    ("fractional resolution", scene(mesh_resolution="2.5"), ["-mesh_resolution", "2.5"]),
    ("resolution in words", scene(mesh_resolution="two"), ["-mesh_resolution", "'two'"]),
    ("resolution too high", scene(mesh_resolution="100000"), ["resolution 100000"]),
    ("resolution beyond integers", scene(mesh_resolution="1e300"), ["-mesh_resolution", "1e+300"]),
    ("resolution of a file", mesh("one_tet.mesh", mesh_resolution="3"), ["-mesh_resolution"]),
    ("negative refinement", scene(mesh_refine="-1"), ["-mesh_refine", "negative"]),
    ("refined too often", mesh("one_tet.mesh", mesh_refine="40",
                               constraint_low_where="z < 1"), ["-mesh_refine 40", "refine less"]),
    ("normalize in words", scene(mesh_normalize="perhaps"), ["-mesh_normalize", "'perhaps'"]),
    ("unknown partitioner", scene(mesh_partitioner="scissors"), ["-mesh_partitioner", "scissors"]),
]

CONSTRAINTS = [
    ("malformed", low(where="z < (zmin"), ["-constraint_low_where", "z < (zmin"]),
    ("nonsense", low(where="the bottom"), ["-constraint_low_where", "the bottom"]),
    ("unknown name", low(where="w < 1"), ["-constraint_low_where", "w < 1"]),
    ("assignment", low(where="x = 3"), ["-constraint_low_where", "x = 3", "=="]),
    ("assignment with operator", low(where="x += 3"), ["-constraint_low_where", "x += 3"]),
    ("malformed move", low(move="0, 0, 1 +"), ["-constraint_low_move", "0, 0, 1 +"]),
    ("infinite", low(move="0, 0, 1/0"), ["-constraint_low_move", "1/0", "not finite"]),
    ("imaginary", low(move="sqrt(-1), 0, 0"), ["-constraint_low_move", "sqrt(-1)", "not finite"]),
    ("logarithm", low(move="0, log(0), 0"), ["-constraint_low_move", "log(0)", "not finite"]),
    ("infinite choice", low(where="1/(x - 0.5)"), ["-constraint_low_where", "not finite"]),
    ("two values", low(move="0, 0"), ["-constraint_low_move", "2 values", "3"]),
    ("four values", low(move="0, 0, 0, 0"), ["-constraint_low_move", "4 values", "3"]),
    ("choice of two values", low(where="x < 1, y < 1"),
     ["-constraint_low_where", "2 values", "1 is wanted", "&&"]),
    ("and", low(where="z == zmin and x < 1"), ["-constraint_low_where", "write && for and"]),
    ("or", low(where="z == zmin or x < 1"), ["-constraint_low_where", "|| for or"]),
    ("power", low(where="x**2 < 1"), ["-constraint_low_where", "write ^ for a power"]),
    ("power of a move", low(move="x**2, 0, 0"), ["-constraint_low_move", "write ^ for a power"]),
    ("radius", low(where="r < 1"), ["-constraint_low_where", "a formula has x, y, z, t, xmin"]),
    ("tolerance", scene(where_tolerance="-1"), ["-where_tolerance is -1"]),
    ("free choice", low(where="free"), ["-constraint_low_where", "free"]),
    ("scaled free", low(move="2*free, 0, 0"), ["-constraint_low_move", "2*free"]),
    ("no vertex", low(where="z < zmin - 1"), ["'low'", "no vertex", "-constraint_low_where"]),
    ("no choice", low(where=None), ["'low'", "-constraint_low_where"]),
    ("choice without value", low(where=None) + ["-constraint_low_where"],
     ["-constraint_low_where", "without a value"]),
    ("value taken for an option", low(move=None) + ["-constraint_low_move", "-x, 0, 0"],
     ["-constraint_low_move", "-(x)"]),
    ("disagree", two("x == xmin", "0, 0, 0.1"), ["'low'", "'second'", "differently in z"]),
    ("named twice", scene(constraints="low,low"), ["-constraints", "'low'", "twice"]),
    ("not named", scene(constraint_high_where="z == zmax", constraint_high_move="0, 0, 1"),
     ["-constraint_high_", "-constraints"]),
    ("nothing held", scene(constraints=None, constraint_low_where=None), ["6 of 6", "rigid"]),
    ("one vertex", low(where="x + y + z == 0"), ["3 of 6", "rigid"]),
    ("one edge", low(where="(x == 0) && (y == 0)"), ["1 of 6", "rigid"]),
    ("sliding plane", low(move="free, free, 0"), ["3 of 6", "rigid"]),
    ("all components free", low(move="free, free, free"), ["6 of 6", "rigid"]),
    ("one part held", mesh("two_parts.mesh", constraint_low_where="x < 2"),
     ["1 of the mesh's 2 unconnected parts", "6 of 6"]),
    ("everything held", low(where="1"), ["every vertex"]),
    ("only unused vertices", mesh("unused.mesh", constraint_low_where="x > 8"),
     ["'low'", "no vertex"]),
    ("moved beyond numbers", low(move="1e200*x, 0, 0"), ["not finite", "constraints"]),
]

MATERIALS = [
    ("unknown material", scene(material_model="rubber"), ["-material_model", "rubber"]),
    ("unknown constants", scene(material_lame="lame"), ["-material_lame", "'lame'", "physical"]),
    *((f"nu {nu}", scene(material_poisson=nu), ["-material_poisson", nu])
      for nu in ("0.5", "0.7", "-1", "-2", "half", "nan", "inf", "0.3x", "1e999")),
    *((f"E {E}", scene(material_young=E), ["-material_young", E])
      for E in ("0", "-1", "soft", "nan", "inf", "1e6 Pa", "1,000")),
    ("nu missing", scene() + ["-material_poisson"], ["-material_poisson", "not a number"]),
    ("raw with negative nu", scene(material_poisson="-0.2", material_lame="raw"),
     ["-material_lame raw", "-0.2"]),
    ("raw of another model", scene(material_model="arap", material_lame="raw"),
     ["-material_model arap", "raw"]),
    ("volume of a model without", scene(material_model="corotated", material_volume="1"),
     ["-material_model corotated", "volume"]),
    ("negative volume", scene(material_model="arap", material_volume="-1"),
     ["-material_model arap", "-1", "no least value"]),
    ("no least energy", scene(material_model="neo_hookean", material_poisson="-0.2"),
     ["-material_model neo_hookean", "negative Poisson's ratio"]),
    ("mu without lambda", scene(material_mu="1e6"), ["-material_mu", "-material_lambda"]),
    ("mu beside nu", scene(material_mu="1e6", material_lambda="1e6", material_poisson="0.3"),
     ["-material_mu", "-material_poisson"]),
    ("negative mu", scene(material_mu="-1", material_lambda="1"), ["-material_mu", "-1"]),
    ("second invariant", scene(material_second_invariant="2"), ["second_invariant", "2"]),
    ("second invariant of a model without",
     scene(material_model="arap", material_second_invariant="0.3"),
     ["-material_model arap", "second_invariant"]),
    ("negative density", scene(material_density="-1"), ["-material_density", "-1"]),
]


def region(**changes):
    """The scene with a region, some of whose options are changed."""
    options = {"where": "z > 0.4", **changes}
    return scene(regions="top", **{"region_top_" + name: value for name, value in options.items()})


def load(**changes):
    """The scene with a load on top, some of whose options are changed."""
    options = {"where": "z == zmax", "traction": "0, 0, 1", **changes}
    return scene(loads="top", **{"load_top_" + name: value for name, value in options.items()})


REGIONS_AND_LOADS = [
    ("region nowhere", scene(regions="top"), ["'top'", "-region_top_where", "-region_top_group"]),
    ("region twice chosen", region(group="5"), ["'top'", "-region_top_group"]),
    ("empty region", region(where="z > 3"), ["'top'", "no cell", "z > 3"]),
    ("group of a mesh without", region(where=None, group="5"), ["-region_top_group", "'5'"]),
    ("unknown group", region(where=None, group="bone"), ["'bone'", "it names none"]),
    ("overlapping regions", region() + ["-regions", "top,all", "-region_all_where", "1"],
     ["'top' and 'all'", "rest position"]),
    ("region named twice", region() + ["-regions", "top,top"], ["'top' twice"]),
    ("malformed region", region(where="z >"), ["-region_top_where", "z >"]),
    ("free region", region(where="free"), ["-region_top_where", "free"]),
    ("region's material", region(material_model="jelly"), ["-region_top_material_model", "jelly"]),
    ("region's Poisson", region(material_poisson="0.5"), ["-region_top_material_poisson", "0.5"]),
    ("region's misspelt", region(material_yung="1"), ["-region_top_material_young"]),
    ("load without a place", load(where=None), ["'top'", "-load_top_where"]),
    ("load without a traction", load(traction=None),
     ["'top'", "-load_top_traction", "-load_top_force", "-load_top_pressure"]),
    ("pressure of three values", load(traction=None, pressure="0, 0, 1"),
     ["-load_top_pressure", "3 values"]),
    ("force of one value", load(traction=None, force="1"), ["-load_top_force", "1 value,"]),
    ("load nowhere", load(where="z > 3"), ["'top'", "no facet", "z > 3"]),
    ("load inside", load(where="z == 0.5"), ["'top'", "no facet"]),
    ("load of two values", load(traction="0, 1"), ["-load_top_traction", "2 values"]),
    ("free load", load(traction="0, free, 1"), ["-load_top_traction", "free"]),
    ("malformed load", load(traction="0, 0, ("), ["-load_top_traction"]),
    ("load named twice", load() + ["-loads", "top,top"], ["'top' twice"]),
    ("no steps", scene(load_steps="0"), ["-load_steps is 0"]),
    ("steps of nothing", scene(load_steps="3"), ["-load_steps 3", "nothing is moved or loaded"]),
    ("other vertices", low(where="z <= t/2", move="0, 0, t") + ["-load_steps", "2"],
     ["other vertices", "depend on t"]),
    ("steps too long", low(where="abs(z - 0.5) == 0.5", move="0, 0, -1.5*z*t") +
     ["-load_steps", "2", "-initial", "rest", "-material_model", "neo_hookean"],
     ["invert", "more -load_steps than 2"]),
    ("gravity without mass", scene(load_gravity="0, 0, -9.81"), ["-material_density"]),
    ("gravity of two values", scene(load_gravity="0, -9.81", material_density="1"),
     ["-load_gravity", "2 values"]),
]

OPTIONS = [
    ("no mesh", ["-material_young", "1"], ["no mesh", "-mesh_file"]),
    ("no such scene file", ["scene.yaml"], ["'scene.yaml'", "check its name"]),
    ("scene file behind an option", scene() + ["-mesh_normalize", "true", "scene.yaml"],
     ["'scene.yaml'", "scene files come first"]),
    ("value without quotes", low(move="0,") + ["0,", "0"], ["'0,'", "quotes"]),
    ("-young", scene(young="1e6"), ["-young", "-material_young", "material: {young: ...}"]),
    ("-ksp_typ", scene(ksp_typ="cg"), ["-ksp_typ;", "check its name"]),
    ("-ksp_typ of a moved body", low(where="abs(z - 0.5) == 0.5", move="0, 0, 0.5*z") +
     ["-ksp_typ", "cg", "-snes_max_it", "5"], ["-ksp_typ;", "check its name"]),
    ("-mesh_flie", scene(mesh_flie="horse.mesh"), ["-mesh_flie", "-mesh_file"]),
    ("-msh_file", scene(mesh_generate=None, mesh_resolution=None, msh_file="horse.mesh"),
     ["-msh_file", "-mesh_file"]),
    ("-snes_trefoil_fliter", scene(snes_trefoil_fliter="clamp"), ["-snes_trefoil_fliter"]),
    ("-snes_trefoil_fliter, newtonls", scene(snes_trefoil_fliter="clamp") + NEWTONLS,
     ["-snes_trefoil_fliter"]),
    ("-mesh_flie, newtonls", scene(mesh_flie="horse.mesh") + NEWTONLS, ["-mesh_flie"]),
    ("-constraint_hnid_where", scene(constraint_hnid_where="x < 0"), ["-constraint_hnid_where"]),
    ("-constraint_low_wehre", scene(constraint_low_wehre="x < 0"),
     ["-constraint_low_wehre", "-constraint_low_where"]),
    ("-material_poison", scene(material_poison="0.3"), ["-material_poison", "-material_poisson"]),
    ("-matreial_young", scene(matreial_young="0.3"), ["-matreial_young", "-material_young"]),
    ("-constrain", scene(constrain="low"), ["-constrain", "-constraints"]),
    ("-outptu_file", scene(outptu_file="a.xdmf"), ["-outptu_file", "-output_file"]),
    ("unknown filter", scene(snes_trefoil_filter="clmap"), ["clmap", "clamp", "absolute"]),
    ("unknown filter, newtonls", scene(snes_trefoil_filter="clmap") + NEWTONLS, ["clmap"]),
    ("unknown search", scene(snes_trefoil_search="wolfe"), ["wolfe", "armijo"]),
    ("weight without its filter", scene(snes_trefoil_weight="0.3"), ["-snes_trefoil_weight"]),
    ("negative tolerance", scene(snes_trefoil_energy_tolerance="-1"),
     ["-snes_trefoil_energy_tolerance"]),
    ("too many corrections", scene(snes_trefoil_corrections="2147483648"),
     ["-snes_trefoil_corrections is 2147483648"]),
    ("no step at all", scene(snes_linesearch_damping="0"), ["-snes_linesearch_damping is 0"]),
    ("misspelt shrink", scene(snes_linesearch_shrinc="0.5"), ["-snes_linesearch_shrinc"]),
    ("misspelt shrink, newtonls", scene(snes_linesearch_shrinc="0.5") + NEWTONLS,
     ["-snes_linesearch_shrinc"]),
    ("misspelt -guess_pc_type", low(move="0.1*y, 0, 0") + ["-guess_pc_typ", "jacobi"],
     ["-guess_pc_typ;"]),
    ("solver of no guess", scene(initial="rest", guess_pc_type="jacobi"), ["-guess_pc_type;"]),
    ("another line search", scene(snes_linesearch_type="bt"), ["'bt'", "newtonls"]),
    ("cubic elements", scene(order="3"), ["-order", "3"]),
    ("unknown space", scene(snes_trefoil_space="strain"), ["-snes_trefoil_space", "strain"]),
    ("quadrature points of a host", scene(snes_trefoil_space="deformation", assembly="hook"),
     ["-snes_trefoil_space", "deformation", "use"]),
    ("three displacements in the plane",
     scene(mesh_generate="square", constraint_low_where="y == ymin",
           constraint_low_move="0, 0, 0"), ["-constraint_low_move", "3 values", "2 are wanted"]),
    ("loose in the plane", scene(mesh_generate="square", constraint_low_where="y == ymin",
                                 constraint_low_move="free, 0"), ["of 3 rigid-body modes"]),
    ("unknown start", scene(initial="nonsense"), ["-initial", "nonsense"]),
    *((f"steps of {start}", scene(initial=start, initial_steps="5"), ["-initial_steps", start])
      for start in ("rest", "harmonic")),
    ("start without displacement", scene(initial="expression"), ["-initial_displacement"]),
    ("displacement without its start", scene(initial_displacement="0, 0, z"),
     ["-initial_displacement", "-initial expression"]),
    ("start with two values", scene(initial="expression", initial_displacement="0, z"),
     ["-initial_displacement", "2 values"]),
    ("free start", scene(initial="expression", initial_displacement="0, 0, free"),
     ["-initial_displacement", "free"]),
    ("unknown -snes_type", scene(snes_type="nosuch"), ["nosuch"]),
    ("-snes_type without record", scene(snes_type="qn"), ["-snes_type qn", "trefoil"]),
    ("-snes_max_it negative", scene(snes_max_it="-1"), ["-snes_max_it", "-1"]),
    ("unknown -snes_linesearch_type", scene(snes_linesearch_type="nosuch"), ["nosuch"]),
    ("unknown -pc_type", scene(pc_type="nosuch"), ["nosuch"]),
    ("unknown -ksp_type", scene(ksp_type="nosuch"), ["nosuch"]),
    ("unknown factorization", scene(pc_factor_mat_solver_type="nosuch"), ["nosuch"]),
    ("-snes_max_it in words", scene(snes_max_it="many"), ["many"]),
    ("no such plugin", scene(dll_append="/nowhere.so"), ["/nowhere.so"]),
    ("no such options file", options_file("nowhere.yaml"), ["nowhere.yaml"]),
    ("options file not named", ["-options_file"], ["-options_file"]),
    ("open bracket", options_file("open_bracket.yaml"), ["open_bracket.yaml"]),
    ("tabulator", options_file("tab.yaml"), ["tab.yaml", "line 2", "tabulator"]),
    ("list of options", options_file("list.yaml"), ["list.yaml", "line 1", "keys and values"]),
    ("parts in a list", options_file("parts_in_a_list.yaml"),
     ["parts_in_a_list.yaml", "line 3", "constraints: {NAME: {...}}"]),
    ("section twice", options_file("twice.yaml"), ["line 3", "'material'", "twice", "line 1"]),
    ("nested and listed", options_file("both_forms.yaml"), ["line 2", "'low'", "constraints"]),
    ("option twice", options_file("one_option_twice.yaml"), ["line 2", "-snes_type", "line 1"]),
    ("two documents", options_file("two_documents.yaml"), ["second document"]),
    ("file in a file", options_file("includes.yaml"), ["trefoil one.yaml two.yaml"]),
    ("empty section", options_file("empty_section.yaml"), ["no option -contact "]),
    ("blank in a name", options_file("blank_in_a_name.yaml"), ["'constraint_my wall_where'"]),
    ("young in YAML", options_file("young.yaml"), ["-young", "material: {young: ...}"]),
    ("gravity in YAML", options_file("gravity.yaml"), ["-gravity", "load: {gravity: ...}"]),
    ("E and nu", options_file("symbols.yaml"), ["-material_E", "material: {young: ...}"]),
    ("mesh: horse.msh", options_file("mesh_as_text.yaml"), ["-mesh ", "mesh: {file: ...}"]),
    ("load not listed", options_file("load_not_listed.yaml"),
     ["-load_top_", "no load 'top'", "loads: {top: {...}}"]),
    ("region not listed", options_file("region_not_listed.yaml"),
     ["-region_core_group", "no region 'core'", "regions: {core: {...}}"]),
    ("load called gravity", options_file("load_called_gravity.yaml"),
     ["'gravity' is no name for a load", "load: {gravity: ...}"]),
    ("empty file", options_file("nothing.yaml"), ["no mesh"]),
    ("comments only", options_file("only_comment.yaml"), ["no mesh"]),
    ("two options a line", options_file("two_a_line.petsc"), ["two_a_line.petsc", "line 1"]),
    ("YAML by another name", options_file("yaml_by_another_name.txt"),
     ["yaml_by_another_name.txt", "line 1", ".yaml"]),
    ("YAML by its beginning", options_file("begins_as_yaml"), ["-mesh_flie"]),
    ("right file, wrong file", options_file("right.petsc") + options_file("nowhere"), ["nowhere"]),
    ("directory of options", ["-options_file", "../inputs"], ["../inputs", "directory"]),
    ("YAML directory", ["-options_file", "../directory.yaml"], ["directory.yaml"]),
    ("mesh_flie in YAML", options_file("flie.yaml"), ["-mesh_flie", "-mesh_file"]),
    ("poison in YAML", options_file("poison.yaml"), ["-material_poison", "-material_poisson"]),
    ("fliter in YAML", options_file("fliter.yaml"), ["-snes_trefoil_fliter"]),
    ("hnid in YAML", options_file("hnid.yaml"), ["-constraint_hnid_move"]),
]

BELOW_FILE = "../inputs/plain_file/"

OUTPUTS = [
    ("no directory", scene(output_file="nowhere/run.xdmf"), ["nowhere/run.xdmf", "directory"]),
    ("below a file", scene(output_file=BELOW_FILE + "run.xdmf"), ["plain_file", "directory"]),
    ("directory in the way", scene(output_file="../directory.xdmf"),
     ["../directory.xdmf", "directory"]),
    ("directory in the data's way", scene(output_file="../data.xdmf"), ["../data.h5", "directory"]),
    ("another ending", scene(output_file="run.vtk"), ["run.vtk", ".xdmf"]),
    ("no name", scene(output_file=None) + ["-output_file"], ["-output_file", "without a value"]),
    ("record without directory", scene(snes_trefoil_record="nowhere/run.json"),
     ["nowhere/run.json", "No such file or directory"]),
    ("record below a file", scene(snes_trefoil_record=BELOW_FILE + "run.json"),
     ["plain_file/run.json", "Not a directory"]),
    ("record is a directory", scene(snes_trefoil_record="../inputs"),
     ["../inputs", "directory"]),
    ("record over the output", scene(snes_trefoil_record="run.xdmf"),
     ["-snes_trefoil_record", "run.xdmf"]),
    ("record over the data", scene(snes_trefoil_record="./run.h5"),
     ["-snes_trefoil_record", "run.h5"]),
    ("record over the scene", ["../inputs/right.yaml", "-snes_trefoil_record",
                               "../inputs/right.yaml"], ["-snes_trefoil_record", "right.yaml"]),
    ("record over PETSc's options", options_file("right.petsc") +
     ["-snes_trefoil_record", "../inputs/right.petsc"], ["-snes_trefoil_record", "right.petsc"]),
    ("record over the mesh", mesh("horse.mesh", snes_trefoil_record="../inputs/horse.mesh",
                                  constraint_low_where="z < 1"),
     ["-snes_trefoil_record", "horse.mesh"]),
]


class Run:
    """One run of the program in an empty directory; texts and statuses of all ranks."""

    def __init__(self, place, ranks, arguments):
        with tempfile.TemporaryDirectory(dir=place) as statuses, \
                tempfile.TemporaryDirectory(dir=place) as directory:
            command = ["sh", "-c", RANK, "sh", TREFOIL, *arguments]
            if ranks > 1:
                command = ["mpirun", "-n", str(ranks), *command]
            is_root = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
            environment = {**os.environ, **is_root, "STATUS_DIRECTORY": statuses,
                           "OMPI_MCA_rmaps_base_oversubscribe": "1",
                           "OMPI_MCA_mpi_yield_when_idle": "1"}
            done = subprocess.run(command, cwd=directory, env=environment, timeout=SECONDS,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                  stdin=subprocess.DEVNULL, text=True, errors="replace")
            self.text, self.errors = done.stdout + done.stderr, done.stderr
            self.statuses = [int(file.read_text()) for file in pathlib.Path(statuses).iterdir()]
            self.files = sorted(file.name for file in pathlib.Path(directory).iterdir())
            record = pathlib.Path(directory, "run.json")
            self.record = json.loads(record.read_text()) if record.exists() else None


class WithInputs(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.place = pathlib.Path(temporary.name)
        for name in ("inputs", "directory.xdmf", "data.h5", "directory.yaml"):
            (self.place / name).mkdir()
        for name, content in FILES.items():
            data = content if isinstance(content, bytes) else content.encode()
            (self.place / "inputs" / name).write_bytes(data)

    def run_on(self, ranks, arguments):
        return Run(self.place, ranks, arguments)

    def files(self):
        """Every file outside of the runs' own directories, with its content."""
        return {file: file.read_bytes() for file in self.place.rglob("*") if file.is_file()}


class BadInput(WithInputs):
    def check_refused(self, run, ranks, words):
        self.assertEqual(run.statuses, [1] * ranks, run.text)
        sentences = [line for line in run.text.splitlines() if line.startswith("trefoil: ")]
        self.assertEqual(len(sentences), 1, run.text)
        for word in words:
            self.assertIn(word, sentences[0])
        # Nor does a second half of the sentence follow on a line of its own.
        self.assertEqual(run.errors.splitlines(), sentences, run.text)
        for noise in ("PETSC ERROR", "terminate called", "MPI_ABORT", "Segmentation"):
            self.assertNotIn(noise, run.text)
        self.assertEqual(run.files, [], "left behind")

    def check_all(self, cases, all_ranks=(1, 2)):
        before = self.files()
        table = [(ranks, *case) for case in cases for ranks in all_ranks]
        # Most of a run is MPI's waiting: several at once.
        with concurrent.futures.ThreadPoolExecutor(max_workers=3) as pool:
            runs = [pool.submit(self.run_on, ranks, arguments) for ranks, _, arguments, _ in table]
            for (ranks, name, _, words), run in zip(table, runs):
                with self.subTest(name, ranks=ranks):
                    self.check_refused(run.result(), ranks, words)
        self.assertEqual(self.files(), before)

    def test_meshes(self):
        self.check_all(MESHES)

    def test_constraints(self):
        self.check_all(CONSTRAINTS)

    def test_materials(self):
        self.check_all(MATERIALS)

    def test_regions_and_loads(self):
        self.check_all(REGIONS_AND_LOADS)

    def test_options(self):
        self.check_all(OPTIONS)

    def test_outputs(self):
        self.check_all(OUTPUTS)

    def test_more_ranks_than_tetrahedra(self):
        case = ("8 ranks", scene(mesh_resolution="1"), ["ranks (8)", "tetrahedra (6)"])
        self.check_all([case], all_ranks=[8])


class StrangeButRight(WithInputs):
    """What looks like an error and is none."""

    def check_runs(self, arguments, said=(), status=0):
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                run = self.run_on(ranks, arguments)
                self.assertEqual(run.statuses, [status] * ranks, run.text)
                self.assertNotIn("trefoil: ", run.text)
                for words in said:
                    self.assertEqual(run.text.count(words), 1, run.text)
                yield run

    def test_bad_tetrahedra_are_dropped(self):
        arguments = mesh("two_bad.mesh", mesh_repair="drop",
                         constraint_low_where="z == 0", constraint_low_move="0.1*y, 0, 0")
        said = ["dropped 2 tetrahedra without positive volume"]
        for run in self.check_runs(arguments, said):
            self.assertEqual(run.record["mesh"]["elements"], 2)
            self.assertTrue(run.record["result"]["converged"])

    def test_unused_vertices_are_dropped(self):
        arguments = mesh("unused.mesh", constraint_low_where="z == 0")
        for run in self.check_runs(arguments, ["dropped 1 vertices that no tetrahedron uses"]):
            self.assertEqual(run.record["mesh"]["vertices"], 8)

    def test_options_in_the_format_of_petsc(self):
        for run in self.check_runs(options_file("right.petsc")):
            self.assertIn("converged in", run.text)

    def test_constraints_that_agree(self):
        for run in self.check_runs(two("x == xmin", "0.1*z, 0, 0", first="0.1*z, free, 0")):
            self.assertTrue(run.record["result"]["converged"])

    def test_already_at_equilibrium(self):
        for run in self.check_runs(low(move="0, 0, 0")):
            result = run.record["result"]
            self.assertTrue(result["converged"])
            self.assertEqual(result["line_search_trials"], 0)
            self.assertEqual(len(run.record["history"]), max(result["iterations"], 1))
            self.assertEqual([entry["step"] for entry in run.record["history"]], [0])
            self.assertEqual(run.files, ["run.h5", "run.json", "run.xdmf"])

    def test_moved_as_a_whole_is_at_equilibrium(self):
        held = two("z == zmax", "0.25, 0, 0", first="0.25, 0, 0")
        for run in self.check_runs(held):
            self.assertTrue(run.record["result"]["converged"])

    def test_options_that_petsc_reads_at_its_own_time(self):
        views = ["-snes_view", "::ascii_info", "-ksp_view", "-log_view", "-malloc_dump",
                 "-ksp_converged_reason", "-snes_converged_reason", "-options_left"]
        list(self.check_runs(low(move="0.1*y, 0, 0") + views, ["converged in"]))

    def test_options_of_guess_and_line_search(self):
        tuning = ["-guess_pc_type", "jacobi", "-guess_ksp_type", "cg", "-initial_steps", "2",
                  "-snes_linesearch_shrink", "0.5", "-snes_linesearch_monitor",
                  "-snes_trefoil_corrections", "2", "-snes_linesearch_damping", "0.9"]
        for move in ("0.1*y, 0, 0", "0, 0, 0"):  # with and without anything to spread
            list(self.check_runs(low(move=move) + tuning, ["converged in"]))

    def test_not_converged(self):
        arguments = low(where="abs(z - 0.5) == 0.5", move="0, 0, 0.5*z") + ["-snes_max_it", "1"]
        for run in self.check_runs(arguments, ["NOT CONVERGED"], status=3):
            result = run.record["result"]
            self.assertIs(result["converged"], False)
            self.assertIn("MAX_IT", result["reason"])
            self.assertEqual(run.files, ["run.h5", "run.json", "run.xdmf"])


if __name__ == "__main__":
    unittest.main()
