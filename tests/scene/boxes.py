"""Cubes for the scene tests: held at both ends, or between planes on which they slide."""

TIGHT = ["-snes_trefoil_energy_tolerance", "1e-13"]
BOX = ["-mesh_generate", "box", "-mesh_resolution", "4"]
ENDS = [*BOX, "-constraints", "low,high", "-constraint_low_where", "z == zmin",
        "-constraint_high_where", "z == zmax"]
# Slides on three planes, so that a uniform state is possible.
SLIDING = [*BOX, "-constraint_floor_where", "z == zmin", "-constraint_floor_move", "free, free, 0",
           "-constraint_wall_where", "x == xmin", "-constraint_wall_move", "0, free, free",
           "-constraint_back_where", "y == ymin", "-constraint_back_move", "free, 0, free"]
THREE_PLANES = [*SLIDING, "-constraints", "floor,wall,back"]
PULLED = [*SLIDING, "-constraints", "floor,wall,back,lid", "-constraint_lid_where", "z == zmax",
          "-constraint_lid_move", "free, free, 0.5"]
# Without lateral contraction, Hooke's law in the stretch: P = young (stretch - 1).
SPRING = ["-material_model", "corotated", "-material_poisson", "0"]


def energy(record):
    return record["result"]["energy"]
