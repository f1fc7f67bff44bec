#include "support/part_file.hpp"

#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <regex>

namespace trefoil {
namespace {

constexpr const char *ending = ".part";

bool is_running(pid_t process) {
  return kill(process, 0) == 0 || errno == EPERM;
}

/// Who has written the part `name` of something named after `stem`; 0 where it is no such part.
pid_t writer_of(const std::string &name, const std::string &stem) {
  static const std::regex rest(R"((_\d+)?(\.[^.]+)?\.(\d{1,9})\.\w{6}\.part)");
  std::smatch found;
  if (name.compare(0, stem.size(), stem) != 0) return 0;
  const std::string behind = name.substr(stem.size());
  return std::regex_match(behind, found, rest) ? std::atoi(found[3].str().c_str()) : 0;
}

}  // namespace

std::string make_part(const std::string &path, std::string *problem) {
  struct stat there;
  problem->clear();
  if (stat(path.c_str(), &there) == 0 && S_ISDIR(there.st_mode)) {
    *problem = std::strerror(EISDIR);
    return "";
  }
  std::string part = path + "." + std::to_string(getpid()) + ".XXXXXX" + ending;
  const int descriptor = mkstemps(part.data(), static_cast<int>(std::strlen(ending)));
  if (descriptor < 0) {
    *problem = std::strerror(errno);
    return "";
  }
  const mode_t mask = umask(0);
  umask(mask);
  fchmod(descriptor, 0666 & ~mask);  // mkstemps keeps files to oneself
  close(descriptor);
  return part;
}

void remove_stale_parts(const std::string &path) {
  const std::filesystem::path place(path);
  const std::filesystem::path folder = place.has_parent_path() ? place.parent_path() : ".";
  const std::string stem = place.stem().string();
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const pid_t writer = writer_of(entry->path().filename().string(), stem);
    std::error_code ignored;
    if (writer > 0 && !is_running(writer)) std::filesystem::remove(entry->path(), ignored);
  }
}

}  // namespace trefoil
