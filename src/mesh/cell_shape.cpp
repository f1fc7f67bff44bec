#include "mesh/cell_shape.hpp"

namespace trefoil {
namespace {

using Edge = std::array<int, 2>;
using Facet = std::array<int, CellShape::most_facet_nodes>;
using Frame = std::array<int, 4>;

constexpr Edge edges_of_edge[] = {{0, 1}};
constexpr Edge edges_of_triangle[] = {{0, 1}, {1, 2}, {2, 0}};
constexpr Edge edges_of_tetrahedron[] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

constexpr Facet facets_of_edge[] = {{0}, {1}};
constexpr Facet facets_of_tri3[] = {{0, 1}, {1, 2}, {2, 0}};
constexpr Facet facets_of_tri6[] = {{0, 1, 3}, {1, 2, 4}, {2, 0, 5}};
constexpr Facet facets_of_tet4[] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
constexpr Facet facets_of_tet10[] = {
    {0, 2, 1, 6, 5, 4}, {0, 1, 3, 4, 8, 7}, {1, 2, 3, 5, 9, 8}, {2, 0, 3, 6, 7, 9}};

constexpr Frame frames_of_triangle[] = {{0, 1, 2, -1}};
constexpr Frame frames_of_tetrahedron[] = {{0, 1, 2, 3}};

constexpr int mirrored_edge[] = {1, 0, 2};
constexpr int mirrored_triangle[] = {0, 2, 1, 5, 4, 3};
constexpr int mirrored_tet4[] = {0, 2, 1, 3};
constexpr int mirrored_tet10[] = {0, 2, 1, 3, 6, 5, 4, 7, 9, 8};

constexpr int same_order[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
constexpr int gmsh_tet10[] = {0, 1, 2, 3, 4, 5, 6, 7, 9, 8};  // (2,3) stands before (1,3)

template <class Entry, std::size_t size>
constexpr std::span<const Entry> first(const Entry (&entries)[size], std::size_t count) {
  return std::span<const Entry>(entries).first(count);
}

constexpr const CellShape *all[] = {&shapes::point, &shapes::edge2, &shapes::edge3, &shapes::tri3,
                                    &shapes::tri6,  &shapes::tet4,  &shapes::tet10};
constexpr std::size_t below_cells = 3;

}  // namespace

// The table. Facets have the order of their cell, edges are named by their corners only.
namespace shapes {

const CellShape point{.name = "point",
                      .singular = "point",
                      .plural = "points",
                      .dimension = 0,
                      .order = 1,
                      .corners = 1,
                      .nodes = 1,
                      .linear = &point,
                      .quadratic = &point,
                      .edges = {},
                      .facet = nullptr,
                      .facets = {},
                      .frames = {},
                      .mirrored = first(same_order, 1),
                      .children = 1,
                      .gmsh_type = 15,
                      .gmsh_order = first(same_order, 1),
                      .medit = "Vertices",
                      .xdmf = "Polyvertex",
                      .vtk = 1};

const CellShape edge2{.name = "edge2",
                      .singular = "edge",
                      .plural = "edges",
                      .dimension = 1,
                      .order = 1,
                      .corners = 2,
                      .nodes = 2,
                      .linear = &edge2,
                      .quadratic = &edge3,
                      .edges = edges_of_edge,
                      .facet = &point,
                      .facets = facets_of_edge,
                      .frames = {},
                      .mirrored = first(mirrored_edge, 2),
                      .children = 2,
                      .gmsh_type = 1,
                      .gmsh_order = first(same_order, 2),
                      .medit = "Edges",
                      .xdmf = "Polyline",
                      .vtk = 3};

const CellShape edge3{.name = "edge3",
                      .singular = "edge",
                      .plural = "edges",
                      .dimension = 1,
                      .order = 2,
                      .corners = 2,
                      .nodes = 3,
                      .linear = &edge2,
                      .quadratic = &edge3,
                      .edges = edges_of_edge,
                      .facet = &point,
                      .facets = facets_of_edge,
                      .frames = {},
                      .mirrored = first(mirrored_edge, 3),
                      .children = 2,
                      .gmsh_type = 8,
                      .gmsh_order = first(same_order, 3),
                      .medit = nullptr,
                      .xdmf = "Edge_3",
                      .vtk = 21};

const CellShape tri3{.name = "tri3",
                     .singular = "triangle",
                     .plural = "triangles",
                     .dimension = 2,
                     .order = 1,
                     .corners = 3,
                     .nodes = 3,
                     .linear = &tri3,
                     .quadratic = &tri6,
                     .edges = edges_of_triangle,
                     .facet = &edge2,
                     .facets = facets_of_tri3,
                     .frames = frames_of_triangle,
                     .mirrored = first(mirrored_triangle, 3),
                     .children = 4,
                     .gmsh_type = 2,
                     .gmsh_order = first(same_order, 3),
                     .medit = "Triangles",
                     .xdmf = "Triangle",
                     .vtk = 5};

const CellShape tri6{.name = "tri6",
                     .singular = "triangle",
                     .plural = "triangles",
                     .dimension = 2,
                     .order = 2,
                     .corners = 3,
                     .nodes = 6,
                     .linear = &tri3,
                     .quadratic = &tri6,
                     .edges = edges_of_triangle,
                     .facet = &edge3,
                     .facets = facets_of_tri6,
                     .frames = frames_of_triangle,
                     .mirrored = first(mirrored_triangle, 6),
                     .children = 4,
                     .gmsh_type = 9,
                     .gmsh_order = first(same_order, 6),
                     .medit = nullptr,
                     .xdmf = "Triangle_6",
                     .vtk = 22};

const CellShape tet4{.name = "tet4",
                     .singular = "tetrahedron",
                     .plural = "tetrahedra",
                     .dimension = 3,
                     .order = 1,
                     .corners = 4,
                     .nodes = 4,
                     .linear = &tet4,
                     .quadratic = &tet10,
                     .edges = edges_of_tetrahedron,
                     .facet = &tri3,
                     .facets = facets_of_tet4,
                     .frames = frames_of_tetrahedron,
                     .mirrored = first(mirrored_tet4, 4),
                     .children = 8,
                     .gmsh_type = 4,
                     .gmsh_order = first(same_order, 4),
                     .medit = "Tetrahedra",
                     .xdmf = "Tetrahedron",
                     .vtk = 10};

const CellShape tet10{.name = "tet10",
                      .singular = "tetrahedron",
                      .plural = "tetrahedra",
                      .dimension = 3,
                      .order = 2,
                      .corners = 4,
                      .nodes = 10,
                      .linear = &tet4,
                      .quadratic = &tet10,
                      .edges = edges_of_tetrahedron,
                      .facet = &tri6,
                      .facets = facets_of_tet10,
                      .frames = frames_of_tetrahedron,
                      .mirrored = first(mirrored_tet10, 10),
                      .children = 8,
                      .gmsh_type = 11,
                      .gmsh_order = first(gmsh_tet10, 10),
                      .medit = nullptr,
                      .xdmf = "Tetrahedron_10",
                      .vtk = 24};

}  // namespace shapes

std::span<const CellShape *const> all_shapes() {
  return all;
}

std::span<const CellShape *const> mesh_shapes() {
  return all_shapes().subspan(below_cells);
}

}  // namespace trefoil
