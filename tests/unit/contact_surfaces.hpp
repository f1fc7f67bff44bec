#pragma once

#include <algorithm>
#include <random>
#include <vector>

#include "contact/surface.hpp"

/// Small surfaces for the tests of contact.
namespace trefoil::contact {

/// Tetrahedra of some size, each a body of its own, at random places in a cube.
/// @param ranks      the vertices of each belong to several of them
/// @param obstacles  some tetrahedra are obstacles, some prescribed
inline Surface tetrahedra(int count, double size, double cube, std::mt19937 &random, int ranks = 1,
                          bool obstacles = false) {
  std::uniform_real_distribution<double> place(0, cube);
  std::normal_distribution<double> normal(0, size);
  std::vector<SurfaceVertex> vertices;
  std::vector<SurfaceFacet> facets;
  for (int body = 0; body < count; ++body) {
    const Vector3 middle{place(random), place(random), place(random)};
    const bool obstacle = obstacles && body % 5 == 4, prescribed = obstacles && body % 5 == 3;
    for (int v = 0; v < 4; ++v) {
      const Vector3 off{normal(random), normal(random), normal(random)};
      vertices.push_back({middle + off, 4 * body + v + 100, body,
                          obstacle ? -1 : (body + v) % ranks,
                          obstacle     ? Role::obstacle
                          : prescribed ? Role::prescribed
                                       : Role::free});
      std::array<int, 3> corners{};
      for (int c = 0; c < 3; ++c) corners[c] = 4 * body + (v + 1 + c) % 4;
      facets.push_back({corners, 1.0 + body});
    }
  }
  return make_surface(3, std::move(vertices), std::move(facets));
}

/// A sheet of n x n squares of two triangles with side 1, turned by an angle about z, at a height.
inline void add_sheet(int n, double angle, double height, int body,
                      std::vector<SurfaceVertex> &vertices, std::vector<SurfaceFacet> &facets) {
  const int first = static_cast<int>(vertices.size());
  const double c = std::cos(angle), s = std::sin(angle);
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double x = i / double(n) - 0.5, y = j / double(n) - 0.5;
      vertices.push_back({{c * x - s * y, s * x + c * y, height}, 0, body, 0, Role::free});
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const int a = first + j * (n + 1) + i, b = a + 1, d = a + n + 1, e = d + 1;
      facets.push_back({{a, b, e}, 1});
      facets.push_back({{a, e, d}, 1});
    }
  }
}

/// Two such sheets above each other.
inline Surface two_sheets(int n, double angle, double gap) {
  std::vector<SurfaceVertex> vertices;
  std::vector<SurfaceFacet> facets;
  add_sheet(n, 0, 0, 0, vertices, facets);
  add_sheet(n, angle, gap, 1, vertices, facets);
  return make_surface(3, std::move(vertices), std::move(facets));
}

/// Polygons of four edges in the plane, each a body.
inline Surface polygons(int count, double size, double square, std::mt19937 &random,
                        int ranks = 1) {
  std::uniform_real_distribution<double> place(0, square);
  std::normal_distribution<double> normal(0, size);
  std::vector<SurfaceVertex> vertices;
  std::vector<SurfaceFacet> facets;
  for (int body = 0; body < count; ++body) {
    const Vector3 middle{place(random), place(random), 0};
    for (int v = 0; v < 4; ++v) {
      const Vector3 off{normal(random), normal(random), 0};
      vertices.push_back({middle + off, 4 * body + v, body, (body + v) % ranks, Role::free});
      facets.push_back({{4 * body + v, 4 * body + (v + 1) % 4, -1}, 1.0 + body});
    }
  }
  return make_surface(2, std::move(vertices), std::move(facets));
}

}  // namespace trefoil::contact
