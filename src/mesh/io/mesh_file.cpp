#include "mesh/io/mesh_file.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>

#include "mesh/cell_list.hpp"

namespace trefoil {
namespace {

static_assert(std::endian::native == std::endian::little, "binary meshes are read as they stand");

std::string read_whole_file(const std::string &path) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  if (status.type() == std::filesystem::file_type::not_found)
    throw InputError(path + ": there is no such file; check the name of the mesh file");
  if (std::filesystem::is_directory(status))
    throw InputError(path + ": is a directory; name a mesh file in it");
  if (status.type() != std::filesystem::file_type::unknown &&
      status.type() != std::filesystem::file_type::none &&
      !std::filesystem::is_regular_file(status))
    throw InputError(path + ": is no regular file; save the mesh to a file on disk");

  std::ifstream stream(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = stream ? static_cast<std::streamoff>(stream.tellg()) : -1;
  if (size < 0) throw InputError(path + ": cannot be opened; check its permissions");
  if (size == 0) throw InputError(path + ": is empty; save the mesh again");
  std::string bytes(static_cast<std::size_t>(size), '\0');
  stream.seekg(0);
  if (!stream.read(bytes.data(), size))
    throw InputError(path + ": cannot be read to its end; check the disk it lies on");
  return bytes;
}

// from_chars calls both too large and too small out of range, but 1e-400 is as good as 0.
double beyond_double(std::string_view digits) {
  return std::strtod(std::string(digits).c_str(), nullptr);
}

}  // namespace

std::string quoted(std::string_view word) {
  constexpr std::size_t longest = 24;
  std::string shown(word.substr(0, longest));
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return "'" + shown + (word.size() > longest ? "...'" : "'");
}

MeshFile::MeshFile(const std::string &path) : path_(path), bytes_(read_whole_file(path)) {
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (rest().starts_with(byte_order_mark)) position_ = byte_order_mark.size();
}

bool MeshFile::is_blank(char character) const {
  return character == ' ' || (character >= '\t' && character <= '\r');
}

void MeshFile::skip_blanks() {
  while (position_ < bytes_.size()) {
    const char character = bytes_[position_];
    if (comment_sign_ != '\0' && character == comment_sign_)
      position_ = std::min(bytes_.find('\n', position_), bytes_.size());
    else if (is_blank(character))
      ++position_;
    else
      return;
  }
}

std::string_view MeshFile::next_word() {
  skip_blanks();
  item_ = position_;
  while (position_ < bytes_.size()) {
    const char character = bytes_[position_];
    if (is_blank(character) || (comment_sign_ != '\0' && character == comment_sign_)) break;
    ++position_;
  }
  return std::string_view(bytes_).substr(item_, position_ - item_);
}

std::string_view MeshFile::peek_word() {
  const std::string_view word = next_word();
  position_ = item_;
  return word;
}

void MeshFile::expect_word(std::string_view expected) {
  const std::string_view word = next_word();
  if (word == expected) return;
  if (word.empty()) fail_at_end(std::string(expected).c_str());
  fail("found " + quoted(word) + " where " + std::string(expected) +
       " should be, so a count does not match what follows it; save the mesh again");
}

std::string MeshFile::quotation(const char *what) {
  skip_blanks();
  item_ = position_;
  if (position_ == bytes_.size()) fail_at_end(what);
  const std::size_t end = bytes_.find('"', position_ + 1);
  if (bytes_[position_] != '"' || end == std::string::npos)
    fail(std::string(what) + " does not stand in quotation marks; save the mesh again");
  position_ = end + 1;
  return bytes_.substr(item_ + 1, end - item_ - 1);
}

bool MeshFile::skip_past(std::string_view marker) {
  for (std::size_t found = position_; (found = bytes_.find(marker, found)) != std::string::npos;) {
    found += marker.size();
    if (found < bytes_.size() && !is_blank(bytes_[found])) continue;
    position_ = found;
    return true;
  }
  return false;
}

void MeshFile::end_line() {
  while (position_ < bytes_.size() && is_blank(bytes_[position_]))
    if (bytes_[position_++] == '\n') return;
  if (position_ == bytes_.size()) fail_at_end("the end of a line");
  fail("the line goes on where binary numbers should begin; save the mesh again");
}

std::int64_t MeshFile::integer(const char *what) {
  const std::string_view word = next_word();
  if (word.empty()) fail_at_end(what);
  const char *end = word.data() + word.size();
  const char *begin = word.data() + (word.front() == '+' ? 1 : 0);
  std::int64_t number = 0;
  const auto [stop, error] = std::from_chars(begin, end, number);
  if (error != std::errc() || stop != end)
    fail("expected " + std::string(what) + ", a whole number, but found " + quoted(word) +
         "; correct the file or save the mesh again");
  return number;
}

double MeshFile::real(const char *what) {
  const std::string_view word = next_word();
  if (word.empty()) fail_at_end(what);
  const char *end = word.data() + word.size();
  const char *begin = word.data() + (word.front() == '+' ? 1 : 0);
  double number = 0;
  const auto [stop, error] = std::from_chars(begin, end, number);
  if (error == std::errc::invalid_argument || stop != end)
    fail("expected " + std::string(what) + ", a number, but found " + quoted(word) +
         "; correct the file or save the mesh again");
  return error == std::errc() ? number : beyond_double(word);
}

void MeshFile::check_room(std::int64_t count, std::size_t bytes_each, const char *what) const {
  // The last item of a text needs no blank behind it: one byte less.
  const std::size_t room = (rest().size() + 1) / std::max<std::size_t>(bytes_each, 1);
  if (count < 0)
    fail("the number of " + std::string(what) + " is " + std::to_string(count) +
         ", which is out of range; save the mesh again");
  if (static_cast<std::uint64_t>(count) > room)
    fail("the file announces " + std::to_string(count) + " " + what +
         " but ends before them, so it is truncated or damaged; save the mesh again");
}

void MeshFile::check_numbering(std::int64_t count, int width, const char *what) const {
  if (count > std::numeric_limits<PetscInt>::max() / width)
    fail_as_a_whole("has " + std::to_string(count) + " " + what +
                    ", more than this PETSc can number; use a PETSc with 64-bit indices");
}

void MeshFile::fail_at_end(const char *what) const {
  fail_as_a_whole("ends where " + std::string(what) +
                  " should be, so it is truncated; save the mesh again");
}

void MeshFile::fail(const std::string &sentence) const {
  const auto line =
      1 + std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(item_), '\n');
  const std::string place =
      is_binary_ ? ", byte " + std::to_string(item_) : ", line " + std::to_string(line);
  throw InputError(path_ + place + ": " + sentence);
}

void MeshFile::fail_as_a_whole(const std::string &sentence) const {
  throw InputError(path_ + ": " + sentence);
}

}  // namespace trefoil
