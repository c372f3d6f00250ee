#include "tests/central/server.h"
#include "tests/host/overlapping_stores.h"
#include "tests/places.h"

/// What a server, a database or an address does not allow: one sentence and the exit code of its kind.

using namespace powbench;
using namespace powbench::host;
using namespace powbench::test;
using Catch::Contains;

namespace {

std::string small_store(const host::Folder& folder, int shots = 3) {
  const std::string file = folder.file("small.db");
  Store store(file);
  const auto c = store.create_campaign(sample_campaign("small"));
  for (int i = 0; i < shots; ++i) put_shot(store, c, i, static_cast<std::uint64_t>(i));
  return file;
}

/// Runs a verb of `db` and looks at code and words.
void refuses(const std::vector<std::string>& words, int status, const std::string& why) {
  const test::Folder out;
  std::vector<std::string> all{"db"};
  all.insert(all.end(), words.begin(), words.end());
  const Finished r = test::run(out, all);
  INFO(r.err);
  CHECK(r.status == status);
  CHECK(r.out.empty());
  CHECK_THAT(r.err, Contains(why));
  CHECK_THAT(r.err + r.out, !Contains("secret"));
  CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
}

}  // namespace

TEST_CASE("addresses that are none, and servers that are not there", "[central]") {
  const host::Folder folder;
  const std::string store = small_store(folder);
  const std::string nowhere = "postgresql://lab@127.0.0.1:" + std::to_string(free_port()) + "/base";
  for (const std::string verb : {"push", "pull"}) {
    for (const char* address : {"lab.db", "mysql://lab@host/base", "host=h password=secret dbname=b",
                                "postgres:/lab:secret@host/base"})
      refuses({verb, address, "--db", store}, 2,
              "not the address of a database; allowed postgresql://USER@HOST");
    refuses({verb, "postgresql://lab:sec%zzret@host/base", "--db", store}, 2,
            "cannot be read as the address");
    refuses({verb, "postgresql://lab@host/base?nonsense=1", "--db", store}, 2,
            "cannot be read as the address");
    for (const char* address :
         {"postgresql://lab:secret@host/base", "postgresql://lab@host/base?password=secret",
          "postgresql://lab@host/base?sslpassword=secret"})
      refuses({verb, address, "--db", store}, 2, "leave it out and set PGPASSWORD");
    refuses({verb, nowhere, "--db", store}, 3, nowhere + ": the server cannot be reached");
    refuses({verb, "postgresql://lab@/base?host=" + folder.file("no"), "--db", store}, 3,
            "cannot be reached");
  }
  refuses({"pull", nowhere, "--db", store, "--since", "yesterday"}, 2,
          "--since 'yesterday': not a day; allowed");
  for (const char* day : {"2030-02-30", "2030-1-1", "31.12.2030", "2030-12-31T10:00:00Z", "tomorrow"})
    refuses({"pull", nowhere, "--db", store, "--since", day}, 2,
            "not a day; allowed is year-month-day in digits, such as 2030-12-31");
  const std::string text = folder.file("text.db");
  write_bytes(text, "a = 1\n");
  refuses({"push", nowhere, "--db", folder.file("none.db")}, 2, "no such store");
  refuses({"pull", nowhere, "--db", folder.file("")}, 2, "is a folder");
  refuses({"pull", nowhere, "--db", text}, 2, "not a powbench store");
}

TEST_CASE("the password comes from the environment or from files", "[central][.slow]") {
  Server& server = Server::get();
  const host::Folder folder;
  const std::string store = small_store(folder);
  server.base("password");
  const std::string tcp = server.tcp("password");
  unsetenv("PGPASSWORD");
  setenv("PGPASSFILE", folder.file("none").c_str(), 1);
  refuses({"push", tcp, "--db", store}, 2, "no password supplied");
  setenv("PGPASSWORD", "not this secret", 1);
  refuses({"push", tcp, "--db", store}, 2, "password authentication failed");
  refuses({"push", server.tcp("nobody", "nobody"), "--db", store}, 2, "the server refuses");
  setenv("PGPASSWORD", "secret word", 1);
  CHECK(push_store(store, tcp).shots == 3);
  unsetenv("PGPASSWORD");
  write_bytes(folder.file("pass"), "127.0.0.1:*:*:lab:secret word\n");
  chmod(folder.file("pass").c_str(), 0600);
  setenv("PGPASSFILE", folder.file("pass").c_str(), 1);
  CHECK(push_store(store, tcp).shots == 0);
  unsetenv("PGPASSFILE");
  write_bytes(folder.file("services"), "[lab]\nhost=127.0.0.1\nport=" + std::to_string(server.port()) +
                                           "\nuser=lab\ndbname=password\npassword=secret word\n");
  setenv("PGSERVICEFILE", folder.file("services").c_str(), 1);
  CHECK(push_store(store, "postgresql:///?service=lab").shots == 0);
  unsetenv("PGSERVICEFILE");
}

