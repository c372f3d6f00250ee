#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "host/serve/access.h"
#include "host/serve/bench.h"
#include "host/serve/documents.h"
#include "host/serve/message.h"

/// The calls of the live bench as tables: calls_bench.cpp (rig and job), calls_files.cpp (plan, specimen and rig
/// file), calls_documents.cpp (what the store holds). api.cpp finds the row, checks the right and parses the body.

namespace powbench::host {

/// The request was understood and cannot be met.
struct Problem {
  int status;
  std::string text;
};

struct Body;  ///< a JSON object

struct Call {
  Bench& bench;
  CampaignFacts& facts;
  const Access& access;
  const std::string& plan_file;  ///< that the bench was started with; "" = none
  const Request& request;
  std::int64_t id;   ///< of the path
  const Body& body;  ///< of a POST
};

struct Route {
  const char* method;
  const char* path;  ///< {id} stands for a number
  Right right;
  const char* meaning;
  const char* body;   ///< example of the body of a POST, "" = none
  const char* reply;  ///< fields of the reply, or its media type
  Reply (*act)(const Call&);
  const char* query[2] = {nullptr, nullptr};  ///< whole numbers in the address; `after` may be left out
  const char* other_key = nullptr;            ///< a number in the place of the body's first key
  bool stream = false;                        ///< a WebSocket: `reply` is each of its messages
};

std::span<const Route> bench_calls();
std::span<const Route> file_calls();
std::span<const Route> document_calls();

Reply json_reply(std::string json, int status = 200);

// of a body; each throws Problem with a sentence
/// A finite number within `low` .. `high`.
double number_of(const Body&, const char* key, double low, double high);
bool has(const Body&, const char* key);
bool flag_of(const Body&, const char* key);
std::string text_of(const Body&, const char* key, std::size_t longest);

/// A number of the query; 0 where it is absent.
std::int64_t number_of_query(const Call&, const char* key);

/// The plan of the body on the bench's own specimen: a plan from elsewhere names no file here. Throws BadInput.
Scene scene_of_body(const Call&);

}  // namespace powbench::host
