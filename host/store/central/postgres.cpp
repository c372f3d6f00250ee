#include "host/store/central/postgres.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "host/store/central/central.h"
#include "host/store/central/migrations.h"
#include "host/store/central/pq.h"

namespace powbench::host::postgres {

namespace {

/// Types by the numbers that PostgreSQL gives them in its catalogue (pg_type.dat); they never change.
constexpr Oid flag_type = 16, bytes_type = 17, integer_type = 20, text_type = 25, real_type = 701;

std::string big_endian(std::uint64_t bits) {
  std::string bytes(8, '\0');
  for (std::size_t i = 0; i < 8; ++i) bytes[i] = static_cast<char>(bits >> (56 - 8 * i) & 0xFFU);
  return bytes;
}

std::uint64_t from_big_endian(std::span<const std::uint8_t> bytes) {
  std::uint64_t bits = 0;
  for (const std::uint8_t b : bytes) bits = bits << 8 | b;
  return bits;
}

PGresult* raw(const std::shared_ptr<void>& result) {
  return static_cast<PGresult*>(result.get());
}
PGconn* line(const std::shared_ptr<void>& connection) {
  return static_cast<PGconn*>(connection.get());
}
std::shared_ptr<void> owned(PGresult* result) {
  return {result, [](void* r) { pq().PQclear(static_cast<PGresult*>(r)); }};
}

/// A message of libpq or of the server in one line.
std::string sentence(const char* message) {
  std::string text = message != nullptr ? message : "";
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  std::string one;
  for (const char c : text) {
    if (c == '\n')
      one += "; ";
    else if (c != '\t')
      one += c;
  }
  return one;
}

/// What of a refused address may be shown: whatever may be a password is left out.
std::string harmless(const std::string& address) {
  if (address.find("assw") != std::string::npos) return "the address";
  const auto at = address.rfind('@');
  return at == std::string::npos ? address : "..." + address.substr(at);
}

/// Refuses what is no address, or has a password in it.
void check_address(const std::string& address) {
  const std::string form = "allowed postgresql://USER@HOST:PORT/DATABASE";
  if (!address.starts_with("postgresql://") && !address.starts_with("postgres://"))
    throw WrongStore(harmless(address) + ": not the address of a database; " + form);
  char* message = nullptr;
  PQconninfoOption* options = pq().PQconninfoParse(address.c_str(), &message);
  if (options == nullptr) {
    pq().PQfreemem(message);  // it may repeat a password
    throw WrongStore(harmless(address) + ": cannot be read as the address of a database; " + form);
  }
  bool secret = false;
  for (const PQconninfoOption* o = options; o->keyword != nullptr; ++o)
    secret = secret || (std::strstr(o->keyword, "password") != nullptr && o->val != nullptr);
  pq().PQconninfoFree(options);
  if (secret)
    throw WrongStore(harmless(address) +
                     ": a password in the address is seen by others on this machine; leave it out and set "
                     "PGPASSWORD, or write it to ~/.pgpass or a service file");
}

/// Keywords and values of a connection; an address that sets one of the first four itself wins.
struct Parameters {
  explicit Parameters(const std::string& address)
      : values{"10", "30", "10", "30000", "powbench", address.c_str(), "UTF8", nullptr} {
    if (std::getenv("PGCONNECT_TIMEOUT") != nullptr) values[0] = "";
  }
  std::array<const char*, 8> keys{
      "connect_timeout",           "keepalives_idle", "keepalives_interval", "tcp_user_timeout",
      "fallback_application_name", "dbname",          "client_encoding",     nullptr};
  std::array<const char*, 8> values;
};

}  // namespace

Values& Values::add(unsigned type, std::string content, bool null) {
  list_.push_back({type, null, std::move(content)});
  return *this;
}
Values& Values::integer(std::int64_t value) {
  return add(integer_type, big_endian(static_cast<std::uint64_t>(value)));
}
Values& Values::real(double value) {
  return add(real_type, big_endian(std::bit_cast<std::uint64_t>(value)), std::isnan(value));
}
Values& Values::text(std::string_view value) {
  return add(text_type, std::string(value));
}
Values& Values::bytes(std::span<const std::uint8_t> value) {
  return add(bytes_type, std::string(reinterpret_cast<const char*>(value.data()), value.size()));
}
Values& Values::flag(bool value) {
  return add(flag_type, std::string(1, value ? '\1' : '\0'));
}

int Rows::size() const {
  return pq().PQntuples(raw(result_));
}
std::span<const std::uint8_t> Rows::bytes(int row, int column) const {
  return {reinterpret_cast<const std::uint8_t*>(pq().PQgetvalue(raw(result_), row, column)),
          static_cast<std::size_t>(pq().PQgetlength(raw(result_), row, column))};
}
std::int64_t Rows::integer(int row, int column) const {
  const auto b = bytes(row, column);
  const auto bits = from_big_endian(b);
  return b.size() == 4 ? static_cast<std::int32_t>(bits) : static_cast<std::int64_t>(bits);
}
double Rows::real(int row, int column) const {
  if (pq().PQgetisnull(raw(result_), row, column) != 0) return std::numeric_limits<double>::quiet_NaN();
  return std::bit_cast<double>(from_big_endian(bytes(row, column)));
}
std::string Rows::text(int row, int column) const {
  const auto b = bytes(row, column);
  return std::string(reinterpret_cast<const char*>(b.data()), b.size());
}
bool Rows::flag(int row, int column) const {
  return from_big_endian(bytes(row, column)) != 0;
}

Connection::Connection(const std::string& address) : address_(address) {
  check_address(address);
  const Parameters p(address_);
  const auto connect = [&] {
    connection_ = {pq().PQconnectdbParams(p.keys.data(), p.values.data(), 1),
                   [](void* x) { pq().PQfinish(static_cast<PGconn*>(x)); }};
    return pq().PQstatus(line(connection_)) == CONNECTION_OK;
  };
  if (!connect()) {
    Parameters short_wait(address_);
    short_wait.values[0] = "3";
    const PGPing answer = pq().PQpingParams(short_wait.keys.data(), short_wait.values.data(), 1);
    // one that has just finished its start answers by now
    const bool refused = answer == PQPING_OK && !connect();
    const std::string why = sentence(pq().PQerrorMessage(line(connection_)));
    const bool full = why.find("too many") != std::string::npos || why.find("slots") != std::string::npos;
    if (answer == PQPING_REJECT || (refused && full))
      throw ServerError(address_ + ": the server takes no connections now: " + why);
    if (refused)
      throw WrongStore(address_ + ": the server refuses: " + why +
                       "; check database, user and password (PGPASSWORD, ~/.pgpass or a service file)");
    if (answer != PQPING_OK) throw ServerError(address_ + ": the server cannot be reached: " + why);
  }
  PGconn* c = line(connection_);
  pq().PQsetNoticeProcessor(
      c, [](void*, const char*) {}, nullptr);
  const char* encoding = pq().PQparameterStatus(c, "server_encoding");
  if (encoding == nullptr || std::strcmp(encoding, "UTF8") != 0)
    throw WrongStore(address_ + ": the database keeps text as " + (encoding != nullptr ? encoding : "?") +
                     "; make one with ENCODING 'UTF8'");
  // a bench that died in a transaction loses it before those who wait for its lock give up
  script(
      "SET search_path TO powbench, pg_catalog; SET idle_in_transaction_session_timeout = '60s'; "
      "SET lock_timeout = '120s'");
}

void Connection::lost() const {
  const std::string why = sentence(pq().PQerrorMessage(line(connection_)));
  throw ServerError(address_ + ": the connection was lost: " + (why.empty() ? "closed by the server" : why) +
                    "; the same command again goes on where it stopped");
}

void Connection::fail(void* result) const {
  const auto* r = static_cast<const PGresult*>(result);
  const char* field = pq().PQresultErrorField(r, PG_DIAG_SQLSTATE);
  const std::string state = field != nullptr ? field : "", kind = state.substr(0, 2);
  // operator_intervention: shut down, or ended by its administrator
  if (state.empty() || kind == "08" || kind == "57" || pq().PQstatus(line(connection_)) == CONNECTION_BAD)
    lost();
  const char* primary = pq().PQresultErrorField(r, PG_DIAG_MESSAGE_PRIMARY);
  const std::string why = sentence(primary != nullptr ? primary : pq().PQresultErrorMessage(r));
  if (state == "42501")
    throw WrongStore(address_ + ": the user lacks a right: " + why +
                     "; grant it as docs/how-to/central.md says");
  if (state == "25006") throw WrongStore(address_ + ": the database is read-only: " + why);
  if (state == "22021" || state == "22P05")
    throw WrongStore(address_ + ": a text of the store is not UTF-8, which the database needs: " + why);
  if (state == "55P03")
    throw ServerError(address_ +
                      ": another program has kept the same campaign locked for two minutes; the same command "
                      "again goes on where it stopped");
  if (kind == "53") throw ServerError(address_ + ": the server has no room left: " + why);
  throw ServerError(address_ + ": the server refuses a statement: " + why + " (SQLSTATE " + state + ")");
}

void Connection::script(const std::string& sql) {
  const auto r = owned(pq().PQexec(line(connection_), sql.c_str()));
  const auto status = pq().PQresultStatus(raw(r));
  if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK) fail(r.get());
}

