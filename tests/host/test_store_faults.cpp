#include <fcntl.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <set>

#include "tests/effort.h"
#include "tests/host/store_samples.h"

using namespace powbench;
using namespace powbench::host;
using Catch::Matchers::Contains;

namespace {

const ExtractionInfo torn_extraction{"cutoff = 1\n", "0.1.0"};

/// What the disk does to this process from its n-th write on. SQLite's own calls are replaced, nothing of the store.
struct Disk {
  enum class Fault { none, die, die_torn, full, hang };
  static inline Fault fault = Fault::none;
  static inline int writes_left = 0;
  static inline int hanging = -1;  ///< end of a pipe that hears of Fault::hang

  static ssize_t write_at(int fd, const void* data, size_t size, off_t at) {
    if (fault == Fault::none || --writes_left >= 0) return pwrite(fd, data, size, at);
    if (fault == Fault::full) return errno = ENOSPC, -1;
    if (fault == Fault::hang) {  // says so and waits for kill -9
      const char here = 'w';
      if (write(hanging, &here, 1) == 1)
        for (;;) pause();
      _exit(1);
    }
    if (fault == Fault::die_torn) static_cast<void>(!pwrite(fd, data, size / 2, at));
    _exit(42);
  }

  static void arm(Fault what, int after_writes) {
    sqlite3_vfs* vfs = sqlite3_vfs_find(nullptr);
    for (const char* call : {"pwrite", "pwrite64"})
      vfs->xSetSystemCall(vfs, call, reinterpret_cast<sqlite3_syscall_ptr>(&Disk::write_at));
    fault = what;
    writes_left = after_writes;
  }
};

/// Runs `work` in a child whose disk fails at its n-th write; gives the child's exit code.
template <class Work>
int in_child(Disk::Fault fault, int after_writes, Work&& work) {
  const pid_t child = fork();
  if (child == 0) {
    Disk::arm(fault, after_writes);
    try {
      work();
      _exit(0);
    } catch (const StoreError& e) {
      _exit(std::string(e.what()).find("no room left") != std::string::npos ? 5 : 6);
    } catch (...) {
      _exit(7);
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// The store opens, every shot in it is whole, numbers 0 .. `least` - 1 are there once and nothing above `most`.
void check_whole(const std::string& path, int least, int most) {
  Store store(path);
  if (store.campaigns().empty()) {
    REQUIRE(least == 0);
    return;
  }
  const auto shots = store.shots(store.campaign().id);
  std::set<int> numbers;
  for (const auto& s : shots) {
    REQUIRE(numbers.insert(s.number).second);
    const auto seed = static_cast<std::uint64_t>(s.number);
    REQUIRE(same(store.load_record(s.id), sample_record(seed)));
    REQUIRE(same(store.load_events(s.id).value(), sample_events(seed)));
  }
  REQUIRE(static_cast<int>(numbers.size()) >= least);
  REQUIRE(static_cast<int>(numbers.size()) <= most);
  if (!numbers.empty()) REQUIRE(*numbers.rbegin() == static_cast<int>(numbers.size()) - 1);
}

void add(Store& store, std::int64_t campaign, int number) {
  const auto seed = static_cast<std::uint64_t>(number);
  const Record record = sample_record(seed);
  const Events events = sample_events(seed);
  store.store_shot(sample_shot(campaign, number), &record, &events, torn_extraction);
}

}  // namespace

TEST_CASE("death at any write leaves whole shots and a store that goes on", "[store]") {
  for (const auto fault : {Disk::Fault::die, Disk::Fault::die_torn}) {
    int died = 0;
    for (int writes = 0; writes < 200; writes += effort::every) {
      const Folder folder;
      {
        Store store(folder.file());
        fill(store, 1);
      }
      const int code = in_child(fault, writes, [&] {
        Store store(folder.file());
        for (int i = 1; i < 3; ++i) add(store, 1, i);
      });
      CAPTURE(writes, code);
      REQUIRE((code == 42 || code == 0));
      check_whole(folder.file(), code == 0 ? 3 : 1, 3);
      {
        Store store(folder.file());
        const int there = static_cast<int>(store.shots(1).size());
        for (int i = there; i < 4; ++i) add(store, 1, i);
      }
      check_whole(folder.file(), 4, 4);
      if (code == 0) break;
      ++died;
    }
    CHECK(died * effort::every > 20);   // there are that many writes in two shots, the log and its checkpoint
    CHECK(died * effort::every < 200);  // and the last round got through
  }
}

TEST_CASE("death while the store is made leaves a store that can be made", "[store]") {
  int died = 0;
  bool through = false;
  for (int writes = 0; writes < 200 && !through; writes += effort::every) {
    const Folder folder;
    const int code = in_child(Disk::Fault::die_torn, writes, [&] { Store store(folder.file()); });
    REQUIRE((code == 42 || code == 0));
    check_whole(folder.file(), 0, 0);
    through = code == 0;
    died += !through;
  }
  CHECK(died * effort::every > 3);
  CHECK(through);  // there are about a hundred writes
}

TEST_CASE("kill -9 at random writes loses no stored shot", "[store]") {
  Random random(31);
  const Folder folder;
  {
    Store store(folder.file());
    fill(store, 1);
  }
  int stored = 1;
  for (int round = 0; round < 50; ++round) {
    const int writes = static_cast<int>(random.below(80));
    int pipe_ends[2];
    REQUIRE(pipe(pipe_ends) == 0);
    const pid_t child = fork();
    if (child == 0) {
      Disk::hanging = pipe_ends[1];
      Disk::arm(Disk::Fault::hang, writes);
      Store store(folder.file());
      for (int i = stored;; ++i) {
        add(store, 1, i);
        const char done = 'x';
        if (write(pipe_ends[1], &done, 1) != 1) _exit(1);  // told only after the shot is stored
      }
    }
    close(pipe_ends[1]);
    int acknowledged = 0;
    char told = 0;
    while (read(pipe_ends[0], &told, 1) == 1 && told == 'x') ++acknowledged;
    REQUIRE(told == 'w');  // it stands still in the middle of a write that has not happened
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    close(pipe_ends[0]);
    Store store(folder.file());
    const int there = static_cast<int>(store.shots(1).size());
    REQUIRE(there >= stored + acknowledged);
    REQUIRE(there <= stored + acknowledged + 1);
    stored = there;
  }
  CHECK(stored > 5);
  check_whole(folder.file(), stored, stored);
}

TEST_CASE("a disk that fills up at any write costs the shot in flight only", "[store]") {
  int refused = 0;
  for (int writes = 0; writes < 200; writes += effort::every) {
    const Folder folder;
    {
      Store store(folder.file());
      fill(store, 2);
    }
    const int code = in_child(Disk::Fault::full, writes, [&] {
      Store store(folder.file());
      for (int i = 2; i < 4; ++i) add(store, 1, i);
    });
    CAPTURE(writes, code);
    REQUIRE((code == 5 || code == 0));
    check_whole(folder.file(), code == 0 ? 4 : 2, 4);
    if (code == 0) break;
    ++refused;
  }
  CHECK(refused * effort::every > 10);
  CHECK(refused * effort::every < 200);
}

TEST_CASE("a disk that is full leaves the file as it was", "[store]") {
  const Folder folder;
  {
    Store store(folder.file());
    fill(store, 2);
  }
  const std::string before = bytes_of(folder.file());
  CHECK(in_child(Disk::Fault::full, 0, [&] {
          Store store(folder.file());
          add(store, 1, 2);
        }) == 5);
  CHECK(bytes_of(folder.file()) == before);
  check_whole(folder.file(), 2, 2);
}

TEST_CASE("a store that may not grow refuses in words and keeps what it has", "[store]") {
  const Folder folder;
  {
    Store store(folder.file());
    fill(store, 2);
    store.limit_pages(1);  // SQLite raises it to what is in use
    CHECK_THROWS_WITH(add(store, 1, 2), Contains("no room left"));
    CHECK(store.shots(1).size() == 2);
    store.limit_pages(1'000'000);
    add(store, 1, 2);
  }
  check_whole(folder.file(), 3, 3);
}

TEST_CASE("a measured shot whose record went away, and a unit that is another, are damage", "[store]") {
  const Folder folder;
  {
    Store store(folder.file());
    fill(store, 3);
  }
  const auto change = [&](const char* statement) {
    sqlite3* db = nullptr;
    REQUIRE(sqlite3_open(folder.file().c_str(), &db) == SQLITE_OK);
    CHECK(sqlite3_exec(db, statement, nullptr, nullptr, nullptr) == SQLITE_OK);
    sqlite3_close(db);
  };
  change("UPDATE channel SET unit = 'mN' WHERE record_id = 1 AND position = 0");
  CHECK_THROWS_WITH(Store(folder.file()).load_record(1), Contains("unit 'mN'"));
  // the shot goes by another number, so that nothing belongs to it
  change("UPDATE shot SET id = 77 WHERE id = 2");
  CHECK_THROWS_WITH(Store(folder.file()).load_events(77), Contains("the record of shot 77 is missing"));
}

TEST_CASE("a cut-off store is refused and stays as it is", "[store]") {
  const Folder folder;
  {
    Store store(folder.file("whole.db"));
    fill(store, 3);
  }
  const std::string whole = bytes_of(folder.file("whole.db"));
  Random random(12);
  for (int i = 0; i < 20; ++i) {
    const std::string cut = whole.substr(0, 1 + random.below(whole.size() - 1));
    write_bytes(folder.file("cut.db"), cut);
    for (const auto mode : {Store::Mode::read_write, Store::Mode::read_only})
      CHECK_THROWS_AS(Store(folder.file("cut.db"), mode), StoreError);
    CHECK(bytes_of(folder.file("cut.db")) == cut);
    CHECK_FALSE(std::filesystem::exists(folder.file("cut.db-wal")));
  }
}

TEST_CASE("flipped bits are told as damage; samples that load are the samples that were stored", "[store]") {
  const Folder folder;
  {
    Store store(folder.file("whole.db"));
    fill(store, 3, 200);
  }
  const std::string whole = bytes_of(folder.file("whole.db"));
  Random random(77);
  int damaged = 0, fine = 0, silent = 0;
  for (int i = 0; i < 600; i += effort::every) {
    std::string bytes = whole;
    const std::size_t at =
        i < 100 ? static_cast<std::size_t>(i) : random.below(bytes.size());  // the header by every byte
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.below(8)));
    const std::string file = folder.file("flipped.db");
    write_bytes(file, bytes);
    CAPTURE(at);
    bool opened = false;
    try {
      const Store store(file, i % 2 == 0 ? Store::Mode::read_only : Store::Mode::read_write);
      opened = true;
      bool equal = store.campaigns().size() == 1 && store.campaign().plan == sample_campaign().plan;
      const auto shots = store.shots(1);
      equal = equal && shots.size() == 3;
      for (const auto& s : shots) {
        const auto seed = static_cast<std::uint64_t>(s.number);
        const Record record = store.load_record(s.id);
        if (s.number >= 0 && s.number < 3) REQUIRE(same_samples(record, sample_record(seed, 200)));
        const auto events = store.load_events(s.id);
        equal = equal && same(record, sample_record(seed, 200)) && events &&
                same(*events, sample_events(seed)) && same(s.conditions, sample_shot(1, s.number).conditions);
      }
      ++(equal ? fine : silent);
    } catch (const StoreError&) {
      ++damaged;
    }
    if (!opened) REQUIRE(bytes_of(file) == bytes);
    REQUIRE_FALSE(std::filesystem::exists(file + "-wal"));
    for (const char* tail : {"", "-wal", "-shm"}) std::filesystem::remove(file + tail);
  }
  CAPTURE(damaged, fine, silent);
  CHECK(damaged * effort::every > 100);
  CHECK(silent == 0);
}
