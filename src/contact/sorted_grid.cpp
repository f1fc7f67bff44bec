#include "contact/sorted_grid.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace trefoil::contact {
namespace {

/// Cells of the next level are this much larger; a box takes the first level where it is no longer
/// than so many cells.
constexpr int cell_ratio_bits = 3;
constexpr double most_cells = 3;

float scale_of(int level) {
  return std::ldexp(1.0F, -cell_ratio_bits * level);
}

double longest_side(const Box &box) {
  const Vector3 side = box.high - box.low;
  return std::max({side.x, side.y, side.z});
}

Box around(const std::vector<Box> &first, const std::vector<Box> &second) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  Box all{{inf, inf, inf}, {-inf, -inf, -inf}};
  for (const auto *boxes : {&first, &second}) {
    for (const Box &box : *boxes) {
      for (int i = 0; i < 3; ++i) {
        all.low[i] = std::min(all.low[i], box.low[i]);
        all.high[i] = std::max(all.high[i], box.high[i]);
      }
    }
  }
  return all;
}

/// The median of the larger of the two kinds of boxes: half of them, at least, lie in a few cells.
double typical_side(const std::vector<Box> &first, const std::vector<Box> &second) {
  double typical = 0;
  for (const auto *boxes : {&first, &second}) {
    if (boxes->empty()) continue;
    std::vector<double> sides;
    sides.reserve(boxes->size());
    for (const Box &box : *boxes) sides.push_back(longest_side(box));
    const auto middle = sides.begin() + static_cast<std::ptrdiff_t>(sides.size() / 2);
    std::nth_element(sides.begin(), middle, sides.end());
    typical = std::max(typical, *middle);
  }
  return typical;
}

/// Three quarters of a typical side, but large enough that a cell's number along an axis fits a
/// float, and those of all cells into `bits` bits.
double cell_size(const Box &all, double side, int bits) {
  const double whole = longest_side(all);
  double cell = std::max({0.75 * side, 1e-6 * whole, std::numeric_limits<double>::min()});
  const auto too_many = [&] {
    double count = 1;
    for (int i = 0; i < 3; ++i) count *= (all.high[i] - all.low[i]) / cell + 2;
    return count > std::ldexp(1.0, bits);
  };
  while (too_many()) cell *= 2;
  return cell;
}

}  // namespace

SortedGrid::SortedGrid(const std::vector<Box> &first, const std::vector<Box> &second) {
  set_up(first, second);
}

SortedGrid::SortedGrid(const std::vector<Box> &boxes) : two_sets_(false) {
  set_up(boxes, {});
}

void SortedGrid::set_up(const std::vector<Box> &first, const std::vector<Box> &second) {
  first_count_ = static_cast<std::uint32_t>(first.size());
  if (first.empty() || (two_sets_ && second.empty())) return;
  const Box all = around(first, second);
  box_bits_ = std::bit_width(first.size() + second.size() - 1);
  const double cell = cell_size(all, typical_side(first, second), 64 - box_bits_);
  boxes_.reserve(first.size() + second.size());
  for (const auto *boxes : {&first, &second}) {
    for (const Box &box : *boxes) {
      GridBox scaled;
      for (int i = 0; i < 3; ++i) {
        scaled.low[i] = static_cast<float>((box.low[i] - all.low[i]) / cell);
        scaled.high[i] = static_cast<float>((box.high[i] - all.low[i]) / cell);
      }
      int level = 0;
      double largest = most_cells * cell;
      for (const double side = longest_side(box); side > largest; ++level) {
        largest *= 1 << cell_ratio_bits;
      }
      boxes_.push_back(scaled);
      level_.push_back(static_cast<std::uint8_t>(level));
      levels_ = std::max(levels_, level + 1);
    }
  }
}

/// Lists and sorts the cells of all boxes of a level, and of smaller boxes where they are near.
void SortedGrid::sort_level(int level) {
  constexpr float inf = std::numeric_limits<float>::infinity();
  GridBox range{{inf, inf, inf}, {0, 0, 0}};
  for (std::size_t k = 0; k < boxes_.size(); ++k) {
    if (level_[k] != level) continue;
    for (int i = 0; i < 3; ++i) {
      range.low[i] = std::min(range.low[i], boxes_[k].low[i]);
      range.high[i] = std::max(range.high[i], boxes_[k].high[i]);
    }
  }
  entries_.clear();
  if (range.low[0] == inf) return;
  std::uint64_t count = 1;
  for (int i = 0; i < 3; ++i) {
    cells_[i] = static_cast<std::uint64_t>(range.high[i] * scale_of(level)) + 1;
    count *= cells_[i];
  }
  cell_bits_ = std::bit_width(count - 1);
  for (std::uint32_t k = 0; k < boxes_.size(); ++k) {
    if (level_[k] <= level) list_cells_of(k, level, range);
  }
  radix_sort();
}