Rows Connection::run(const std::string& sql, const Values& values) {
  queue(sql, values);
  return finish().back();
}

const std::string& Connection::prepared(const std::string& sql, const Values& values) {
  const auto [at, fresh] = names_.try_emplace(sql, "s" + std::to_string(names_.size()));
  if (!fresh) return at->second;
  std::vector<Oid> types;
  for (const auto& v : values.list_) types.push_back(v.type);
  if (pq().PQsendPrepare(line(connection_), at->second.c_str(), sql.c_str(), static_cast<int>(types.size()),
                         types.data()) != 1)
    lost();
  queued_.push_back(false);
  return at->second;
}

void Connection::queue(const std::string& sql, const Values& values) {
  PGconn* c = line(connection_);
  if (queued_.empty() && pq().PQenterPipelineMode(c) != 1) lost();
  const std::string& name = prepared(sql, values);
  const std::size_t n = values.list_.size();
  std::vector<const char*> contents(n);
  std::vector<int> lengths(n), formats(n, 1);
  for (std::size_t i = 0; i < n; ++i) {
    contents[i] = values.list_[i].null ? nullptr : values.list_[i].content.data();
    lengths[i] = static_cast<int>(values.list_[i].content.size());
  }
  if (pq().PQsendQueryPrepared(c, name.c_str(), static_cast<int>(n), contents.data(), lengths.data(),
                               formats.data(), 1) != 1)
    lost();
  queued_.push_back(true);
}

