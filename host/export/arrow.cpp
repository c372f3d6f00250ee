#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "host/export/event_table.h"

namespace powbench::host {
namespace {

static_assert(std::endian::native == std::endian::little, "Arrow buffers are written as they lie in memory");

/// A FlatBuffer, built from its end to its front as the format wants it: an offset points towards the end. A position
/// is the distance from the end.
class Flat {
 public:
  using At = std::uint32_t;

  At text(const std::string& s) {
    align(4, s.size() + 1);
    prepend(std::string(1, '\0'));
    prepend(s);
    return put(static_cast<std::uint32_t>(s.size()));
  }

  At offsets(const std::vector<At>& list) {
    align(4, 4 * list.size());
    for (std::size_t i = list.size(); i-- > 0;) put(static_cast<std::uint32_t>(at() + 4 - list[i]));
    return put(static_cast<std::uint32_t>(list.size()));
  }

  /// Structs of 8-byte alignment, as their bytes.
  At structs(const std::string& bytes, std::size_t count) {
    align(8, bytes.size());
    prepend(bytes);
    return put(static_cast<std::uint32_t>(count));
  }

  struct Field {
    std::size_t slot;
    std::string bytes;  ///< of a number
    At to = 0;          ///< of an offset
    std::size_t size() const { return bytes.empty() ? 4 : bytes.size(); }
  };
  template <class T>
  static Field number(std::size_t slot, T value) {
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    return {slot, bytes, 0};
  }
  static Field offset(std::size_t slot, At to) { return {slot, "", to}; }

  /// A table: fields in any order, each slot once.
  At table(const std::vector<Field>& fields) {
    std::size_t slots = 0;
    for (const Field& f : fields) slots = std::max(slots, f.slot + 1);
    std::vector<At> where(slots, 0);
    const At end = at();
    for (const std::size_t size : {1U, 2U, 4U, 8U})  // the large ones come in front
      for (const Field& f : fields) {
        if (f.size() != size) continue;
        align(size, 0);
        if (f.bytes.empty())
          put(static_cast<std::uint32_t>(at() + 4 - f.to));
        else
          prepend(f.bytes);
        where[f.slot] = at();
      }
    align(4, 0);
    prepend(std::string(4, '\0'));  // to the list of fields, known below
    const At self = at();
    align(2, 0);
    for (std::size_t i = slots; i-- > 0;)
      put(static_cast<std::uint16_t>(where[i] == 0 ? 0 : self - where[i]));
    put(static_cast<std::uint16_t>(self - end));
    put(static_cast<std::uint16_t>(4 + 2 * slots));
    const auto back = static_cast<std::int32_t>(at() - self);
    std::memcpy(&reversed_[reversed_.size() - self], &back, 4);
    return self;
  }

  std::string finish(At root) {
    align(8, 4);
    put(static_cast<std::uint32_t>(at() + 4 - root));
    return reversed_;
  }

 private:
  At at() const { return static_cast<At>(reversed_.size()); }
  void prepend(const std::string& bytes) { reversed_.insert(0, bytes); }
  /// So that what follows, `more` bytes and then something of this alignment, ends at a multiple of it.
  void align(std::size_t to, std::size_t more) {
    while ((reversed_.size() + more) % to != 0) reversed_.insert(reversed_.begin(), '\0');
  }
  template <class T>
  At put(T value) {
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    prepend(bytes);
    return at();
  }
  std::string reversed_;
};

enum Slot : std::size_t { s0, s1, s2, s3, s4, s5 };
constexpr std::uint8_t type_int = 2, type_float = 3, type_utf8 = 5;
constexpr std::uint8_t header_schema = 1, header_batch = 3;
constexpr std::int16_t version_5 = 4;

Flat::At field(Flat& f, const TableColumn& c) {
  const Flat::At name = f.text(c.name), children = f.offsets({});
  std::uint8_t kind = type_utf8;
  Flat::At type = 0;
  if (std::holds_alternative<std::vector<std::int64_t>>(c.values)) {
    kind = type_int;
    type = f.table({Flat::number(s0, std::int32_t{64}), Flat::number(s1, std::uint8_t{1})});
  } else if (std::holds_alternative<std::vector<double>>(c.values)) {
    kind = type_float;
    type = f.table({Flat::number(s0, std::int16_t{2})});
  } else {
    type = f.table({});
  }
  return f.table({Flat::offset(s0, name), Flat::number(s1, std::uint8_t{1}), Flat::number(s2, kind),
                  Flat::offset(s3, type), Flat::offset(s5, children)});
}

using About = std::vector<std::pair<std::string, std::string>>;

Flat::At schema(Flat& f, const Table& table, const About& about) {
  std::vector<Flat::At> fields, pairs;
  for (const TableColumn& c : table) fields.push_back(field(f, c));
  for (const auto& [key, value] : about) {
    const Flat::At k = f.text(key), v = f.text(value);
    pairs.push_back(f.table({Flat::offset(s0, k), Flat::offset(s1, v)}));
  }
  const Flat::At list = f.offsets(fields), metadata = f.offsets(pairs);
  return f.table({Flat::number(s0, std::int16_t{0}), Flat::offset(s1, list), Flat::offset(s2, metadata)});
}

std::string message(Flat& f, std::uint8_t kind, Flat::At header, std::int64_t body) {
  return f.finish(f.table({Flat::number(s0, version_5), Flat::number(s1, kind), Flat::offset(s2, header),
                           Flat::number(s3, body)}));
}

void pad(std::string& s) {
  s.resize((s.size() + 7) / 8 * 8, '\0');
}

/// Body of the batch, with the place of every buffer.
struct Body {
  std::string bytes, nodes, buffers;

