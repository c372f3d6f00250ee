#include <algorithm>
#include <catch2/catch.hpp>
#include <regex>
#include <set>

#include "tests/places.h"
#include "tests/serve/served.h"

using namespace powbench;
using namespace powbench::test;
using Catch::Contains;
using nlohmann::json;

TEST_CASE("live bench: the description lists every call that answers", "[serve]") {
  const Served s;
  REQUIRE(s.ask("POST", "/api/fire", R"({"angle_deg": 90})").status == 202);
  s.until_ended();
  const json api = s.get("/api");
  CHECK(api.at("openapi") == "3.0.3");
  CHECK(api.at("paths").size() >= 15);
  int compared = 0;
  for (const auto& [path, methods] : api.at("paths").items())
    for (const auto& [method, operation] : methods.items()) {
      CAPTURE(path, method);
      std::string name = method, place = path;
      for (char& c : name) c = static_cast<char>(std::toupper(c));
      if (const auto hole = place.find("{id}"); hole != std::string::npos)
        place.replace(hole, 4, path.ends_with(".pdf") ? "12345" : "1");  // paper takes a browser
      const bool harmless = place.ends_with("/check") || place.ends_with("/set");
      const std::string body =
          !operation.contains("requestBody") ? ""
          : harmless ? operation.at("requestBody").at("content").at("application/json").at("example").dump()
                     : "{}";
      const host::Reply r = s.ask(name, place, body);
      if (harmless) CHECK(r.status == 200);
      CHECK(r.status != 405);
      if (operation.at("responses").contains("101")) {  // tests/serve/test_http.cpp opens them
        CHECK(r.status == 426);
        const json& messages = operation.at("responses").at("101").at("content");
        if (path == std::string("/api/live"))
          CHECK(messages ==
                api.at("paths").at("/api/bench").at("get").at("responses").at("2XX").at("content"));
        continue;
      }
      // what is described is what comes, field by field
      const json& content = operation.at("responses").at("2XX").at("content");
      if (r.status < 300 && content.contains("application/json")) {
        json schema = content.at("application/json").at("schema"), got = json::parse(r.body);
        if (schema.at("type") == "array") schema = schema.at("items"), got = got.empty() ? json() : got.at(0);
        const json described = schema.value("properties", json::object());
        if (!described.empty() && got.is_object()) {
          std::vector<std::string> told, came;
          for (const auto& [key, value] : described.items()) told.push_back(key);
          for (const auto& [key, value] : got.items()) came.push_back(key);
          CHECK(told == came);
          ++compared;
        }
      }
      // without a token only what the description says
      host::Request bare;
      bare.method = name;
      bare.path = place;
      bare.host = here;
      const bool open = operation.at("security").empty();
      if (open) CHECK(s.api.answer(bare).status == 200);
    }
  CHECK(compared >= 15);
  s.until_ended();
}

TEST_CASE("live bench: the description has every address of code and page, and no other", "[serve]") {
  const Served s;
  const auto calls = s.get("/api").at("paths");
  std::set<std::string> described, in_code, in_page;
  for (const auto& [path, unused] : calls.items()) described.insert(path);
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(test::source_dir()) / "host/serve";
  // as a row of a table or a constant has it: the text begins with it and is nothing else
  const std::regex whole("\"(/api(?:/[A-Za-z0-9_.{}/-]+)?)\"");
  for (const auto& file : fs::directory_iterator(folder)) {
    if (!file.is_regular_file() || (file.path().extension() != ".cpp" && file.path().extension() != ".h"))
      continue;
    const std::string text = read_file(file.path().string());
    for (std::sregex_iterator it(text.begin(), text.end(), whole), end; it != end; ++it)
      in_code.insert((*it)[1]);
  }
  CHECK(described == in_code);
  // what the page asks for: '/api/shots/' + id + '/closing', '/api/files/' + kind
  const std::regex part("'(/api[A-Za-z0-9_./-]*)[?']((?: \\+ [a-zA-Z.'()-]+ \\+ '([A-Za-z0-9_./-]*)')?)");
  std::size_t looked = 0;
  for (const auto& file : fs::directory_iterator(folder / "page")) {
    const std::string text = read_file(file.path().string());
    for (std::sregex_iterator it(text.begin(), text.end(), part), end; it != end; ++it) {
      const std::string begin = (*it)[1], rest = (*it)[3];
      CAPTURE(file.path().filename().string(), it->str());
      ++looked;
      const bool known = std::any_of(described.begin(), described.end(), [&](const std::string& path) {
        return begin.back() == '/' ? path.starts_with(begin) && path.ends_with(rest) && path != begin
                                   : path == begin;
      });
      CHECK(known);
    }
  }
  CHECK(looked >= 20);
}
