#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "contact/vector3.hpp"

namespace trefoil::contact {

/// A box with its sides along the axes.
struct Box {
  Vector3 low, high;
};

/// Finds overlapping boxes by uniform grids.
///
/// The cells that each box overlaps are listed and sorted (radix sort), so that the boxes of a cell
/// stand together and are compared with each other. A pair that shares several cells counts in the
/// lowest one only. Cells have about the size of a box; boxes of more than three cells go to a grid
/// of eight times larger cells, and so on: no box lies in more than 4^3 cells, a floor of two
/// triangles under a fine mesh included. Smaller boxes visit the larger grids where one is.
///
/// Coordinates are kept in single precision, in units of a cell. Rounding keeps their order: all
/// pairs of overlapping boxes are found, and a few that miss each other by a millionth of the
/// whole.
class SortedGrid {
 public:
  /// Of each pair one box belongs to `first`, one to `second`.
  SortedGrid(const std::vector<Box> &first, const std::vector<Box> &second);
  /// Pairs among `boxes`.
  explicit SortedGrid(const std::vector<Box> &boxes);

  /// Calls visit(i, j) once for each pair of overlapping boxes, box i of the first list and box j
  /// of the second, or i < j of the one list; in no useful order.
  /// @param most_work  ends where there would be more to do, in comparisons of two boxes; a call of
  ///                   visit() counts as many
  /// @return the work done; more than `most_work`: it has ended before, pairs are missing
  template <class Visit>
  double visit_pairs(const Visit &visit,
                     double most_work = std::numeric_limits<double>::infinity()) {
    constexpr double work_of_visit = 30;
    double work = 0;
    for (int level = 0; level < levels_; ++level) {
      sort_level(level);
      for (std::size_t begin = 0, end = 0; begin < entries_.size(); begin = end) {
        end = gather_cell(level, begin);
        const int count = static_cast<int>(end - begin);
        const int seconds = two_sets_ ? count - firsts_in_cell_ : count;
        if (firsts_in_cell_ == 0 || seconds == 0) continue;
        work += 1.0 * firsts_in_cell_ * seconds;
        if (work > most_work) return work;
        for (int a = 0; a < firsts_in_cell_; ++a) {
          const int hits = overlaps_in_cell(a, two_sets_ ? firsts_in_cell_ : a + 1, count);
          work += work_of_visit * hits;
          for (int hit = 0; hit < hits; ++hit) {
            visit(static_cast<int>(cell_.box[a]),
                  static_cast<int>(cell_.box[hits_[hit]] - (two_sets_ ? first_count_ : 0)));
          }
        }
      }
    }
    return work;
  }

 private:
  struct GridBox {
    std::array<float, 3> low, high;  ///< in cells of level 0, from the low corner of everything
  };
  /// The boxes of one cell, coordinate by coordinate.
  struct Cell {
    std::array<std::vector<float>, 3> low, high;
    /// Bit i: the box begins in this cell along axis i; bit 3: it belongs to this level.
    std::vector<std::int32_t> flags;
    std::vector<std::uint32_t> box;
  };

  void set_up(const std::vector<Box> &first, const std::vector<Box> &second);
  void sort_level(int level);
  void list_cells_of(std::uint32_t box, int level, const GridBox &range);
  void radix_sort();
  std::size_t gather_cell(int level, std::size_t begin);
  int overlaps_in_cell(int a, int begin, int end);

  bool two_sets_ = true;
  std::uint32_t first_count_ = 0;
  int levels_ = 0;
  int box_bits_ = 0, cell_bits_ = 0;      ///< of an entry: the cell's number above that of the box
  std::array<std::uint64_t, 3> cells_{};  ///< of the level at hand, along the axes
  std::vector<GridBox> boxes_;
  std::vector<std::uint8_t> level_;
  std::vector<std::uint64_t> entries_, scratch_;
  Cell cell_;
  int firsts_in_cell_ = 0;
  std::vector<int> hits_;
};

}  // namespace trefoil::contact
