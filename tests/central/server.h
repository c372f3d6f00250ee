#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sqlite3.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "host/store/central/central.h"
#include "host/store/central/postgres.h"
#include "tests/system/program.h"
#include "tests/waiting.h"

/// A PostgreSQL server of Debian's package on loopback, with a data directory of its own; it ends with the test
/// program.

namespace powbench::test {

namespace pg = host::postgres;

/// A port of loopback that nobody uses now.
inline int free_port() {
  const int s = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in a{};
  a.sin_family = AF_INET;
  a.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof a;
  bind(s, reinterpret_cast<sockaddr*>(&a), size);
  getsockname(s, reinterpret_cast<sockaddr*>(&a), &size);
  close(s);
  return ntohs(a.sin_port);
}

inline std::string shell(const std::string& command) {
  std::string out;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  char part[4096];
  while (const std::size_t n = fread(part, 1, sizeof part, pipe)) out.append(part, n);
  if (pclose(pipe) != 0) throw std::runtime_error(command + ": " + out);
  return out;
}

class Server {
 public:
  /// One for all tests of the program: it takes a second to make.
  static Server& get() {
    static Server server;
    return server;
  }

  /// Address of a new database, over the server's own socket, where nobody needs a password.
  std::string base(const std::string& name, const std::string& options = "") {
    admin_->script("CREATE DATABASE " + name + " " + options);
    return address(name);
  }
  std::string address(const std::string& name, const std::string& user = "lab") const {
    return "postgresql://" + user + "@/" + name + "?host=" + folder_.file("") +
           "&port=" + std::to_string(port_);
  }
  /// The same over TCP, where the password of `lab` is "secret word".
  std::string tcp(const std::string& name, const std::string& user = "lab") const {
    return "postgresql://" + user + "@127.0.0.1:" + std::to_string(port_) + "/" + name;
  }
  pg::Connection& admin() { return *admin_; }
  const Folder& folder() const { return folder_; }
  int port() const { return port_; }

 private:
  Server() {
    const bool root = getuid() == 0;  // the server refuses to be root
    const std::string as = root ? "setpriv --reuid=postgres --regid=postgres --clear-groups " : "";
    const std::string bin = "$(ls -d /usr/lib/postgresql/*/bin | tail -n 1)";
    try {
      shell("test -x " + bin + "/initdb");
    } catch (const std::runtime_error&) {
      throw std::runtime_error("PostgreSQL's server is not installed (Debian: postgresql)");
    }
    folder_.write("password", "secret word\n");
    chmod(folder_.file("").c_str(), 0755);
    if (root) shell("chown postgres " + folder_.file(""));
    shell(as + bin + "/initdb -D " + folder_.file("data") +
          " -U lab -A trust --auth-host=scram-sha-256 --pwfile=" + folder_.file("password") +
          " -E UTF8 --locale=C.UTF-8 --no-sync");
    const std::string start =
        "exec setpriv --pdeathsig INT " + as.substr(std::min(as.size(), std::size_t{8})) + bin +
        "/postgres -D " + folder_.file("data") + " -k " + folder_.file("") + " -p " + std::to_string(port_) +
        " -c listen_addresses=127.0.0.1 -F -c max_connections=30 >" + folder_.file("log") + " 2>&1";
    pid_ = fork();
    if (pid_ == 0) {
      execl("/bin/bash", "bash", "-c", start.c_str(), nullptr);
      _exit(127);
    }
    wait_until("the server", [&] {
      try {
        admin_ = std::make_unique<pg::Connection>(address("postgres"));
        return true;
      } catch (const host::ServerError&) {
        if (waitpid(pid_, nullptr, WNOHANG) != 0) throw std::runtime_error(read_file(folder_.file("log")));
        return false;
      }
    });
  }
  ~Server() {
    admin_.reset();
    kill(pid_, SIGINT);
    waitpid(pid_, nullptr, 0);
  }

  Folder folder_;
  int port_ = free_port();
  pid_t pid_ = -1;
  std::unique_ptr<pg::Connection> admin_;
};

/// Everything that stands in a database, and which transaction wrote it.
inline std::string state(const std::string& base) {
  pg::Connection c(base);
  std::string all;
  for (const char* table : {"campaign", "shot", "record", "channel", "events", "prediction", "annotation",
                            "sweep", "sweep_block"})
    all += c.run(std::string(
                     "SELECT count(*)::text || ' ' || coalesce(md5(string_agg(t.xmin::text || t::text, '|' "
                     "ORDER BY t.ctid)), '') FROM ") +
                 table + " t")
               .text(0, 0) +
           "\n";
  return all;
}

/// SHA-256 of the content of a store that is whole.
inline std::string content(const std::string& file) {
  const host::StoreContent c = host::check_store(file);
  for (const std::string& d : c.damage) UNSCOPED_INFO(d);
  CHECK(c.damage.empty());
  CHECK(c.hash.size() == 64);
  return c.hash;
}

inline void change_store(const std::string& path, const std::string& statement) {
  sqlite3* db = nullptr;
  REQUIRE(sqlite3_open(path.c_str(), &db) == SQLITE_OK);
  CHECK(sqlite3_exec(db, statement.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
  sqlite3_close(db);
}

}  // namespace powbench::test
