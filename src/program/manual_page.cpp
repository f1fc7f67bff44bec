#include "program/manual_page.hpp"

#include <petscsys.h>

#include <sstream>

#include "program/help.hpp"
#include "scene/scene_options.hpp"
#include "trefoil.h"

namespace trefoil {
namespace {

const char *const before_options = R"(.TH TREFOIL 1
.SH NAME
trefoil \- equilibrium of an elastic body, by projected Newton with trust-region eigenvalue filtering
.SH SYNOPSIS
.B mpirun \-n
.I ranks
.B trefoil
[\fB\-\-check\fR] [\fIscene.yaml\fR ...] [\fB\-\fIoption value\fR ...]
.SH DESCRIPTION
Reads a mesh of tetrahedra or triangles, holds one part, moves or loads another, minimises the elastic
energy, and writes displacements, stresses and a record. Scene files in YAML are options in another
form:
.B mesh: {file: a.msh}
is
.BR "\-mesh_file a.msh" ;
a part that a section names, as in
.BR "constraints: {wall: {group: wall}}" ,
is
.BR "\-constraint_wall_group wall" .
What comes later wins. A name that nothing reads is an error. Options of PETSc
.RB ( \-snes_* ", " \-ksp_* ", " \-pc_* ", " \-log_view )
mean what they mean elsewhere.
.TP
.B \-\-check
builds the scene, tells what it holds, and solves nothing
.TP
.BR \-\-help " [" all | keys | man ]
one screen; all options, with PETSc's; this page
.TP
.B \-\-version
Trefoil's, PETSc's, ranks, and the instruction set of the kernels
.SH OPTIONS OF A SCENE
Defaults in parentheses.
)";

const char *const before_solver_options = R"(.SH OPTIONS OF THE SOLVER
Defaults of the plugin; the program searches by
.B subspace
and verifies the minimum.
)";

const char *const after_options = R"(.SH EXIT STATUS
.TP
.B 0
converged; also help, which solves nothing
.TP
.B 1
bad input; one sentence names it and the way out
.TP
.B 3
not converged, or not enough memory; the last good state is written
.SH EXAMPLES
.nf
trefoil examples/knot.yaml \-output_file knot.xdmf
mpirun \-n 4 trefoil examples/knot.yaml \-mesh_refine 1 \-snes_trefoil_record knot.json
trefoil \-\-check examples/bracket.yaml
.fi
.SH SEE ALSO
The pages README.md of the examples (scenes), of the headers (the plugin in other programs) and of the
tests (how good it is), installed under share/doc/trefoil.
)";

/// Text for man: its control characters and hyphens of options escaped.
std::string escaped(const std::string &text) {
  std::string result;
  for (const char letter : text) {
    if (letter == '\\')
      result += "\\e";
    else if (letter == '-')
      result += "\\-";
    else
      result += letter;
  }
  return result;
}

/// One entry; the option's name in bold, then what it is.
std::string entry(const std::string &name, const std::string &help) {
  return ".TP\n.B " + escaped(name) + "\n\\&" + escaped(help) + "\n";
}

std::string scene_entries() {
  std::string text;
  for (const OptionGroup &group : scene_option_groups()) {
    text += ".SS " + group.title + "\n";
    for (const OptionRow &row : group.rows) text += entry("-" + row.name, help_of(row));
  }
  return text;
}

/// From lines "-name <default> - what it is".
std::string solver_entries() {
  const char *lines = nullptr;
  static_cast<void>(TrefoilGetOptionsManual(&lines));
  std::istringstream manual(lines);
  std::string text;
  for (std::string line; std::getline(manual, line);) {
    const std::size_t name_end = line.find(' '), help_begin = line.find("> - ");
    const std::string standard = line.substr(name_end + 2, help_begin - name_end - 2);
    text += entry(line.substr(0, name_end),
                  line.substr(help_begin + 4) + (standard.empty() ? "" : " (" + standard + ")"));
  }
  return text;
}

}  // namespace

std::string manual_page() {
  return before_options + scene_entries() + before_solver_options + solver_entries() +
         after_options;
}

}  // namespace trefoil
