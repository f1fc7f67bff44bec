#include "output/written_fields.hpp"

#include <hdf5.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "mesh/io/hdf5_reader.hpp"
#include "output/hdf5_file.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

const char *const advice = "; name a file that Trefoil has written";
const char *const field_name = "displacement";

/// Text of a file, as much of it as `most` letters. Throws InputError.
std::string read_text(const std::string &path, std::size_t most = std::string::npos) {
  std::ifstream stream(path, std::ios::binary);
  std::string text;
  if (most == std::string::npos) {
    text.assign(std::istreambuf_iterator<char>(stream), {});
  } else {
    text.resize(most);
    stream.read(text.data(), static_cast<std::streamsize>(most));
    text.resize(static_cast<std::size_t>(stream.gcount()));
  }
  if (!stream && text.empty()) throw InputError("cannot read '" + path + "'" + advice);
  return text;
}

[[noreturn]] void refuse(const std::string &path) {
  throw InputError(path + " has no displacement that can be read here" + advice);
}

/// What stands between two texts, from a place on; the place moves behind it. Throws InputError.
std::string between(const std::string &path, const std::string &text, const std::string &before,
                    const std::string &behind, std::size_t *at) {
  const std::size_t mark = text.find(before, *at);
  if (mark == std::string::npos) refuse(path);
  const std::size_t begin = mark + before.size(), end = text.find(behind, begin);
  if (end == std::string::npos) refuse(path);
  *at = end;
  return text.substr(begin, end - begin);
}

std::string unescaped(std::string text) {
  for (const auto &[entity, letter] :
       {std::pair{"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&amp;", "&"}}) {
    for (std::size_t at = 0; (at = text.find(entity, at)) != std::string::npos; ++at) {
      text.replace(at, std::strlen(entity), letter);
    }
  }
  return text;
}

/// "bar.h5:/points" of a description in `path`.
WrittenField named_in(const std::string &path, const std::string &item) {
  const std::string name = unescaped(item);
  const std::size_t colon = name.find(':');
  if (colon == std::string::npos) refuse(path);
  return {(std::filesystem::path(path).parent_path() / name.substr(0, colon)).string(),
          name.substr(colon + 1)};
}

WrittenDisplacement find_in_xdmf(const std::string &path) {
  const std::string text = read_text(path);
  const std::string attribute = std::string("<Attribute Name=\"") + field_name + "\"";
  std::size_t values = text.rfind(attribute), points = text.rfind("<Geometry ");
  if (values == std::string::npos || points == std::string::npos) refuse(path);
  const auto item = [&](std::size_t at) {
    between(path, text, "<DataItem", ">", &at);
    return named_in(path, between(path, text, ">", "</DataItem>", &at));
  };
  return {item(values), item(points)};
}

/// Arrays are appended, each behind its size.
WrittenDisplacement find_in_vtu(const std::string &path) {
  constexpr std::size_t longest_head = 1 << 20;
  constexpr PetscInt64 bytes_of_size = 8;
  const std::string text = read_text(path, longest_head),
                    mark = "<AppendedData encoding=\"raw\">\n_";
  const std::size_t data = text.find(mark);
  std::size_t at = 0;
  if (data == std::string::npos) refuse(path);
  const std::string head = text.substr(0, data);
  const std::string count = between(path, head, "NumberOfPoints=\"", "\"", &at);
  const auto array = [&](const std::string &name) {
    std::size_t place = 0;
    const std::string start = "<DataArray type=\"Float64\" Name=\"" + name + "\"";
    between(path, head, start, "offset=", &place);
    const std::string offset = between(path, head, "offset=\"", "\"", &place);
    return WrittenField{
        path, "",
        static_cast<PetscInt64>(data + mark.size()) + bytes_of_size + std::atoll(offset.c_str()),
        static_cast<PetscInt>(std::atoll(count.c_str()))};
  };
  return {array(field_name), array("Points")};
}

/// bar_0012.h5 has the fields of a state, bar.h5 the mesh.
WrittenDisplacement find_in_hdf5(const std::string &path) {
  const std::string dataset = dataset_of({field_name, true, 3});
  const std::string points = std::string("/") + points_dataset;
  const std::filesystem::path file(path);
  const std::string stem = file.stem().string();
  if (!has_dataset(path, dataset)) refuse(path);
  WrittenDisplacement found{{path, dataset}, {}};
  std::string mesh = path;
  if (!has_dataset(mesh, points)) {
    const std::string shorter = stem.substr(0, stem.rfind('_')) + file.extension().string();
    mesh = (file.parent_path() / shorter).string();
  }
  if (has_dataset(mesh, points)) found.points = {mesh, points};
  return found;
}

}  // namespace

bool has_dataset(const std::string &path, const std::string &dataset) {
  H5E_auto2_t printer = nullptr;
  void *data = nullptr;
  H5Eget_auto2(H5E_DEFAULT, &printer, &data);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const bool is_hdf5 = H5Fis_hdf5(path.c_str()) > 0;
  H5Eset_auto2(H5E_DEFAULT, printer, data);
  return is_hdf5 && Hdf5Reader(path, advice).has(dataset);
}

WrittenDisplacement find_displacement(const std::string &path) {
  const std::filesystem::path file(path);
  if (!std::ifstream(path)) {
    throw InputError("cannot read '" + path + "': " + std::strerror(errno));
  }
  if (file.extension() == ".xdmf") return find_in_xdmf(path);
  if (file.extension() == ".vtu") return find_in_vtu(path);
  return find_in_hdf5(path);
}

std::vector<double> WrittenField::read(PetscInt total, PetscInt first, PetscInt count) const {
  const bool is_in_vtu = offset.has_value();
  const auto there = [&]() -> PetscInt {
    if (is_in_vtu) return rows;
    const Hdf5Reader file(path, advice);
    return file.size(dataset) / 3;
  }();
  if (there != total) {
    throw InputError(path + " is of another mesh: " + std::to_string(there) + " vertices there, " +
                     std::to_string(total) + " here");
  }
  if (!is_in_vtu) return Hdf5Reader(path, advice).reals(dataset, 3 * first, 3 * count);
  std::vector<double> numbers(static_cast<std::size_t>(3 * count));
  const auto bytes = static_cast<std::streamsize>(sizeof(double) * numbers.size());
  std::ifstream stream(path, std::ios::binary);
  stream.seekg(*offset + static_cast<PetscInt64>(3 * sizeof(double)) * first);
  stream.read(reinterpret_cast<char *>(numbers.data()), bytes);
  if (!stream) throw InputError(path + " is truncated" + advice);
  return numbers;
}

}  // namespace trefoil
