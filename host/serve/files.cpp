#include "host/serve/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

#include "host/store/store.h"

namespace powbench::host {

std::string written_file(const std::string& kind, const std::vector<KeyLine>& values,
                         const std::vector<KeyLine>& defaults) {
  std::string needed, section;
  for (const KeyLine& k : values)
    if (k.required) needed += (needed.empty() ? "" : ", ") + k.key;
  std::string out = "# powbench " + kind + " file; a key that is left out has its default" +
                    (needed.empty() ? "" : "; needed: " + needed) + "\n";
  for (std::size_t i = 0; i < values.size(); ++i) {
    const KeyLine& k = values[i];
    if (k.value.empty() || (!k.required && i < defaults.size() && k.value == defaults[i].value)) continue;
    if (k.section != section) out += "\n[" + k.section + "]  # " + k.section_meaning + "\n";
    section = k.section;
    out += fmt::format("{} = {}  # {}{}\n", k.key, k.value, k.meaning,
                       k.allowed.empty() ? "" : "; allowed " + k.allowed);
  }
  return out;
}

void replace_file(const std::string& path, const std::string& text) {
  const std::string aside = path + ".new";
  const int file = ::open(aside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  bool good = file >= 0;
  for (std::size_t at = 0; good && at < text.size();) {
    const ssize_t n = ::write(file, text.data() + at, text.size() - at);
    good = n > 0;
    if (good) at += static_cast<std::size_t>(n);
  }
  good = good && ::fsync(file) == 0;
  if (file >= 0) good = ::close(file) == 0 && good;
  if (good && std::rename(aside.c_str(), path.c_str()) == 0) return;
  if (file >= 0) ::unlink(aside.c_str());
  throw StoreError(path + ": cannot be written; check the folder, its permissions and the disk");
}

}  // namespace powbench::host
