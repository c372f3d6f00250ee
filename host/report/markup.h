#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace powbench::host {

/// Writes HTML, SVG or XML that is well-formed by construction: every text and attribute is escaped, every element
/// closed in order. Markup gets in only through `embed`, from another Markup.
class Markup {
 public:
  using Attributes = std::initializer_list<std::pair<std::string_view, std::string_view>>;

  /// Opens an element; `close` or `str` must follow.
  Markup& open(std::string_view tag, Attributes = {});
  Markup& close();
  Markup& text(std::string_view);

  /// <tag ...>text</tag>
  Markup& element(std::string_view tag, std::string_view content, Attributes = {});
  /// <tag .../>
  Markup& empty(std::string_view tag, Attributes = {});

  /// <style> or <script>, whose content no reader unescapes: it must hold none of < & and is taken as it is. Throws
  /// std::invalid_argument.
  Markup& verbatim(std::string_view tag, std::string_view content, Attributes = {});

  /// The finished content of another Markup. Its elements must all be closed.
  Markup& embed(const Markup&);

  /// What has been written. All elements must be closed.
  const std::string& str() const;

  bool finished() const { return open_.empty(); }

 private:
  void start(std::string_view tag, Attributes);

  std::string out_;
  std::vector<std::string> open_;
};

}  // namespace powbench::host
