#include "host/store/points.h"

#include <mutex>

#include "core/version.h"
#include "host/store/open.h"
#include "host/store/point_rows.h"
#include "host/store/rows.h"
#include "host/store/seal.h"

namespace powbench::host {

namespace {

std::string bytes_of(const sqlite::Statement& s, int column) {
  const auto blob = s.blob(column);
  return std::string(blob.begin(), blob.end());
}

/// Columns id, study, seal, content.
PointRow point_row(const sqlite::Statement& s) {
  PointRow p{s.text(0), s.text(1), bytes_of(s, 3)};
  check_seal(point_hash(p), s.text(2), "point " + p.id.substr(0, 12) + " of " + p.study);
  return p;
}

}  // namespace

std::string point_hash(const PointRow& p) {
  return Seal().add(p.id).add(p.study).add(p.content).hex();
}

std::optional<PointRow> select_point(const sqlite::Database& db, const std::string& id) {
  sqlite::Statement s(db, "SELECT id, study, seal, content FROM point WHERE id = ?");
  if (!s.bind(std::string_view(id)).step()) return std::nullopt;
  return point_row(s);
}

void each_point(const sqlite::Database& db, const std::function<void(const PointRow&)>& see) {
  sqlite::Statement s(db, "SELECT id, study, seal, content FROM point ORDER BY id");
  while (s.step()) see(point_row(s));
}

void insert_point(sqlite::Database& db, const PointRow& p) {
  sqlite::Statement(db, "INSERT OR IGNORE INTO point (id, study, seal, content) VALUES (?, ?, ?, ?)")
      .bind(std::string_view(p.id))
      .bind(std::string_view(p.study))
      .bind(std::string_view(point_hash(p)))
      .bind_blob({reinterpret_cast<const std::uint8_t*>(p.content.data()), p.content.size()})
      .run();
}

struct Points::Impl {
  sqlite::Database db;
  std::string study, program;
  std::mutex mutex;
};

Points::Points() = default;
Points::~Points() = default;

Points::Points(const std::string& path, std::string study, Shard shard, std::string program)
    : impl_(new Impl{open_store(path, Store::Mode::read_write),
                     std::move(study),
                     program.empty() ? std::string(program_version) : std::move(program),
                     {}}),
      shard_(shard) {}

std::optional<std::string> Points::get(std::int64_t number, const std::string& basis,
                                       const std::function<std::string()>& compute) {
  if (!shard_.has(number)) return std::nullopt;
  if (!impl_) return compute();
  const std::string id = Seal().add(impl_->study).add(impl_->program).add(basis).hex();
  {
    const std::scoped_lock lock(impl_->mutex);
    if (auto there = select_point(impl_->db, id)) {
      ++found_;
      return std::move(there->content);
    }
  }
  PointRow made{id, impl_->study, compute()};
  const std::scoped_lock lock(impl_->mutex);
  insert_point(impl_->db, made);
  ++computed_;
  return std::move(made.content);
}

}  // namespace powbench::host
