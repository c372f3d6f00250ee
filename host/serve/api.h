#pragma once

#include <string>

#include "host/serve/access.h"
#include "host/serve/bench.h"
#include "host/serve/documents.h"
#include "host/serve/message.h"

namespace powbench::host {

/// Every HTTP call of the live bench; docs/how-to/serve.md lists them, `GET /api` describes them as OpenAPI. No text
/// of a client ever becomes the name of a file.
class Api {
 public:
  /// `plan_file`: that the bench was started with, "" = none; saving a plan writes there and nowhere else.
  Api(Bench& bench, Access access, std::string plan_file = {})
      : bench_(bench), access_(std::move(access)), plan_file_(std::move(plan_file)) {}

  /// Never throws: what goes wrong is a reply with {"error": sentence} or {"errors": [sentences]}. From any thread.
  Reply answer(const Request&) const;
  /// The request wants nothing but a stop, which must not wait behind others.
  static bool is_stop(const Request& r) { return r.method == "POST" && r.path == "/api/stop"; }
  /// Whether state may be sent over a WebSocket: a refusal, or status 200.
  Reply listen(const Request&) const;
  const Access& access() const { return access_; }

 private:
  Bench& bench_;
  Access access_;
  const std::string plan_file_;
  mutable CampaignFacts facts_;
};

/// OpenAPI 3.0 of all calls, from the table that answers them.
std::string openapi();

}  // namespace powbench::host
