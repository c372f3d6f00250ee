#include "firmware/iiod/responder.h"

#include "firmware/iiod/words.h"
#include "firmware/iiod/xml.h"

namespace powbench::firmware::iiod {
namespace {

void put_text(ByteSink& out, std::string_view s) {
  out.put({reinterpret_cast<const std::uint8_t*>(s.data()), s.size()});
}

void put_number(ByteSink& out, std::int64_t value) {
  // not a Text: this stands on the stack beside one
  char digits[24];
  std::size_t at = sizeof digits;
  std::uint64_t rest = value < 0 ? 0 - static_cast<std::uint64_t>(value) : static_cast<std::uint64_t>(value);
  digits[--at] = '\n';
  do digits[--at] = static_cast<char>('0' + rest % 10);
  while ((rest /= 10) != 0);
  if (value < 0) digits[--at] = '-';
  put_text(out, {digits + at, sizeof digits - at});
}

void put_big_endian(ByteSink& out, std::int32_t value) {
  const auto v = static_cast<std::uint32_t>(value);
  const std::uint8_t bytes[4] = {static_cast<std::uint8_t>(v >> 24), static_cast<std::uint8_t>(v >> 16),
                                 static_cast<std::uint8_t>(v >> 8), static_cast<std::uint8_t>(v)};
  out.put(bytes);
}

constexpr std::size_t padded(std::size_t n) {
  return (n + 3) / 4 * 4;
}

const Attribute* find(std::span<const Attribute> attributes, std::string_view name) {
  for (const Attribute& a : attributes)
    if (a.name == name) return &a;
  return nullptr;
}

/// Attribute functions, called with the controller kept still.
int read_attribute(const Context& context, const Device& device, const Attribute& attribute, Text& out) {
  if (context.lock) context.lock(true);
  const int error = attribute.read(device.self, attribute.argument, out);
  if (context.lock) context.lock(false);
  return error;
}

int write_attribute(const Context& context, const Device& device, const Attribute& attribute,
                    std::string_view value) {
  if (context.lock) context.lock(true);
  const int error = attribute.write(device.self, attribute.argument, trim(value));
  if (context.lock) context.lock(false);
  return error;
}

}  // namespace

std::size_t Responder::feed(Connection& c, std::span<const std::uint8_t> bytes, ByteSink& out) {
  std::size_t used = 0;
  while (used < bytes.size() && c.status_ == Connection::Status::ready) {
    const char byte = static_cast<char>(bytes[used++]);
    // payload of a WRITE
    if (c.write_.remaining > 0) {
      if (c.write_.length < Connection::payload_capacity) c.payload_[c.write_.length++] = byte;
      if (--c.write_.remaining == 0) finish_write(c, out);
      continue;
    }
    // command line
    if (byte != '\n') {
      if (c.line_length_ < Connection::line_capacity)
        c.line_[c.line_length_++] = byte;
      else
        c.line_overflow_ = true;
      continue;
    }
    const std::string_view line{c.line_.data(), c.line_length_};
    const bool overflow = c.line_overflow_;
    c.line_length_ = 0;
    c.line_overflow_ = false;
    if (overflow)
      put_number(out, -einval);
    else
      run_line(c, line, out);
  }
  return used;
}

void Responder::run_line(Connection& c, std::string_view line, ByteSink& out) {
  const Words words(line);
  if (words.count == 0) return;
  const std::string_view verb = words[0];
  if (words.too_many) return put_number(out, -einval);
  if (same_word(verb, "PRINT")) return print(out);
  if (same_word(verb, "READ")) return read(words, out);
  if (same_word(verb, "WRITE")) return begin_write(c, words, out);
  if (same_word(verb, "READBUF")) return begin_readbuf(c, words, out);
  if (same_word(verb, "GETTRIG") || same_word(verb, "SETTRIG")) return trigger(words, out);
  if (same_word(verb, "OPEN")) return put_number(out, open(c, words));
  if (same_word(verb, "CLOSE")) {
    const bool was_open = c.reader_.device != nullptr && c.reader_.device == find_device(words[1]);
    c.reader_ = {};
    return put_number(out, was_open ? 0 : -ebadf);
  }
  if (same_word(verb, "TIMEOUT")) {
    const auto ms = parse_int(words[1]);
    if (!ms || *ms < 0 || *ms > 3'600'000) return put_number(out, -einval);
    c.timeout_ms_ = static_cast<std::int32_t>(*ms);
    return put_number(out, 0);
  }
  if (same_word(verb, "VERSION")) return put_text(out, "0.24.v0.24  \n");
  if (same_word(verb, "SET")) {
    const bool valid =
        find_device(words[1]) && same_word(words[2], "BUFFERS_COUNT") && parse_int(words[3]).value_or(0) > 0;
    return put_number(out, valid ? 0 : -einval);
  }
  if (same_word(verb, "EXIT") || same_word(verb, "QUIT")) {
    c.status_ = Connection::Status::closed;
    return;
  }
  put_number(out, -einval);
}

void Responder::print(ByteSink& out) const {
  struct Counter final : CharSink {
    using CharSink::put;
    std::int64_t count = 0;
    void put(char) override { ++count; }
  } counter;
  struct Sender final : CharSink {
    explicit Sender(ByteSink& sink) : out(sink) {}
    using CharSink::put;
    void put(char c) override {
      buffer[size++] = static_cast<std::uint8_t>(c);
      if (size == sizeof buffer) flush();
    }
    void flush() { out.put({buffer, size}), size = 0; }
    ByteSink& out;
    std::uint8_t buffer[64]{};
    std::size_t size = 0;
  } sender(out);
  write_xml(context_, counter);
  put_number(out, counter.count);
  write_xml(context_, sender);
  sender.put('\n');
  sender.flush();
}

const Device* Responder::find_device(std::string_view id) const {
  for (const Device* d : context_.devices)
    if (d->id == id || d->name == id) return d;
  return nullptr;
}

/// The attribute table that a READ or WRITE addresses: words[2] may be INPUT, OUTPUT, BUFFER or DEBUG. `next`
/// becomes the index of the word behind it.
std::span<const Attribute> Responder::find_attributes(const Device& device, const Words& words,
                                                      std::size_t& next) const {
  const std::string_view kind = words[2];
  next = 3;
  if (same_word(kind, "BUFFER")) return device.buffer_attributes;
  if (same_word(kind, "DEBUG")) return {};
  if (same_word(kind, "INPUT") || same_word(kind, "OUTPUT")) {
    next = 4;
    for (const Channel& channel : device.channels)
      if (channel.id == words[3] && channel.output == same_word(kind, "OUTPUT")) return channel.attributes;
    return {};
  }
  next = 2;
  return device.attributes;
}

void Responder::read(const Words& words, ByteSink& out) {
  const Device* device = find_device(words[1]);
  if (!device) return put_number(out, -enodev);
  std::size_t next = 2;
  const auto attributes = find_attributes(*device, words, next);
  if (words.count <= next) return read_all(*device, attributes, out);
  const Attribute* attribute = find(attributes, words[next]);
  if (!attribute) return put_number(out, -enoent);
  LongText& value = value_;
  value.clear();
  const int error = read_attribute(context_, *device, *attribute, value);
  if (error < 0) return put_number(out, error);
  value.put('\0');
  put_number(out, static_cast<std::int64_t>(value.view().size()));
  put_text(out, value.view());
  put_text(out, "\n");
}

void Responder::read_all(const Device& device, std::span<const Attribute> attributes, ByteSink& out) {
  // twice over the table: the length comes first on the wire and there is no buffer for the whole answer
  for (const bool sending : {false, true}) {
    std::size_t total = 0;
    for (const Attribute& a : attributes) {
      LongText& value = value_;
      value.clear();
      const int error = read_attribute(context_, device, a, value);
      if (error >= 0) value.put('\0');
      const std::size_t size = error < 0 ? 0 : value.view().size();
      total += 4 + padded(size);
      if (!sending) continue;
      put_big_endian(out, error < 0 ? error : static_cast<std::int32_t>(size));
      if (error >= 0) put_text(out, value.view());
      for (std::size_t i = size; i < padded(size); ++i) put_text(out, std::string_view("\0", 1));
    }
    if (!sending) put_number(out, static_cast<std::int64_t>(total));
  }
  put_text(out, "\n");
}

void Responder::begin_write(Connection& c, const Words& words, ByteSink& out) {
  c.write_ = {};
  const auto length = payload_length(words);
  if (!length) return put_number(out, -einval);
  c.write_.device = find_device(words[1]);
  if (!c.write_.device) {
    c.write_.error = -enodev;
  } else {
    std::size_t next = 2;
    const bool whole_table = words.count == 3;
    const auto attributes =
        whole_table ? c.write_.device->attributes : find_attributes(*c.write_.device, words, next);
    c.write_.attribute = whole_table || next + 1 >= words.count ? nullptr : find(attributes, words[next]);
    if (!whole_table && !c.write_.attribute) c.write_.error = -enoent;
    if (c.write_.attribute && !c.write_.attribute->write) c.write_.error = -eperm;
  }
  if (*length > static_cast<std::int64_t>(Connection::payload_capacity) && c.write_.error == 0)
    c.write_.error = -e2big;
  c.write_.remaining = static_cast<std::uint64_t>(*length);
  // a refused write still has its payload on the way: swallow it, then answer
  if (c.write_.remaining == 0) finish_write(c, out);
}

void Responder::finish_write(Connection& c, ByteSink& out) {
  const Connection::Write w = c.write_;
  c.write_ = {};
  const std::string_view payload{c.payload_.data(), w.length};
  int result = w.error;
  if (result == 0)
    result = w.attribute ? write_attribute(context_, *w.device, *w.attribute, payload)
                         : write_all(*w.device, w.device->attributes, payload);
  put_number(out, result < 0 ? result : static_cast<std::int64_t>(payload.size()));
}

int Responder::write_all(const Device& device, std::span<const Attribute> attributes,
                         std::string_view packed) {
  for (const Attribute& a : attributes) {
    if (packed.size() < 4) return -einval;
    std::uint32_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length = length << 8 | static_cast<std::uint8_t>(packed[i]);
    packed.remove_prefix(4);
    if (static_cast<std::int32_t>(length) <= 0) continue;
    if (packed.size() < length) return -einval;
    if (!a.write) return -eperm;
    const int error = write_attribute(context_, device, a, {packed.data(), length});
    if (error < 0) return error;
    packed.remove_prefix(padded(length) < packed.size() ? padded(length) : packed.size());
  }
  return 0;
}

int Responder::open(Connection& c, const Words& words) {
  const Device* device = find_device(words[1]);
  if (!device) return -enodev;
  if (!device->buffer) return -einval;
  if (words.count > 4) return -einval;  // CYCLIC: there is one record, and it does not repeat
  if (c.reader_.device) return -ebusy;
  const auto scans = parse_int(words[2]);
  std::uint32_t mask = 0;
  if (!scans || *scans <= 0 || !parse_mask(words[3], mask) || mask == 0) return -einval;
  std::uint32_t known = 0;
  for (const Channel& channel : device->channels)
    if (channel.scan_index >= 0) known |= 1U << channel.scan_index;
  if ((mask & ~known) != 0) return -einval;
  c.reader_ = {.device = device, .mask = mask, .generation = device->buffer->generation()};
  return 0;
}

void Responder::begin_readbuf(Connection& c, const Words& words, ByteSink& out) {
  const auto bytes = parse_int(words[2]);
  if (!c.reader_.device || c.reader_.device != find_device(words[1])) return put_number(out, -ebadf);
  if (!bytes || *bytes <= 0 || *bytes > 1'000'000'000) return put_number(out, -einval);
  const std::size_t step = c.reader_.device->buffer->scan_bytes(c.reader_.mask);
  c.reader_.wanted = static_cast<std::uint64_t>(*bytes) / step * step;
  c.reader_.mask_sent = false;
  if (c.reader_.wanted == 0) return put_number(out, -einval);
  c.status_ = Connection::Status::pending;
  resume(c, out);
}

void Responder::resume(Connection& c, ByteSink& out) {
  if (c.status_ != Connection::Status::pending) return;
  Connection::Reader& r = c.reader_;
  const BufferSource& source = *r.device->buffer;
  if (r.generation != source.generation()) {
    // a reader that waits at the start follows to the new record; one inside an old record must reopen
    if (r.cursor != 0) return expire(c, ebadf, out);
    r.generation = source.generation();
  }
  const std::size_t step = source.scan_bytes(r.mask);
  const std::size_t ready = source.available(r.cursor);
  const std::size_t scans = ready < r.wanted / step ? ready : static_cast<std::size_t>(r.wanted / step);
  if (scans > 0) {
    // one chunk: never larger than what is still owed, and never promised before it is in memory
    put_number(out, static_cast<std::int64_t>(scans * step));
    if (!r.mask_sent) {
      TextOf<16> mask;
      mask.put_hex32(r.mask).put('\n');
      put_text(out, mask.view());
      r.mask_sent = true;
    }
    std::uint8_t slice[512];
    const std::size_t per_slice = sizeof slice / step;
    for (std::size_t done = 0; done < scans;) {
      const auto piece = source.in_place(r.cursor, scans - done, r.mask);
      std::size_t n = piece.size() / step;
      if (n > 0) {
        out.put(piece);
      } else {
        n = scans - done < per_slice ? scans - done : per_slice;
        source.copy(r.cursor, n, r.mask, slice);
        out.put({slice, n * step});
      }
      r.cursor += n;
      done += n;
    }
    r.wanted -= scans * step;
  }
  if (r.wanted == 0) {
    c.status_ = Connection::Status::ready;
  } else if (r.mask_sent && source.finished(r.cursor)) {
    put_number(out, 0);  // stop short: the record ends here
    r.wanted = 0;
    c.status_ = Connection::Status::ready;
  }
}

void Responder::expire(Connection& c, Errno error, ByteSink& out) {
  if (c.status_ != Connection::Status::pending) return;
  // who polls must be able to tell the end of the record from samples that are still to come
  const bool ended = error == eagain && c.reader_.device->buffer->finished(c.reader_.cursor);
  put_number(out, ended ? 0 : -static_cast<std::int64_t>(error));
  c.reader_.wanted = 0;
  c.status_ = Connection::Status::ready;
}

void Responder::trigger(const Words& words, ByteSink& out) {
  const Device* device = find_device(words[1]);
  if (!device) return put_number(out, -enodev);
  if (!device->has_trigger) return put_number(out, -enoent);  // the tools' word for "has no trigger"
  if (same_word(words[0], "GETTRIG")) {
    if (!trigger_) return put_number(out, 0);  // no trigger: a bare 0, without a body
    put_number(out, static_cast<std::int64_t>(trigger_->name.size()));
    put_text(out, trigger_->name);
    return put_text(out, "\n");
  }
  const Device* wanted = words.count > 2 ? find_device(words[2]) : nullptr;
  if (words.count > 2 && (!wanted || !wanted->is_trigger())) return put_number(out, -enodev);
  trigger_ = wanted;
  put_number(out, 0);
}

}  // namespace powbench::firmware::iiod
