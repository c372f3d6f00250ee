#include "host/cli/manual.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <regex>

#include "core/version.h"
#include "host/config/plan_file.h"
#include "host/config/rig_file.h"
#include "host/config/solenoid_file.h"
#include "host/config/specimen_file.h"
#include "host/import/calibration.h"

namespace powbench::host {

namespace {

bool is_shown(const CLI::App* verb) {
  return !verb->get_group().empty();
}

void collect(const CLI::App& app, const std::string& words, std::map<std::string, const CLI::App*>& all) {
  all[words] = &app;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App* v) { return is_shown(v); }))
    collect(*verb, words + (words.empty() ? "" : " ") + verb->get_name(), all);
}

std::vector<const CLI::Option*> options_of(const CLI::App& app) {
  return app.get_options([](const CLI::Option* o) { return !o->get_group().empty(); });
}

/// `{a,b,c}` in an option's type are its values; empty without.
std::vector<std::string> values_of(const CLI::Option& option) {
  static const std::regex list(R"(\{([^}]*)\})");
  std::smatch found;
  const std::string type = option.get_type_name();
  std::vector<std::string> values;
  if (!std::regex_search(type, found, list)) return values;
  const std::string text = found[1].str();
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    values.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return values;
}

bool takes_value(const CLI::Option& o) {
  return o.get_items_expected_max() > 0 && !o.get_type_name().empty();
}

/// "-o,--output TEXT" or "plan".
std::string names_of(const CLI::Option& o) {
  if (o.get_positional()) return o.get_name(true);
  std::string name = o.get_name(false, true);
  if (const auto values = values_of(o); !values.empty())
    name += " " + fmt::format("{}", fmt::join(values, "|"));
  else if (takes_value(o))
    name += " " + o.get_type_name();
  return name;
}

std::string meaning_of(const CLI::Option& o) {
  std::string text = o.get_description();
  if (!o.get_default_str().empty()) text += " (default: " + o.get_default_str() + ")";
  if (o.get_required()) text += " (required)";
  return text;
}

std::string synopsis(const CLI::App& app, const std::string& words) {
  std::string text = "powbench" + (words.empty() ? "" : " " + words);
  if (!app.get_subcommands([](const CLI::App* v) { return is_shown(v); }).empty()) return text + " VERB ...";
  text += " [OPTIONS]";
  for (const CLI::Option* o : options_of(app))
    if (o->get_positional())
      text += o->get_required() ? " " + o->get_name(true) : " [" + o->get_name(true) + "]";
  return text;
}

/// Text as roff has it: no line begins with a control character, minus signs stay minus signs.
std::string roff(const std::string& text) {
  std::string out;
  bool begins = true;
  for (const char c : text) {
    if (begins && (c == '.' || c == '\'')) out += "\\&";
    begins = c == '\n';
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
  }
  return out;
}

std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

std::string verbatim(const std::string& text) {
  return ".nf\n" + roff(text) + "\n.fi\n";
}

/// Characters that a Markdown table takes for its own.
std::string cell(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '|' || c == '<') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out;
}

std::string page_name(const std::string& words) {
  std::string name = "powbench" + (words.empty() ? "" : " " + words);
  for (char& c : name)
    if (c == ' ') c = '-';
  return name;
}

}  // namespace

std::map<std::string, const CLI::App*> shown_verbs(const CLI::App& app) {
  std::map<std::string, const CLI::App*> all;
  collect(app, "", all);
  return all;
}