void SortedGrid::list_cells_of(std::uint32_t box, int level, const GridBox &range) {
  const float scale = scale_of(level);
  std::array<std::uint64_t, 3> low{}, high{};
  for (int i = 0; i < 3; ++i) {
    const float from = std::max(boxes_[box].low[i], range.low[i]);
    const float to = std::min(boxes_[box].high[i], range.high[i]);
    if (from > to) return;
    low[i] = static_cast<std::uint64_t>(from * scale);
    high[i] = static_cast<std::uint64_t>(to * scale);
  }
  for (std::uint64_t z = low[2]; z <= high[2]; ++z) {
    for (std::uint64_t y = low[1]; y <= high[1]; ++y) {
      const std::uint64_t row = (z * cells_[1] + y) * cells_[0];
      for (std::uint64_t x = low[0]; x <= high[0]; ++x) {
        entries_.push_back((row + x) << box_bits_ | box);
      }
    }
  }
}

/// By the cells' numbers; stable, so that the boxes of a cell stay in order.
void SortedGrid::radix_sort() {
  constexpr int digit_bits = 11;
  constexpr std::uint64_t digit_mask = (1U << digit_bits) - 1;
  scratch_.resize(entries_.size());
  for (int done = 0; done < cell_bits_; done += digit_bits) {
    const int shift = box_bits_ + done;
    std::array<std::size_t, digit_mask + 1> begin{};
    for (const std::uint64_t entry : entries_) ++begin[entry >> shift & digit_mask];
    std::size_t sum = 0;
    for (std::size_t &place : begin) {
      const std::size_t count = place;
      place = sum;
      sum += count;
    }
    for (const std::uint64_t entry : entries_) {
      scratch_[begin[entry >> shift & digit_mask]++] = entry;
    }
    entries_.swap(scratch_);
  }
}

/// Copies the boxes of the cell at `begin` to where they can be compared fast.
/// @return the begin of the next cell
std::size_t SortedGrid::gather_cell(int level, std::size_t begin) {
  const std::uint64_t cell = entries_[begin] >> box_bits_;
  std::size_t end = begin + 1;
  while (end < entries_.size() && entries_[end] >> box_bits_ == cell) ++end;
  const std::size_t count = end - begin;
  if (cell_.box.size() < count) {
    for (int i = 0; i < 3; ++i) {
      cell_.low[i].resize(2 * count);
      cell_.high[i].resize(2 * count);
    }
    cell_.flags.resize(2 * count);
    cell_.box.resize(2 * count);
    hits_.resize(2 * count);
  }
  firsts_in_cell_ = 0;
  if (count == 1) return end;

  const std::uint64_t row = cell / cells_[0];
  const float grow = 1 / scale_of(level);
  const std::array<float, 3> corner = {static_cast<float>(cell % cells_[0]) * grow,
                                       static_cast<float>(row % cells_[1]) * grow,
                                       static_cast<float>(row / cells_[1]) * grow};
  const std::uint64_t box_mask = (std::uint64_t{1} << box_bits_) - 1;
  for (std::size_t k = 0; k < count; ++k) {
    const auto box = static_cast<std::uint32_t>(entries_[begin + k] & box_mask);
    const GridBox &from = boxes_[box];
    std::int32_t flags = level_[box] == level ? 8 : 0;
    for (int i = 0; i < 3; ++i) {
      cell_.low[i][k] = from.low[i];
      cell_.high[i][k] = from.high[i];
      flags |= static_cast<std::int32_t>(from.low[i] >= corner[i]) << i;
    }
    cell_.flags[k] = flags;
    cell_.box[k] = box;
    firsts_in_cell_ += static_cast<int>(!two_sets_ || box < first_count_);
  }
  return end;
}

/// Writes to hits_ which boxes [begin, end) of the cell overlap box `a` and count here with it.
int SortedGrid::overlaps_in_cell(int a, int begin, int end) {
  const float *low[3], *high[3];
  for (int i = 0; i < 3; ++i) {
    low[i] = cell_.low[i].data();
    high[i] = cell_.high[i].data();
  }
  const float low0 = low[0][a], low1 = low[1][a], low2 = low[2][a];
  const float high0 = high[0][a], high1 = high[1][a], high2 = high[2][a];
  const std::int32_t *flags = cell_.flags.data(), flags_a = flags[a];
  int *hits = hits_.data(), count = 0;
  for (int b = begin; b < end; ++b) {
    const bool hit = (low0 <= high[0][b]) & (low[0][b] <= high0) & (low1 <= high[1][b]) &
                     (low[1][b] <= high1) & (low2 <= high[2][b]) & (low[2][b] <= high2) &
                     ((flags_a | flags[b]) == 15);
    hits[count] = b;
    count += static_cast<int>(hit);
  }
  return count;
}

}  // namespace trefoil::contact
