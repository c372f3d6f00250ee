#pragma once

#include <string>

namespace powbench::host {

/// One HTTP request, whatever brought it.
struct Request {
  std::string method;
  std::string path;  ///< without query
  std::string body;
  std::string host, origin, content_type;  ///< header fields, empty where absent
  std::string token;                       ///< of `Authorization: Bearer`
};

struct Reply {
  int status = 200;
  std::string type = "application/json";
  std::string body;
  std::string policy;  ///< Content-Security-Policy; "" = that of the page
};

}  // namespace powbench::host