std::string manual_page(const CLI::App& program, const std::string& words) {
  const auto verbs = shown_verbs(program);
  const CLI::App& app = *verbs.at(words);
  std::string title = page_name(words);
  std::transform(title.begin(), title.end(), title.begin(), [](unsigned char c) { return std::toupper(c); });
  std::string text = fmt::format(
      ".TH \"{}\" 1 \"\" \"powbench {}\" \"powbench\"\n.SH NAME\n{} \\- {}\n", roff(title), program_version,
      roff(page_name(words)),
      roff(words.empty() ? "point-on-wave test bench for AC contactors" : first_line(app.get_description())));
  text += ".SH SYNOPSIS\n.B " + roff(synopsis(app, words)) + "\n.SH DESCRIPTION\n" +
          verbatim(app.get_description());
  std::string commands;
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App* v) { return is_shown(v); }))
    commands +=
        fmt::format(".TP\n.B {}\n{}\n", roff(verb->get_name()), roff(first_line(verb->get_description())));
  if (!commands.empty()) text += ".SH VERBS\n" + commands;
  std::string options;
  for (const CLI::Option* o : options_of(app))
    options += fmt::format(".TP\n.B {}\n{}\n", roff(names_of(*o)), roff(meaning_of(*o)));
  if (!options.empty()) text += ".SH OPTIONS\n" + options;
  if (const std::string footer = app.get_footer(); !footer.empty()) text += ".SH NOTES\n" + verbatim(footer);
  std::string others;
  for (const auto& [other, unused] : verbs)
    if (other != words &&
        (words.empty() || other.empty() || other.starts_with(words + " ") || words.starts_with(other + " ")))
      others += (others.empty() ? "" : ",\n") + fmt::format(".BR {} (1)", roff(page_name(other)));
  // the comma stands behind the page's number
  std::string see;
  for (std::size_t at = 0; at < others.size();) {
    const std::size_t end = std::min(others.find(",\n", at), others.size());
    see += others.substr(at, end - at) + (end < others.size() ? ",\n" : "\n");
    at = end + 2;
  }
  return text + ".SH SEE ALSO\n" + see;
}

std::string bash_completion(const CLI::App& program) {
  const auto verbs = shown_verbs(program);
  std::string known, words_of, values;
  for (const auto& [words, app] : verbs) {
    if (!words.empty()) known += (known.empty() ? "" : " | ") + fmt::format("'{}'", words);
    std::vector<std::string> words_here;
    for (const CLI::App* verb : app->get_subcommands([](const CLI::App* v) { return is_shown(v); }))
      words_here.push_back(verb->get_name());
    for (const CLI::Option* o : options_of(*app)) {
      const auto listed = values_of(*o);
      if (o->get_positional()) words_here.insert(words_here.end(), listed.begin(), listed.end());
      for (const std::string& name : o->get_lnames()) {
        words_here.push_back("--" + name);
        if (!listed.empty())
          values += fmt::format("    '{} --{}') words='{}' ;;\n", words, name, fmt::join(listed, " "));
      }
    }
    words_of += fmt::format("    '{}') words='{}' ;;\n", words, fmt::join(words_here, " "));
  }
  return fmt::format(
      "# bash completion for powbench; written by `powbench manual` from the program's own command tree\n"
      "_powbench() {{\n"
      "  local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD - 1]}} path= words= i\n"
      "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
      "    case \"${{path:+$path }}${{COMP_WORDS[i]}}\" in\n"
      "      {}) path=\"${{path:+$path }}${{COMP_WORDS[i]}}\" ;;\n"
      "    esac\n"
      "  done\n"
      "  case $path in\n{}  esac\n"
      "  case \"$path $prev\" in\n{}  esac\n"
      "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$cur\")\n"
      "}}\n"
      "complete -o bashdefault -o default -F _powbench powbench\n",
      known, words_of, values);
}

std::string command_reference(const CLI::App& program) {
  std::string text =
      "# Commands\n\nFor whoever runs powbench by hand or from a script. Made from the program's own command "
      "tree, as are `--help` "
      "and the manual pages.\n";
  for (const auto& [words, app] : shown_verbs(program)) {
    text +=
        fmt::format("\n## powbench{}{}\n\n{}\n\n```\n{}\n```\n", words.empty() ? "" : " ", words,
                    words.empty() ? "The program itself." : app->get_description(), synopsis(*app, words));
    std::string rows;
    for (const CLI::Option* o : options_of(*app))
      rows += fmt::format("| `{}` | {} |\n", cell(names_of(*o)), cell(meaning_of(*o)));
    if (!rows.empty()) text += "\n| option | meaning |\n|---|---|\n" + rows;
    if (const std::string footer = app->get_footer(); !footer.empty())
      text += "\n```\n" + footer.substr(footer.find_first_not_of('\n')) + "\n```\n";
  }
  return text;
}

std::string file_reference() {
  std::string text =
      "# Files\n\nEvery key of the four kinds of file, with its unit, range and default, as `powbench plan "
      "template KIND` prints "
      "them.\n";
  const std::pair<const char*, std::string> kinds[] = {{"plan", plan_template()},
                                                       {"rig", rig_template()},
                                                       {"specimen", specimen_template()},
                                                       {"solenoid", solenoid_template()},
                                                       {"calibration", calibration_template()}};
  for (const auto& [kind, file] : kinds) text += fmt::format("\n## {}\n\n```toml\n{}```\n", kind, file);
  return text;
}

}  // namespace powbench::host
