#include "host/serve/page.h"

#include "host/report/closing_json.h"
#include "host/serve/page_assets.h"

namespace powbench::host {

std::optional<Reply> page_file(const std::string& path, const std::string& token) {
  const auto reply = [](const char* type, std::string body) {
    Reply r;
    r.type = type;
    r.body = std::move(body);
    return r;
  };
  constexpr auto script = "text/javascript; charset=utf-8", style = "text/css; charset=utf-8";
  if (path == "/") {
    std::string page(page_html);
    constexpr std::string_view hole = "{{token}}";
    if (const auto at = page.find(hole); at != std::string::npos) page.replace(at, hole.size(), token);
    return reply("text/html; charset=utf-8", page);
  }
  for (const auto& [name, text] : page_scripts)
    if (path == name) return reply(script, std::string(text));
  if (path == "/page.css") return reply(style, std::string(chart_assets().style) + std::string(page_style));
  if (path == "/chart.js")
    return reply(script, std::string(chart_assets().library) + "\n" + std::string(chart_assets().links) +
                             "\n" + std::string(chart_assets().panels));
  return std::nullopt;
}

}  // namespace powbench::host
