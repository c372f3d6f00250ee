#include "host/store/central/points.h"

#include <algorithm>
#include <map>

#include "host/store/store.h"

namespace powbench::host {

using postgres::Rows;
using postgres::Values;

namespace {

constexpr std::size_t points_together = 256;     // asked for, or sent in a transaction
constexpr std::size_t most_content = 8'000'000;  // of their contents

std::span<const std::uint8_t> bytes_of(const std::string& content) {
  return {reinterpret_cast<const std::uint8_t*>(content.data()), content.size()};
}

}  // namespace

std::vector<PointRow> PointPusher::lacking(std::vector<PointRow> points) const {
  std::string ids;
  for (const PointRow& p : points) ids += (ids.empty() ? "" : ",") + p.id;
  const Rows rows =
      to_.run("SELECT id, hash FROM point WHERE id = ANY (string_to_array($1, ','))", Values().text(ids));
  std::map<std::string, std::string> there;
  for (int i = 0; i < rows.size(); ++i) there[rows.text(i, 0)] = rows.text(i, 1);
  std::erase_if(points, [&](const PointRow& p) {
    const auto at = there.find(p.id);
    if (at == there.end()) return false;
    if (at->second != point_hash(p))
      throw WrongStore("point " + p.id.substr(0, 12) + " of " + p.study + " is not the same in " +
                       from_.path() + " and in " + to_.address() + ": " +
                       (began_ ? "the push has stopped there" : "nothing was pushed"));
    return true;
  });
  return points;
}

std::int64_t PointPusher::compare() {
  std::vector<PointRow> some;
  const auto look = [&] {
    for (PointRow& p : lacking(std::move(some))) ids_.push_back(std::move(p.id));
    some.clear();
  };
  each_point(from_, [&](const PointRow& p) {
    some.push_back(p);
    if (some.size() == points_together) look();
  });
  if (!some.empty()) look();
  return static_cast<std::int64_t>(ids_.size());
}

void PointPusher::send(const std::vector<PointRow>& points) {
  postgres::Transaction t(to_);
  for (const PointRow& p : points)
    to_.queue("INSERT INTO point VALUES ($1, $2, $3, $4) ON CONFLICT DO NOTHING",
              Values().text(p.id).text(p.study).text(point_hash(p)).bytes(bytes_of(p.content)));
  to_.finish();
  lacking(points);  // somebody may have been quicker, with another content
  t.commit();
}

void PointPusher::push(const std::function<void(std::int64_t bytes)>& sent) {
  began_ = true;
  std::vector<PointRow> some;
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (auto p = select_point(from_, ids_[i])) {
      bytes += p->content.size();
      some.push_back(std::move(*p));
    }
    if (some.size() < points_together && bytes < most_content && i + 1 < ids_.size()) continue;
    send(some);
    for (const PointRow& p : some) sent(static_cast<std::int64_t>(p.content.size()));
    some.clear();
    bytes = 0;
  }
}

std::int64_t pull_points(postgres::Connection& from, sqlite::Database& to) {
  std::int64_t points = 0;
  std::string after;
  for (;;) {
    const Rows rows =
        from.run("SELECT id, study, hash, content FROM point WHERE id > $1 ORDER BY id LIMIT 256",
                 Values().text(after));
    if (rows.size() == 0) return points;
    sqlite::Transaction t(to);
    for (int i = 0; i < rows.size(); ++i) {
      const auto content = rows.bytes(i, 3);
      const PointRow p{rows.text(i, 0), rows.text(i, 1), std::string(content.begin(), content.end())};
      if (point_hash(p) != rows.text(i, 2))
        throw StoreError(from.address() + ": point " + p.id.substr(0, 12) + " of " + p.study +
                         " does not match its hash: the database is damaged");
      insert_point(to, p);
      after = p.id;
      ++points;
    }
    t.commit();
  }
}

}  // namespace powbench::host
