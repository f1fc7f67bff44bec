#!/bin/sh
# The demo: installs what is missing, builds, stretches and turns a rubber trefoil knot on two
# ranks, and leaves pictures of the body and of the convergence in out/.
set -eu
cd "$(dirname "$0")/.."
. cmake/environment.sh
sh cmake/setup.sh
mkdir -p out

mpirun -n 2 build/trefoil -options_file examples/knot.yaml \
  -output_file out/knot.xdmf -snes_trefoil_record out/knot.json
/usr/bin/python3 examples/picture.py out/knot.xdmf -o out/knot.png
/usr/bin/python3 examples/plot_convergence.py out/knot.json -o out/convergence.png
echo "Look at out/knot.png and out/convergence.png; open out/knot.xdmf in ParaView."
