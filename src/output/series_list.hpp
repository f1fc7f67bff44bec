#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "output/output_files.hpp"
#include "output/xdmf.hpp"

namespace trefoil {

/// The names of a series' files, and its description: which of them has which state. An XDMF file,
/// or ParaView's .pvd for .vtu files. What XDMF says of a state is put in words once.
class SeriesList {
 public:
  explicit SeriesList(std::filesystem::path path)
      : path_(std::move(path)), format_(format_of_output(path_)) {}

  /// The heavy half of an XDMF output, and of a series the mesh: bar.h5.
  [[nodiscard]] std::filesystem::path data() const;
  /// bar_0012.h5, or bar_0012.vtu
  [[nodiscard]] std::filesystem::path of_state(std::size_t number) const;
  /// Where the description is: bar.xdmf, or bar.pvd.
  [[nodiscard]] std::filesystem::path place() const;
  /// Its text. States that were there at the last call are as they were then, see forget().
  std::string text(const ArrangedMesh &mesh, const std::vector<XdmfState> &states);
  void forget();

 private:
  std::filesystem::path path_;
  OutputFormat format_;
  std::string words_;
  std::size_t described_ = 0;  ///< states, in words_
};

}  // namespace trefoil
