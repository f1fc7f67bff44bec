#!/bin/sh
# The demo: installs what is missing, builds, stretches and turns a rubber trefoil knot on two
# ranks, and leaves a page to look at and pictures of the body and of the convergence in out/.
set -eu
cd "$(dirname "$0")/.."
. cmake/environment.sh
sh cmake/setup.sh
mkdir -p out

mpirun -n 2 build/trefoil examples/knot.yaml \
  -output_file out/knot.xdmf -snes_trefoil_record out/knot.json
/usr/bin/python3 examples/picture.py out/knot.xdmf -o out/knot.png
/usr/bin/python3 examples/plot_convergence.py out/knot.json -o out/convergence.png
/usr/bin/python3 examples/report.py out/knot.json out/knot.xdmf -o out/knot.html --units "m, N"
echo "Open out/knot.html in a browser: the body turns. Pictures: out/knot.png, out/convergence.png;"
echo "for ParaView: out/knot.xdmf."
