#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/architecture/source_rules.h"

/// Checks the links of Markdown pages. Pure: whether a file exists is asked of the caller.

namespace powbench::architecture {

struct Link {
  int line = 0;
  std::string target;  ///< as written
};

/// Targets of `[text](target)`, `![text](target)`, `[name]: target` and `src="target"`, code left out.
std::vector<Link> links(const Source& page);

/// The anchors of a page's headings, as GitHub forms them: lower case, blanks to hyphens, punctuation
/// dropped,
/// `-1`, `-2` behind repeated ones.
std::vector<std::string> anchors(const Source& page);

/// One line per relative link that leads nowhere: the file is missing, or its page has no such heading.
/// `exists` takes a path relative to the top of the project.
std::vector<std::string> check_links(const std::vector<Source>& pages,
                                     const std::function<bool(const std::string&)>& exists);

}  // namespace powbench::architecture