std::vector<Rows> Connection::finish() {
  std::vector<Rows> list;
  if (queued_.empty()) return list;
  PGconn* c = line(connection_);
  if (pq().PQpipelineSync(c) != 1) lost();
  for (const bool statement : queued_) {
    auto r = owned(pq().PQgetResult(c));
    if (!r) lost();
    const auto status = pq().PQresultStatus(raw(r));
    if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK) fail(r.get());
    pq().PQclear(pq().PQgetResult(c));  // the end of this statement
    if (statement) list.emplace_back(std::move(r));
  }
  queued_.clear();
  const auto end = owned(pq().PQgetResult(c));
  if (!end || pq().PQresultStatus(raw(end)) != PGRES_PIPELINE_SYNC || pq().PQexitPipelineMode(c) != 1) lost();
  return list;
}

void open_schema(Connection& c, bool write) {
  const auto there = [&] {
    const Rows r = c.run(
        "SELECT (SELECT count(*) FROM pg_namespace WHERE nspname = 'powbench'), (SELECT count(*) FROM "
        "pg_class "
        "k JOIN pg_namespace n ON n.oid = k.relnamespace WHERE n.nspname = 'powbench'), (SELECT count(*) "
        "FROM "
        "pg_class k JOIN pg_namespace n ON n.oid = k.relnamespace WHERE n.nspname = 'powbench' AND k.relname "
        "= "
        "'schema_version')");
    return std::array{r.integer(0, 0), r.integer(0, 1), r.integer(0, 2)};
  };
  const auto version = [&]() -> std::int64_t {
    const auto [schema, relations, ours] = there();
    if (ours != 0) return c.run("SELECT version FROM powbench.schema_version").integer(0, 0);
    if (relations != 0)
      throw WrongStore(c.address() + ": has a schema 'powbench' of another program; name another database");
    if (!write) throw WrongStore(c.address() + ": no store was pushed to this database yet");
    return 0;
  };
  constexpr auto known = static_cast<std::int64_t>(central_migrations.size());
  std::int64_t found = version();
  if (found < known && write) {
    Transaction t(c);
    c.run("SELECT 1 FROM pg_advisory_xact_lock($1)",
          Values().integer(Store::application_id));  // one at a time
    if (there()[0] == 0) c.script("CREATE SCHEMA powbench");
    for (found = version(); found < known; ++found) {
      c.script(std::string(central_migrations[static_cast<std::size_t>(found)]));
      c.run("UPDATE schema_version SET version = $1", Values().integer(found + 1));
    }
    t.commit();
  }
  if (found > known)
    throw StoreError(c.address() + ": its schema is of a newer powbench (" + std::to_string(found) +
                     ", this one knows " + std::to_string(known) + "); update the program");
  if (found < known)
    throw StoreError(c.address() + ": its schema is of an older powbench; a push brings it up to date");
}

}  // namespace powbench::host::postgres
