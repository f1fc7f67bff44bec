#pragma once

/// The room `contact`: bodies that cannot pass through each other. It knows numbers only: plain
/// structs and spans, no PETSc, no MPI, no scene. Terms (src/term) bring in those.
///
/// The data
///   Surface         all surface vertices, edges and facets (triangles; in the plane edges) of all
///                   bodies and obstacles, with rest areas, bodies, owners and stiffness: the same
///                   on every rank, vertices ascending by global number. Made once.
///   positions       3 numbers a vertex of the surface, in its order, z = 0 in the plane; likewise
///                   steps, displacements and gradients.
///   ContactPair     two primitives by number: a vertex and a facet, or two edges. Lists of pairs
///                   are sorted: kind, first, second.
///
/// Set-up: find_intersections() of the rest positions names what a mesh gets wrong. dhat is a share
/// of body_diagonal(); least_gap() of the find_candidates() within it says whether bodies are
/// nearer than that at rest.
///
/// One step of a solver
///   1. A rank has positions x and a step d of the whole surface (one broadcast). find_candidates()
///      lists the pairs of this rank (PairSearch::rank) that come within dhat anywhere on
///      [x, x + d], or a share of it: boxes of the motion in a SortedGrid, of this rank's part of
///      space only, then the distance at x. The list serves until x leaves this segment.
///   2. allowed_step() of the candidates up to their share, and of each HalfSpace; the least of all
///      ranks is the longest first trial of the line search.
///   3. contact_energy() at each trial, summed over ranks. Infinite energies are legal.
///   4. At the accepted point add_contact_gradient() into an array of the surface, to be added up
///   at
///      the owners, and contact_hessians(): blocks H and N by the vertices of a pair, which the
///      caller numbers; rows of vertices without unknowns drop out. H + N is clamped.
///      Without a step, find_candidates() with a reach of 2 dhat is the pattern with a skin.
///   5. least_gap() for the record, and pairs_within() for what is in contact.
/// At the end of a time step lagged_friction() keeps normal forces and tangents; friction_energy()
/// and its derivatives are functions of the displacement since then.
///
/// Sums go over sorted pairs, each pair has one owner (owner_of_pair()), and results of a pair do
/// not depend on others: numbers of ranks change results by the rounding of sums only.
///
/// What is trusted: allowed_step() proves distances along straight motions up to rounding, with a
/// gap left far above that; find_intersections() proves a state free of intersections, exactly.
/// Distances are unsigned: beyond a wall the energy is finite again. Whatever moves x - a guess, a
/// prescribed motion, a restart - needs allowed_step() along its way, or find_intersections() at
/// its end.
///
/// Files, from below: vector3, barrier, distances, mollifier (numbers of a pair); pair_derivatives
/// (its gradient and Hessian); surface; sorted_grid, swept_boxes, candidates (which pairs);
/// separation, additive_ccd (how far); contact_energy, half_space, friction (sums over pairs);
/// predicates, intersections (exact).

#include "contact/additive_ccd.hpp"
#include "contact/candidate_list.hpp"
#include "contact/candidates.hpp"
#include "contact/contact_energy.hpp"
#include "contact/friction.hpp"
#include "contact/half_space.hpp"
#include "contact/intersections.hpp"
#include "contact/surface.hpp"