TEST_CASE("databases that do not fit, and rights that are missing", "[central][.slow]") {
  Server& server = Server::get();
  const host::Folder folder;
  const std::string store = small_store(folder), back = folder.file("back.db");
  refuses({"push", server.address("missing"), "--db", store}, 2, "database \"missing\" does not exist");
  const std::string ascii = server.base("ascii", "TEMPLATE template0 ENCODING 'SQL_ASCII' LOCALE 'C'");
  refuses({"push", ascii, "--db", store}, 2, "keeps text as SQL_ASCII");
  refuses({"pull", server.base("empty"), "--db", back}, 2, "no store was pushed to this database yet");
  pg::Connection(server.base("other_program"))
      .script("CREATE SCHEMA powbench; CREATE TABLE powbench.other (x int)");
  refuses({"push", server.address("other_program"), "--db", store}, 2,
          "schema 'powbench' of another program");

  const std::string base = server.base("rights");
  pg::Connection admin(base);
  admin.script("CREATE ROLE bench LOGIN; CREATE ROLE reader LOGIN");
  refuses({"push", server.address("rights", "bench"), "--db", store}, 2,
          "lacks a right: permission denied for database");
  push_store(store, base);
  refuses({"push", server.address("rights", "bench"), "--db", store}, 2,
          "permission denied for schema powbench");
  // as docs/how-to/central.md says
  const std::string page = read_file(test::source_dir() + "/docs/how-to/central.md");
  const auto grants = page.find("GRANT USAGE");
  REQUIRE(grants != std::string::npos);
  admin.script(page.substr(grants, page.find("```", grants) - grants));
  CHECK(push_store(store, server.address("rights", "bench")).shots == 0);
  {
    Store more(store);
    more.annotate(1, "customer", "one");
    more.store_events(1, sample_events(9), {"b", "0.2"});
    put_shot(more, 1, 7, 7);
  }
  CHECK(push_store(store, server.address("rights", "bench")).shots == 1);
  CHECK(pull_store(server.address("rights", "reader"), back).shots == 4);
  CHECK(content(back) == content(store));
  refuses({"push", server.address("rights", "reader"), "--db",
           [&] {
             Store more(store);
             put_shot(more, 1, 8, 8);
             return store;
           }()},
          2, "permission denied for table");
  refuses({"pull", base, "--db", folder.file("x.db"), "--customer", "two"}, 2,
          "no such campaign; customers there: 'one'; devices: none; names: 'small'");
  const std::string begun = Store(store).campaign(1).created.substr(0, 10);
  const std::vector<std::string> later{"pull", base, "--db", folder.file("x.db"), "--since", "2999-12-31"};
  refuses(later, 2,
          base + ": no campaign was begun on 2999-12-31 or later; the newest was begun on " + begun);
  std::vector<std::string> of_one = later;
  of_one.insert(of_one.end(), {"--customer", "one"});
  refuses(of_one, 2,
          "no such campaign was begun on 2999-12-31 or later; the newest such one was begun on " + begun);
  of_one.back() = "two";
  refuses(of_one, 2, "no such campaign; customers there: 'one'");
  CHECK_FALSE(std::filesystem::exists(folder.file("x.db")));
  const std::string none = server.base("no_campaign");
  { const Store fresh(folder.file("fresh.db")); }
  push_store(folder.file("fresh.db"), none);
  refuses({"pull", none, "--db", folder.file("x.db"), "--since", "2020-01-01"}, 2,
          "the database has no campaign yet");

  admin.script("UPDATE powbench.schema_version SET version = 99");
  refuses({"push", base, "--db", store}, 5, "of a newer powbench (99, this one knows 1)");
  refuses({"pull", base, "--db", back}, 5, "of a newer powbench (99, this one knows 1)");
}

