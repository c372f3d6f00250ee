#pragma once

#include <chrono>
#include <string>

namespace powbench::host {

/// One HTTP request, whatever brought it.
struct Request {
  std::string method;
  std::string path;   ///< without query
  std::string query;  ///< behind the question mark
  std::string body;
  std::string host, origin, content_type;  ///< header fields, empty where absent
  std::string token;                       ///< of `Authorization: Bearer`
  std::string link_token;                  ///< `token` of the query: it can do no more than read
  std::chrono::steady_clock::time_point received =
      std::chrono::steady_clock::now();  ///< a STOP that came later holds for this request too
};

/// The value of `name` in a query, as it stands there; "" = absent.
std::string of_query(const std::string& query, const std::string& name);

struct Reply {
  int status = 200;
  std::string type = "application/json";
  std::string body;
  std::string file;    ///< name under which a browser saves the body; "" = it shows it
  std::string policy;  ///< Content-Security-Policy; "" = that of the page
};

}  // namespace powbench::host
