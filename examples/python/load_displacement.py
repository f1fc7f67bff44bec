#!/usr/bin/python3
# %% [markdown]
# # A load-displacement curve from Python
#
# Each part between two `# %%` lines is a cell for Jupyter, VS Code or Spyder; as a whole it runs by
#
#     python3 examples/python/load_displacement.py
#
# from the top of the checkout, and leaves load_displacement.png. The bolt of `examples/bushing.yaml` is
# pushed sideways by 6 mm in twelve load steps; the rubber round it, 12 mm thick, stiffens.

# %% Where trefoil.py is
import os
import sys

sys.path.insert(0, os.path.join("examples", "python"))

import matplotlib.pyplot as plt
import numpy as np

import trefoil

# %% One run: a scene, and what is different in it
result = trefoil.run("examples/bushing.yaml", ranks=2,
                     constraint_bolt_move="6, 0, 0", load_steps=12)
print(result.record["result"]["reason"])

# %% A row a load step: how far the bolt has gone, and what it takes to hold it there
steps = result.record["steps"]
displacement = np.array([6 * step["t"] for step in steps])  # mm
force = np.array([step["reaction"]["bolt"][0] for step in steps])  # N
for u, f in zip(displacement, force):
    print(f"{u:5.2f} mm {f:8.1f} N {f / u:8.1f} N/mm")

# %% The fields of each step are there as well
for step in result.steps:
    stress = step.cell_fields["von_mises"][step.cell_fields["region"] == 0]  # of the rubber
    print(f"t = {step.t:.3f}: von Mises stress up to {stress.max():.2f} MPa in the rubber")

# %% The curve, and the stiffness that it starts with
figure, axes = plt.subplots(figsize=(6, 4.2), layout="constrained")
axes.plot(np.append(0, displacement), np.append(0, force), "o-", color="#17646e", label="bushing")
axes.plot([0, 6], [0, 6 * force[0] / displacement[0]], ":", color="0.5", label="as stiff as at first")
axes.set(xlabel="displacement of the bolt [mm]", ylabel="force on the bolt [N]", xlim=(0, None), ylim=(0, None))
axes.spines[["top", "right"]].set_visible(False)
axes.legend(frameon=False)
figure.savefig("load_displacement.png", dpi=150)