  template <class T>
  static void add(std::string& to, T value) {
    to.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void buffer(const std::string& content) {
    add(buffers, static_cast<std::int64_t>(bytes.size()));
    add(buffers, static_cast<std::int64_t>(content.size()));
    bytes += content;
    pad(bytes);
  }
  void node(std::size_t length, std::size_t nulls) {
    add(nodes, static_cast<std::int64_t>(length));
    add(nodes, static_cast<std::int64_t>(nulls));
  }

  void column(const std::vector<std::int64_t>& v) {
    node(v.size(), 0);
    buffer("");
    buffer(std::string(reinterpret_cast<const char*>(v.data()), 8 * v.size()));
  }
  void column(const std::vector<double>& v) {
    std::string known((v.size() + 7) / 8, '\0');
    std::size_t nulls = 0;
    for (std::size_t i = 0; i < v.size(); ++i)
      if (std::isnan(v[i]))
        ++nulls;
      else
        known[i / 8] = static_cast<char>(known[i / 8] | 1 << (i % 8));
    node(v.size(), nulls);
    buffer(nulls == 0 ? "" : known);
    buffer(std::string(reinterpret_cast<const char*>(v.data()), 8 * v.size()));
  }
  void column(const std::vector<std::string>& v) {
    node(v.size(), 0);
    buffer("");
    std::string ends, text;
    add(ends, std::int32_t{0});
    for (const std::string& s : v) {
      text += s;
      add(ends, static_cast<std::int32_t>(text.size()));
    }
    buffer(ends);
    buffer(text);
  }
};

/// Marker, length, metadata padded to 8.
std::string framed(std::string metadata) {
  pad(metadata);
  std::string out;
  Body::add(out, std::uint32_t{0xFFFFFFFFU});
  Body::add(out, static_cast<std::int32_t>(metadata.size()));
  return out + metadata;
}

}  // namespace

std::string to_arrow(const Table& table, const About& about) {
  std::string out("ARROW1\0\0", 8);
  Flat head;
  out += framed(message(head, header_schema, schema(head, table, about), 0));

  Body body;
  for (const TableColumn& c : table) std::visit([&](const auto& v) { body.column(v); }, c.values);
  Flat batch;
  const Flat::At buffers = batch.structs(body.buffers, body.buffers.size() / 16);
  const Flat::At nodes = batch.structs(body.nodes, body.nodes.size() / 16);
  const Flat::At header = batch.table({Flat::number(s0, static_cast<std::int64_t>(rows(table))),
                                       Flat::offset(s1, nodes), Flat::offset(s2, buffers)});
  const std::string framed_batch =
      framed(message(batch, header_batch, header, static_cast<std::int64_t>(body.bytes.size())));
  const std::size_t place = out.size();
  out += framed_batch + body.bytes;
  Body::add(out, std::uint32_t{0xFFFFFFFFU});
  Body::add(out, std::int32_t{0});

  Flat foot;
  std::string block;
  Body::add(block, static_cast<std::int64_t>(place));
  Body::add(block, static_cast<std::int64_t>(framed_batch.size()));  // 32 bits and as many of padding
  Body::add(block, static_cast<std::int64_t>(body.bytes.size()));
  const Flat::At blocks = foot.structs(block, 1), none = foot.structs("", 0);
  const Flat::At repeated = schema(foot, table, about);
  const std::string footer = foot.finish(foot.table({Flat::number(s0, version_5), Flat::offset(s1, repeated),
                                                     Flat::offset(s2, none), Flat::offset(s3, blocks)}));
  out += footer;
  Body::add(out, static_cast<std::int32_t>(footer.size()));
  return out + "ARROW1";
}

}  // namespace powbench::host