TEST_CASE("what is damaged is not pushed", "[central][.slow]") {
  const host::Folder folder;
  const std::string store = small_store(folder), base = Server::get().base("damage"), whole = bytes_of(store);
  for (const char* change :
       {"UPDATE record SET scans = x'00' WHERE id = 2", "UPDATE shot SET repeat = 9 WHERE id = 2",
        "UPDATE events SET events = '{}' WHERE id = 2", "UPDATE channel SET delay = 1"}) {
    INFO(change);
    write_bytes(store, whole);
    change_store(store, change);
    refuses({"push", base, "--db", store}, 5, "damaged");
  }
  write_bytes(store, whole);
  Store(store).annotate(1, "customer", "M\xfcller");  // Latin-1
  refuses({"push", base, "--db", store}, 2, "a text of the store is not UTF-8");
}

TEST_CASE("a row of the database that was changed there is not pulled", "[central][.slow]") {
  // a campaign for each change; %: its id, @: of its last shot
  const std::vector<std::string> changes{"",
                                         "UPDATE record SET scans = '\\x00' WHERE shot_id = @",
                                         "UPDATE shot SET reason = 'x' WHERE id = @",
                                         "UPDATE events SET events = '{}' WHERE shot_id = @",
                                         "UPDATE channel SET delay = 1 WHERE shot_id = @",
                                         "UPDATE prediction SET uncertainty = '{}' WHERE shot_id = @",
                                         "UPDATE annotation SET text = 'x' WHERE campaign_id = %",
                                         "DELETE FROM channel WHERE shot_id = @",
                                         "DELETE FROM events WHERE shot_id = @; DELETE FROM channel WHERE "
                                         "shot_id = @; DELETE FROM record WHERE shot_id "
                                         "= @",
                                         "UPDATE campaign SET rig_uri = 'x' WHERE id = %"};
  const host::Folder folder;
  {
    Store store(folder.file());
    for (std::size_t i = 0; i < changes.size(); ++i) {
      const auto c = store.create_campaign(sample_campaign(std::to_string(i)));
      for (int k = 0; k < 2; ++k) put_shot(store, c, k, 10 * i + static_cast<std::uint64_t>(k));
      store.annotate(c, "operator", "A");
    }
  }
  const std::string base = Server::get().base("changed"), back = folder.file("back.db");
  push_store(folder.file(), base);
  pg::Connection c(base);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    INFO(changes[i]);
    const std::string id =
        c.run("SELECT id::text FROM campaign WHERE name = $1", pg::Values().text(std::to_string(i)))
            .text(0, 0);
    std::string change = changes[i];
    for (std::size_t at = 0; (at = change.find_first_of("%@")) != std::string::npos;)
      change.replace(at, 1,
                     change[at] == '%' ? id : "(SELECT max(id) FROM shot WHERE campaign_id = " + id + ")");
    if (i > 0) c.script(change);
    const CampaignChoice choice = [&](const CampaignInfo& x, const auto&) {
      return x.name == std::to_string(i);
    };
    if (i == 0)
      CHECK(pull_store(base, back, choice).shots == 2);
    else
      CHECK_THROWS_WITH(pull_store(base, back, choice), Contains("match"));
    std::filesystem::remove(back);
    CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
    if (changes[i].find("annotation") != std::string::npos)
      c.script("DELETE FROM annotation WHERE campaign_id = " + id);
  }
  refuses({"pull", base, "--db", back}, 5, "does not match its hash: the database is damaged");
}

TEST_CASE("a connection that is lost is said, and the push goes on", "[central][.slow]") {
  Server& server = Server::get();
  const host::Folder folder;
  const std::string store = small_store(folder, 400), base = server.base("lost");
  pg::Connection& admin = server.admin();
  const test::Folder out;
  Program push(out, {"db", "push", base, "--db", store});
  const auto end_it = [&] {
    return admin
        .run(
            "SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity WHERE datname = 'lost' AND query "
            "LIKE "
            "'INSERT INTO%'")
        .integer(0, 0);
  };
  int status = -1000;
  wait_until("a push to end", [&] { return end_it() > 0 || (status = push.poll()) != -1000; });
  if (status == -1000) status = push.wait();
  CHECK(status == 3);
  CHECK_THAT(push.err(), Contains("the connection was lost") && Contains("goes on where it stopped"));
  CHECK(push_store(store, base).shots > 0);
  pull_store(base, folder.file("back.db"));
  CHECK(content(folder.file("back.db")) == content(store));
}
