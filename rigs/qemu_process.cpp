#include "rigs/qemu_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>

#include "rigs/rig.h"

extern char** environ;

namespace powbench::rigs {

namespace {

constexpr const char* emulator = "qemu-system-arm";
constexpr int answer_limit_ms = 30'000;
constexpr int child_reads = 3, child_writes = 4;  // the descriptors that the image opens

/// Writing to an emulator that has ended must be an error, not the end of this program. Held per thread: what
/// a program does about SIGPIPE elsewhere is its own affair.
class NoBrokenPipeSignal {
 public:
  NoBrokenPipeSignal() {
    sigemptyset(&pipe_);
    sigaddset(&pipe_, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &pipe_, &before_);
  }
  ~NoBrokenPipeSignal() {
    const timespec at_once{};
    if (!sigismember(&before_, SIGPIPE)) sigtimedwait(&pipe_, nullptr, &at_once);
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }

 private:
  sigset_t pipe_{}, before_{};
};

/// The calling thread on one core; a child that it starts stays there.
class OnCore {
 public:
  explicit OnCore(int core) {
    if (core < 0 || sched_getaffinity(0, sizeof before_, &before_) != 0) return;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(static_cast<unsigned>(core), &one);
    held_ = sched_setaffinity(0, sizeof one, &one) == 0;
  }
  ~OnCore() {
    if (held_) sched_setaffinity(0, sizeof before_, &before_);
  }

 private:
  cpu_set_t before_{};
  bool held_ = false;
};

std::string system_error(const char* what) {
  return std::string("cannot start the emulated board: ") + what + ": " + std::strerror(errno);
}

}  // namespace

QemuProcess::QemuProcess(const std::string& image, bool count_instructions) : core_(sched_getcpu()) {
  int down[2], up[2];
  if (pipe2(down, O_CLOEXEC) != 0) throw RigError(system_error("pipe"));
  if (pipe2(up, O_CLOEXEC) != 0) {
    const std::string why = system_error("pipe");
    close(down[0]), close(down[1]);
    throw RigError(why);
  }
  // out of the way of the two numbers the child gets
  const int child_in = fcntl(down[0], F_DUPFD_CLOEXEC, 10), child_out = fcntl(up[1], F_DUPFD_CLOEXEC, 10);
  close(down[0]), close(up[1]);
  to_ = down[1], from_ = up[0];

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, child_in, child_reads);
  posix_spawn_file_actions_adddup2(&files, child_out, child_writes);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, all;
  sigemptyset(&none), sigfillset(&all);
  // a group of its own: Ctrl-C is this program's to handle
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);

  std::vector<std::string> words{emulator,
                                 "-M",
                                 "mps2-an386",
                                 "-display",
                                 "none",
                                 "-monitor",
                                 "none",
                                 "-serial",
                                 "null",
                                 "-kernel",
                                 image,
                                 "-semihosting-config",
                                 "enable=on,target=native"};
  if (count_instructions) words.insert(words.end(), {"-icount", "shift=6,align=off,sleep=off"});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  int error = 0;
  {
    const OnCore there(core_);
    error = posix_spawnp(&pid_, emulator, &files, &attributes, arguments.data(), environ);
  }
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  close(child_in), close(child_out);
  if (error != 0) {
    pid_ = -1;
    finish();
    throw RigError(std::string("cannot start ") + emulator + ": " + std::strerror(error) +
                   "; on Debian: apt-get install qemu-system-arm");
  }
}

QemuProcess::~QemuProcess() {
  finish();
}

double QemuProcess::processor_seconds() const {
  std::ifstream stat("/proc/" + std::to_string(pid_) + "/stat");
  std::string word;
  for (int field = 1; field < 14; ++field) stat >> word;  // the program's name holds no blank
  double user = 0, system = 0;
  stat >> user >> system;
  return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

int QemuProcess::finish() {
  if (to_ >= 0) close(to_);
  if (from_ >= 0) close(from_);
  to_ = from_ = -1;
  if (pid_ < 0) return -1;
  int status = 0;
  pid_t ended = 0;
  for (int i = 0; i < 1000 && ended == 0; ++i) {
    ended = waitpid(pid_, &status, WNOHANG);
    if (ended == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  if (ended == 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, &status, 0);
  }
  pid_ = -1;
  return ended > 0 && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

void QemuProcess::gone() {
  const int code = finish();
  throw RigError("the emulated board has ended" +
                 (code >= 0 ? " with code " + std::to_string(code) : std::string()) +
                 "; what the emulator said stands above");
}

void QemuProcess::send(std::span<const std::uint8_t> bytes) {
  const NoBrokenPipeSignal guard;
  while (!bytes.empty()) {
    const ssize_t n = write(to_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) gone();
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
}

void QemuProcess::receive(std::vector<std::uint8_t>& to) {
  std::array<std::uint8_t, 32 * 1024> bytes;
  for (;;) {
    pollfd wanted{from_, POLLIN, 0};
    const int ready = poll(&wanted, 1, answer_limit_ms);
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) throw RigError("the emulated board does not answer");
    const ssize_t n = read(from_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) gone();
    to.insert(to.end(), bytes.begin(), bytes.begin() + n);
    return;
  }
}

void QemuProcess::share_core() const {
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(static_cast<unsigned>(core_ < 0 ? 0 : core_), &one);
  // speed only: a machine that does not let us is slower, not wrong
  if (core_ >= 0) (void)sched_setaffinity(0, sizeof one, &one);
}

}  // namespace powbench::rigs
