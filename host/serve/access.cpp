#include "host/serve/access.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <sstream>

#include "host/config/bad_input.h"

namespace powbench::host {
namespace {

constexpr std::size_t shortest_token = 16, longest_token = 128;

/// In a time that does not tell how much of it is right.
bool equal(const std::string& a, const std::string& b) {
  unsigned different = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < a.size(); ++i)
    different |= static_cast<unsigned>(a[i] ^ b[b.empty() ? 0 : i % b.size()]);
  return different == 0 && !b.empty();
}

std::string random_token() {
  std::random_device entropy;
  std::string token;
  for (int i = 0; i < 4; ++i) token += fmt::format("{:08x}", entropy());
  return token;
}

}  // namespace

Access Access::made(std::vector<std::string> hosts) {
  Access a;
  a.hosts_ = std::move(hosts);
  a.page_token_ = random_token();
  a.tokens_ = {{Right::fire, a.page_token_}, {Right::read, ""}};
  return a;
}

Access Access::from_file(const std::string& file, std::vector<std::string> hosts) {
  Access a;
  a.hosts_ = std::move(hosts);
  std::ifstream in(file);
  if (!in) throw BadInput({file + ": cannot be read"});
  std::vector<std::string> errors;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    std::istringstream words(line.substr(0, line.find('#')));
    std::string right, token, more;
    words >> right >> token >> more;
    if (right.empty()) continue;
    const bool printable = std::all_of(token.begin(), token.end(), [](char c) { return c > ' ' && c < 127; });
    if ((right != "fire" && right != "read") || !more.empty())
      errors.push_back(fmt::format("{}:{}: a line is 'fire TOKEN' or 'read TOKEN'", file, number));
    else if (token.size() < shortest_token || token.size() > longest_token || !printable)
      errors.push_back(fmt::format("{}:{}: a token has {} to {} printable characters", file, number,
                                   shortest_token, longest_token));
    else
      a.tokens_.push_back({right == "fire" ? Right::fire : Right::read, token});
  }
  if (errors.empty() && a.tokens_.empty()) errors.push_back(file + ": holds no token");
  if (!errors.empty()) throw BadInput(errors);
  a.link_token_ = random_token();
  return a;
}

std::string Access::foreign(const Request& r) const {
  if (std::find(hosts_.begin(), hosts_.end(), r.host) == hosts_.end())
    return "the host '" + r.host.substr(0, 80) + "' is not this bench; open " + hosts_.front();
  if (!r.origin.empty() && r.origin != "http://" + r.host)
    return "the request comes from another page, " + r.origin.substr(0, 80);
  return {};
}

Right Access::right(const Request& r) const {
  const bool by_link = equal(r.link_token, link_token_) || right_of(r.link_token) != Right::none;
  return std::max(right_of(r.token), by_link ? Right::read : Right::none);
}

Right Access::right_of(const std::string& token) const {
  Right best = Right::none;
  for (const Token& t : tokens_)
    if (t.text.empty() || equal(token, t.text)) best = std::max(best, t.right);
  return best;
}

}  // namespace powbench::host
