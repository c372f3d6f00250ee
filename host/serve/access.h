#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/serve/message.h"

namespace powbench::host {

/// What a request may do, in rising order.
enum class Right : std::uint8_t { none, read, fire };

/// Who may do what. A browser sends a foreign page's requests here too: Host must be one of ours (a foreign name that
/// was made to point here is refused), Origin, where there is one, must be that host, and whatever changes something
/// is JSON, which no foreign page can send. Reading is free without a token file; firing always wants the token.
class Access {
 public:
  struct Token {
    Right right;
    std::string text;
  };

  /// On loopback without a file: one token to fire, made at each start, that our own page brings along.
  static Access made(std::vector<std::string> hosts);
  /// Each line `fire TOKEN` or `read TOKEN`, 16 .. 128 printable characters; # begins a comment. Throws BadInput.
  static Access from_file(const std::string& file, std::vector<std::string> hosts);

  /// A sentence where the request comes from elsewhere; empty: it does not.
  std::string foreign(const Request&) const;
  /// By the header what its token may do; by the address reading at most, for an address is kept in histories and
  /// passed on.
  Right right(const Request&) const;
  /// A token for addresses: it may read, until the program ends. Empty: reading wants none.
  const std::string& link_token() const { return link_token_; }
  /// For our own page; empty where tokens come from a file.
  const std::string& page_token() const { return page_token_; }

 private:
  std::vector<std::string> hosts_;  ///< as in the Host field: "127.0.0.1:8080"
  std::vector<Token> tokens_;
  Right right_of(const std::string& token) const;
  std::string page_token_, link_token_;
};

}  // namespace powbench::host
