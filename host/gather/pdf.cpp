#include "host/gather/pdf.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <sstream>
#include <vector>

#include "host/config/bad_input.h"
#include "host/store/store.h"

extern char** environ;

namespace powbench::host {

namespace fs = std::filesystem;

std::string find_browser() {
  if (const char* named = std::getenv("POWBENCH_BROWSER"); named != nullptr && *named != 0) return named;
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  std::vector<fs::path> list;
  for (std::string folder; std::getline(folders, folder, ':');) list.emplace_back(folder);
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"})
    for (const fs::path& folder : list)
      if (access((folder / name).c_str(), X_OK) == 0) return (folder / name).string();
  return {};
}

void print_pdf(const fs::path& html, const fs::path& pdf) {
  const std::string browser = find_browser();
  if (browser.empty())
    throw BadInput(
        {"--pdf: no browser is installed to print with; install Debian's chromium, or name one in "
         "POWBENCH_BROWSER"});
  if (access(browser.c_str(), X_OK) != 0)
    throw BadInput(
        {"POWBENCH_BROWSER: " + browser + " is no program that can be started; allowed: a Chromium"});
  fs::remove(pdf);
  std::vector<std::string> words{browser,
                                 "--headless",
                                 "--disable-gpu",
                                 "--no-pdf-header-footer",
                                 "--print-to-pdf=" + fs::absolute(pdf).string(),
                                 "file://" + fs::absolute(html).string()};
  if (geteuid() == 0) words.insert(words.begin() + 1, "--no-sandbox");  // it refuses to run as root otherwise
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t silent;
  posix_spawn_file_actions_init(&silent);
  posix_spawn_file_actions_addopen(&silent, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&silent, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int error = posix_spawn(&child, browser.c_str(), &silent, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&silent);
  int status = 0;
  const bool ended = error == 0 && waitpid(child, &status, 0) == child;
  std::error_code missing;
  if (!ended || !WIFEXITED(status) || WEXITSTATUS(status) != 0 || fs::file_size(pdf, missing) == 0 || missing)
    throw StoreError(pdf.string() + ": " + browser + " did not print it; the page itself is " +
                     html.string());
}

}  // namespace powbench::host
