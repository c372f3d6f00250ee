#pragma once

#include <map>
#include <string>

namespace CLI {
class App;
}

/// What is made of the command tree itself, so that it cannot differ from `--help`: manual pages, shell completion,
/// the reference.

namespace powbench::host {

/// The verbs of `app` that a person is shown, by their words: "run", "plan check"; "" is the program itself. In the
/// order of the help.
std::map<std::string, const CLI::App*> shown_verbs(const CLI::App& app);

/// Text of the manual page of one verb (roff, section 1); `words` as in shown_verbs.
std::string manual_page(const CLI::App& program, const std::string& words);
/// Verbs, options and the values of those that have a list, for bash.
std::string bash_completion(const CLI::App& program);
/// Every verb and option as one Markdown page.
std::string command_reference(const CLI::App& program);
/// Every key of the four kinds of file: the commented templates, as one Markdown page.
std::string file_reference();

}  // namespace powbench::host
