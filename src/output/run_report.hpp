#pragma once

#include <petscsys.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace trefoil {

/// A force and its moment about the origin.
struct Resultant {
  std::array<double, 3> force{}, moment{};
};

/// What a constraint takes, and how it holds the body at the end.
struct ConstraintReport {
  std::string name;
  PetscInt64 vertices = 0;
  double area = 0;  ///< of the surface between them, at rest
  Resultant reaction = {};
};

/// What a load takes, and how it pulls at the body at the end.
struct LoadReport {
  std::string name;
  PetscInt64 facets = 0;
  double area = 0;  ///< of them, at rest
  Resultant resultant = {};
};

/// A part of the body with a material of its own; "body" is what is left.
struct RegionReport {
  std::string name;
  PetscInt64 cells = 0;
  double volume = 0, mass = 0;  ///< at rest
};

/// The largest, or the least, of something, and the rest position where it is.
struct Extreme {
  double value = 0;
  std::array<double, 3> at{};
};

/// A place whose displacement is asked for.
struct ProbeReport {
  std::string name;
  std::array<double, 3> displacement{};
};

/// What an obstacle exerts on the bodies.
struct ObstacleReport {
  std::string name;
  std::array<double, 3> force{};
};

/// What is in contact in a state.
struct ContactState {
  double energy = 0;            ///< of the barriers
  double least_gap = 0;         ///< infinite where nothing is nearer than the contact distance
  double distance = 0;          ///< below which there are forces
  double stiffening = 1;        ///< times the stiffness that was asked for
  PetscInt64 pairs = 0;         ///< nearer than the contact distance
  int friction_iterations = 0;  ///< solves with other forces of friction
  double friction_force = 0;    ///< summed over the vertices
  double friction_change = 0;   ///< of it, if friction had this state's own normal forces
  std::vector<ObstacleReport> obstacles = {};
};

/// How a body moves at the end of a step in time.
struct MotionReport {
  double step = 0;  ///< its length; 0 at the start
  double kinetic_energy = 0;
  std::array<double, 3> momentum{}, angular_momentum{};  ///< the latter about the origin
};

/// One state: the equilibrium at the end of a load step, or the end of a step in time.
struct StateReport {
  double t = 1;
  double energy = 0, strain_energy = 0, load_work = 0;
  PetscInt iterations = 0;
  bool is_loose = false;             ///< on a path of the program's own accord: no equilibrium
  bool is_rejected = false;          ///< what counts was not reached from it
  std::vector<Resultant> reactions;  ///< of the constraints
  std::vector<Resultant> loads;
  Extreme largest_displacement, least_determinant, largest_von_mises;
  double volume = 0;  ///< of the body as it is deformed
  std::vector<ProbeReport> probes;
  std::optional<MotionReport> motion = {};   ///< in time
  std::optional<ContactState> contact = {};  ///< where the scene has contact
};

/// The mesh as it was solved on.
struct MeshReport {
  PetscInt vertices = 0, nodes = 0, elements = 0, parts = 1;
  std::string element;
  std::string element_pressure;  ///< as -element_pressure was chosen
  PetscInt dofs = 0, free_dofs = 0;
  PetscInt64 inverted_at_start = 0;
  PetscInt edge_cut = 0;
  double imbalance = 1;
  double bytes = 0;
};

/// Seconds of the program outside the solve; the rest of `total` is the solve's.
struct ProgramTimes {
  double total = 0, read = 0, setup = 0, output = 0, guess = 0;
};

/// What a run found: the plugin's record, and all that the plugin knows nothing of.
struct RunReport {
  std::string plugin_record;         ///< JSON, see TrefoilSNESGetRecord()
  std::string restarted_from;        ///< the checkpoint's file, if the run goes on from one
  std::string linear_solver;         ///< what solved the linear systems, in words
  std::string linear_solver_reason;  ///< why that
  MeshReport mesh;
  std::vector<ConstraintReport> constraints;
  std::vector<LoadReport> loads;
  std::vector<RegionReport> regions;
  std::vector<StateReport> states;  ///< one a load step that stands
  StateReport end;                  ///< where the body is left
  std::string failure;  ///< why the way in load steps did not get to t = 1; empty: it did
  std::vector<std::string> warnings;
  double energy_rest = 0, energy_scale = 0;
  std::optional<double> energy_rise = {};  ///< in time, of the total energy; a share of its scale
  bool energy_is_made = false;             ///< that rise comes from nothing
  std::optional<double> force_imbalance = {};  ///< at the end, a share of the largest force
  std::string balance_warning;                 ///< empty: that is little
  std::optional<double> friction_lag = {};     ///< change of friction over friction, of all states
  bool friction_is_late = false;               ///< so much that results are doubtful
  std::string friction_advice;                 ///< what to do about it
  PetscInt guess_linear_solves = 0;
  PetscInt64 inverted = 0;  ///< at the end
  int path_halvings = 0;    ///< of steps on a path of the program's own accord
  ProgramTimes times;       ///< the maximum over the ranks
};

}  // namespace trefoil
