#pragma once

#include "firmware/iiod/model.h"

namespace powbench::firmware::iiod {

/// Receives characters one at a time, so that the document needs no buffer: once to count, once to send.
class CharSink {
 public:
  virtual void put(char c) = 0;
  void put(std::string_view s) {
    for (const char c : s) put(c);
  }

 protected:
  ~CharSink() = default;
};

/// Writes the context description (libiio 0.x XML with its DTD; scan channels in index order, others behind).
void write_xml(const Context&, CharSink&);

}  // namespace powbench::firmware::iiod
