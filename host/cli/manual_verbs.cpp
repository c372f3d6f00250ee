#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "host/cli/commands.h"
#include "host/cli/manual.h"
#include "host/cli/unknown_verb.h"
#include "host/export/write_file.h"
#include "host/store/store.h"

namespace powbench::host {

namespace {

void write(const std::filesystem::path& file, const std::string& text) {
  std::error_code ignored;
  std::filesystem::create_directories(file.parent_path(), ignored);
  write_file(file, text);
}

Exit write_manual(const CLI::App& program, const std::filesystem::path& folder) {
  for (const auto& [words, unused] : shown_verbs(program)) {
    std::string name = "powbench" + (words.empty() ? "" : " " + words);
    std::replace(name.begin(), name.end(), ' ', '-');
    write(folder / "man" / (name + ".1"), manual_page(program, words));
  }
  write(folder / "completions" / "powbench", bash_completion(program));
  write(folder / "reference" / "commands.md", command_reference(program));
  write(folder / "reference" / "files.md", file_reference());
  return Exit::pass;
}

Exit show_help(const CLI::App& program, const std::vector<std::string>& words) {
  std::string path;
  for (const std::string& word : words) path += (path.empty() ? "" : " ") + word;
  const auto verbs = shown_verbs(program);
  if (const auto verb = verbs.find(path); verb != verbs.end()) {
    // not help(): while a verb runs, that is the help of this verb
    const std::string name = "powbench" + (path.empty() ? "" : " " + path);
    fmt::print("{}",
               verb->second->get_formatter()->make_help(verb->second, name, CLI::AppFormatMode::Normal));
    return Exit::pass;
  }
  std::vector<char*> typed{nullptr};
  std::vector<std::string> copy = words;
  for (std::string& word : copy) typed.push_back(word.data());
  const std::string wrong = unknown_verb(program, static_cast<int>(typed.size()), typed.data());
  fmt::print(stderr, "{}\n",
             wrong.empty() ? "powbench: no verb '" + path + "'; powbench --help lists them" : wrong);
  return Exit::bad_input;
}

}  // namespace

void add_manual_verbs(CLI::App& program) {
  auto words = std::make_shared<std::vector<std::string>>();
  CLI::App* help = program.add_subcommand("help", "What a verb does, with its options: powbench help run");
  help->add_option("verb", *words, "verb, such as run or plan check; the program itself if left out");
  help->callback([&program, words] { chosen() = [&program, words] { return show_help(program, *words); }; });

  auto folder = std::make_shared<std::string>();
  CLI::App* manual = program.add_subcommand("manual", "Write manual pages, completion and reference");
  manual->group("");  // for the build; nobody is shown it
  manual->add_option("-o,--output", *folder, "folder; made if missing")->required();
  manual->callback(
      [&program, folder] { chosen() = [&program, folder] { return write_manual(program, *folder); }; });
}

}  // namespace powbench::host
