#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace trefoil {

/// A mesh file, held whole in memory and read from front to back, as text or as binary numbers.
/// Every error is an InputError of one sentence that begins with the file and the place in it: the
/// line of the item read last, in a binary file its byte.
class MeshFile {
 public:
  /// Reads the file at `path`; an InputError if there is none, if it is empty or no regular file.
  explicit MeshFile(const std::string &path);

  /// From here on the rest of a line after `sign` counts as blank.
  void treat_as_comment(char sign) { comment_sign_ = sign; }
  /// From here on errors name a byte instead of a line.
  void treat_as_binary() { is_binary_ = true; }

  [[nodiscard]] const std::string &path() const { return path_; }
  /// What is not read yet.
  [[nodiscard]] std::string_view rest() const { return std::string_view(bytes_).substr(position_); }

  /// The next word, up to a blank or a comment; empty at the end of the file.
  std::string_view next_word();
  /// The same, without moving on.
  std::string_view peek_word();
  /// Reads a word that must be `expected`.
  void expect_word(std::string_view expected);
  /// Reads what stands between two quotation marks, blanks and all; they must come next.
  std::string quotation(const char *what);
  /// Moves behind the next occurrence of `marker` as a word's end; false if there is none.
  bool skip_past(std::string_view marker);
  /// Moves to the next line; nothing but blanks may stand before it. Binary numbers follow there.
  void end_line();

  /// The next word as a number; `what` names it in the error. A real may come out infinite or NaN.
  std::int64_t integer(const char *what);
  double real(const char *what);
  /// The next bytes as a little-endian number of type Number.
  template <class Number>
  Number binary(const char *what);

  /// Refuses `count` items of `what`, at least `bytes_each` long, that the rest of the file has no
  /// room for: called before anything is allocated for them.
  void check_room(std::int64_t count, std::size_t bytes_each, const char *what) const;
  /// Refuses an array of count x width entries that PetscInt cannot number.
  void check_numbering(std::int64_t count, int width, const char *what) const;

  /// Throws InputError: "<file>, line <n>: <sentence>".
  [[noreturn]] void fail(const std::string &sentence) const;
  /// Throws InputError: "<file>: <sentence>", for what is wrong with the file as a whole.
  [[noreturn]] void fail_as_a_whole(const std::string &sentence) const;

 private:
  [[nodiscard]] bool is_blank(char character) const;
  void skip_blanks();
  [[noreturn]] void fail_at_end(const char *what) const;

  std::string path_;
  std::string bytes_;
  std::size_t position_ = 0;
  std::size_t item_ = 0;  // where the item read last begins
  char comment_sign_ = '\0';
  bool is_binary_ = false;
};

template <class Number>
Number MeshFile::binary(const char *what) {
  item_ = position_;
  if (bytes_.size() - position_ < sizeof(Number)) fail_at_end(what);
  Number number;
  std::memcpy(&number, bytes_.data() + position_, sizeof(Number));
  position_ += sizeof(Number);
  return number;
}

/// A word of a file as an error message may show it: in quotes, shortened, without control bytes.
std::string quoted(std::string_view word);

}  // namespace trefoil
