#include "host/report/markup.h"

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "host/export/xml_text.h"

namespace powbench::host {

void Markup::start(std::string_view tag, Attributes attributes) {
  out_ += '<';
  out_ += tag;
  for (const auto& [key, value] : attributes) {
    out_ += ' ';
    out_ += key;
    out_ += "=\"";
    out_ += escaped(value);
    out_ += '"';
  }
}

Markup& Markup::open(std::string_view tag, Attributes attributes) {
  start(tag, attributes);
  out_ += '>';
  open_.emplace_back(tag);
  return *this;
}

Markup& Markup::close() {
  assert(!open_.empty());
  out_ += "</" + open_.back() + ">";
  // a line break after the larger elements keeps the file readable
  if (open_.back() != "span" && open_.back() != "td" && open_.back() != "th" && open_.back() != "text")
    out_ += '\n';
  open_.pop_back();
  return *this;
}

Markup& Markup::text(std::string_view content) {
  out_ += escaped(content);
  return *this;
}

Markup& Markup::element(std::string_view tag, std::string_view content, Attributes attributes) {
  return open(tag, attributes).text(content).close();
}

Markup& Markup::empty(std::string_view tag, Attributes attributes) {
  start(tag, attributes);
  out_ += "/>";
  return *this;
}

Markup& Markup::verbatim(std::string_view tag, std::string_view content, Attributes attributes) {
  if (content.find_first_of("<&") != std::string_view::npos)
    throw std::invalid_argument("verbatim content must hold neither < nor &");
  open(tag, attributes);
  out_ += content;
  return close();
}

Markup& Markup::embed(const Markup& other) {
  out_ += other.str();
  return *this;
}

const std::string& Markup::str() const {
  assert(open_.empty());
  return out_;
}

}  // namespace powbench::host
