#include "host/cli/unknown_verb.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "host/config/nearest.h"

namespace powbench::host {

std::string unknown_verb(const CLI::App& app, int argc, char** argv) {
  constexpr std::pair<const char*, const char*> senses[] = {{"acquire", "run"},
                                                            {"measure", "run"},
                                                            {"fire", "run"},
                                                            {"record", "run"},
                                                            {"abort", "stop"},
                                                            {"kill", "stop"},
                                                            {"off", "stop"},
                                                            {"analyse", "events"},
                                                            {"analyze", "events"},
                                                            {"extract", "events"},
                                                            {"detect", "events"},
                                                            {"bounce", "events"},
                                                            {"scope", "import"},
                                                            {"oscilloscope", "import"},
                                                            {"read", "import"},
                                                            {"convert", "export"},
                                                            {"merge", "db merge"},
                                                            {"push", "db push"},
                                                            {"pull", "db pull"},
                                                            {"migrate", "db migrate"},
                                                            {"magnet", "field"},
                                                            {"mesh", "field"},
                                                            {"shoot", "run"},
                                                            {"simulate", "sim"},
                                                            {"list", "campaigns"},
                                                            {"ls", "campaigns"},
                                                            {"html", "report"},
                                                            {"pdf", "report"},
                                                            {"emulate", "rig"},
                                                            {"best", "sweep"},
                                                            {"optimise", "sweep"},
                                                            {"identify", "fit"},
                                                            {"draw", "plot"},
                                                            {"view", "show"},
                                                            {"csv", "export"},
                                                            {"check", "plan check"},
                                                            {"validate", "plan check"},
                                                            {"template", "plan template"},
                                                            {"note", "annotate"},
                                                            {"diff", "compare"},
                                                            {"load", "import"},
                                                            {"man", "help"},
                                                            {"gui", "serve"},
                                                            {"live", "serve"},
                                                            {"browser", "serve"},
                                                            {"shot", "show"},
                                                            {"version", "--version"}};
  const CLI::App* at = &app;
  std::string before;
  for (int i = 1; i < argc && argv[i][0] != '-'; ++i) {
    std::vector<std::string> verbs;
    const CLI::App* next = nullptr;
    for (const CLI::App* verb : at->get_subcommands([](const CLI::App*) { return true; })) {
      verbs.push_back(verb->get_name());
      if (verbs.back() == argv[i]) next = verb;
    }
    if (verbs.empty()) return {};
    if (next != nullptr) {
      at = next;
      before += std::string(argv[i]) + " ";
      continue;
    }
    std::string meant = nearest(argv[i], verbs);
    for (const auto& [word, verb] : senses)
      if (at == &app && word == std::string_view(argv[i])) meant = verb;
    return fmt::format("powbench: no verb '{}{}'{}; powbench {}--help lists them", before, argv[i],
                       meant.empty() ? "" : fmt::format("; did you mean 'powbench {}{}'?", before, meant),
                       before);
  }
  return {};
}

std::string parse_failure(const CLI::App* app, const CLI::Error& error) {
  std::string verbs;
  const CLI::App* at = app;
  while (!at->get_subcommands().empty()) {
    at = at->get_subcommands().front();
    verbs += " " + at->get_name();
  }
  std::string text = error.what();
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError)) {
    const std::vector<std::string> extra = app->remaining(true);
    std::vector<std::string> options;
    for (const CLI::Option* option : at->get_options())
      if (!option->get_lnames().empty()) options.push_back("--" + option->get_lnames().front());
    const std::string word = extra.empty() ? "" : extra.front().substr(0, extra.front().find('='));
    text =
        fmt::format("'{}' is {} of this verb", word, word.starts_with("-") ? "no option" : "a word too many");
    if (const std::string meant = word.starts_with("--") ? nearest(word, options) : ""; !meant.empty())
      text += fmt::format("; did you mean '{}'?", meant);
    if (word.ends_with(".db") && at->get_option_no_throw("--db"))
      text += fmt::format("; name a store with --db {}", word);
  }
  // what is missing, in the words of its help
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::RequiredError))
    for (const CLI::Option* option : at->get_options())
      if (option->get_positional() && text.starts_with(option->get_name(true) + " is required"))
        text += " (" + option->get_description() + ")";
  for (char& c : text)
    if (c == '\n') c = ' ';
  return fmt::format("powbench{}: {}; powbench{} --help explains\n", verbs, text, verbs);
}

}  // namespace powbench::host
