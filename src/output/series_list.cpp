#include "output/series_list.hpp"

#include <cstdio>

#include "output/vtu.hpp"

namespace trefoil {

std::filesystem::path SeriesList::data() const {
  return std::filesystem::path(path_).replace_extension(".h5");
}

std::filesystem::path SeriesList::of_state(std::size_t number) const {
  const std::filesystem::path like = format_ == OutputFormat::xdmf ? data() : path_;
  char digits[32];
  std::snprintf(digits, sizeof digits, "_%04zu", number);
  return like.parent_path() / (like.stem().string() + digits + like.extension().string());
}

std::filesystem::path SeriesList::place() const {
  return format_ == OutputFormat::xdmf ? path_
                                       : std::filesystem::path(path_).replace_extension(".pvd");
}

std::string SeriesList::text(const ArrangedMesh &mesh, const std::vector<XdmfState> &states) {
  if (format_ != OutputFormat::xdmf) {
    std::vector<VtuOfSeries> files;
    for (const XdmfState &state : states) {
      files.push_back({state.t, of_state(files.size()).filename().string()});
    }
    return describe_in_pvd(files);
  }
  const bool is_series = !states.empty() && states.front().has_time;
  const XdmfFrame frame = frame_in_xdmf(is_series, mesh.obstacles);
  for (; described_ < states.size(); ++described_) {
    words_ += describe_in_xdmf(data().filename().string(), mesh, states[described_]);
  }
  return frame.head + words_ + frame.tail;
}

void SeriesList::forget() {
  words_.clear();
  described_ = 0;
}

}  // namespace trefoil
