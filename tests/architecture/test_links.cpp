#include <catch2/catch.hpp>

#include "tests/architecture/links.h"
#include "tests/architecture/tree.h"

using namespace powbench::architecture;

TEST_CASE("every relative link in the documents leads somewhere") {
  const auto pages = read_tree({".md"});
  REQUIRE_FALSE(pages.empty());
  const auto wrong = check_links(
      pages, [](const std::string& path) { return std::filesystem::exists(project_root() / path); });
  INFO(joined(wrong));
  CHECK(wrong.empty());
}

TEST_CASE("every decision is in the index of decisions") {
  const auto pages = read_tree({".md"});
  std::vector<std::string> listed;
  for (const auto& page : pages)
    if (page.path == "docs/decisions/README.md")
      for (const auto& link : links(page)) listed.push_back("docs/decisions/" + link.target);
  for (const auto& page : pages) {
    if (!page.path.starts_with("docs/decisions/0")) continue;
    INFO(page.path);
    CHECK(std::find(listed.begin(), listed.end(), page.path) != listed.end());
  }
}

TEST_CASE("the documents are finished and name no machine's paths") {
  const auto wrong = check_text(read_tree({".md"}));
  INFO(joined(wrong));
  CHECK(wrong.empty());
}

TEST_CASE("links are found in their four forms and not in code") {
  const Source page{"docs/a.md",
                    "see [b](b.md#x) and ![p](p.svg \"title\")\n`[no](no.md)`\n```\n[no](no.md)\n```\n"
                    "[c]: c.md\n<img src=\"d.png\">\n"};
  const auto found = links(page);
  REQUIRE(found.size() == 4);
  CHECK(found[0].target == "b.md#x");
  CHECK(found[1].target == "p.svg");
  CHECK(found[2].target == "c.md");
  CHECK(found[2].line == 6);
  CHECK(found[3].target == "d.png");
}

TEST_CASE("headings become anchors") {
  const Source page{"a.md", "# To add: a `channel`\n## Same\n## Same\n```\n# not this\n```\n"};
  CHECK(anchors(page) == std::vector<std::string>{"to-add-a-channel", "same", "same-1"});
}

TEST_CASE("a link that leads nowhere is caught") {
  const auto exists = [](const std::string& path) { return path == "docs/b.md" || path == "README.md"; };
  const auto check = [&](const std::string& text) {
    return check_links({{"docs/a.md", text}, {"docs/b.md", "# Title\n"}}, exists).size();
  };
  CHECK(check("[b](b.md) [top](../README.md) [web](https://example.org/x.md)") == 0);
  CHECK(check("[b](b.md#title)") == 0);
  CHECK(check("[b](missing.md)") == 1);
  CHECK(check("[b](b.md#absent)") == 1);
  CHECK(check("[b](../../outside.md)") == 1);
}
