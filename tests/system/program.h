#pragma once

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/folder.h"
#include "tests/places.h"

/// The command line as a user runs it: a process of its own, in a folder of its own.
namespace powbench::test {

/// A running program; killed with the object.
class Program {
 public:
  Program(const Folder& folder, const std::vector<std::string>& arguments)
      : out_(folder.file("stdout.txt")), err_(folder.file("stderr.txt")) {
    pid_ = fork();
    if (pid_ != 0) return;
    const auto redirect = [](const std::string& file, int to) {
      const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
      dup2(fd, to);
      close(fd);
    };
    redirect(out_, STDOUT_FILENO);
    redirect(err_, STDERR_FILENO);
    std::string file = powbench::test::program();
    std::vector<char*> argv{file.data()};
    for (const auto& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    execv(file.c_str(), argv.data());
    _exit(127);
  }
  ~Program() {
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      wait();
    }
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  int pid() const { return pid_; }
  void send(int signal) const { kill(pid_, signal); }

  /// Exit code; -signal when a signal ended it.
  int wait() {
    if (pid_ <= 0) return status_;
    int raw = 0;
    rusage used{};
    wait4(pid_, &raw, 0, &used);
    peak_megabytes_ = static_cast<double>(used.ru_maxrss) / 1e3;
    pid_ = -1;
    status_ = WIFEXITED(raw) ? WEXITSTATUS(raw) : -WTERMSIG(raw);
    return status_;
  }
  /// The most memory that it held at once, after wait(); at least what the test program held when it started it.
  double peak_megabytes() const { return peak_megabytes_; }
  /// Exit code if it has ended, else -1000.
  int poll() {
    if (pid_ <= 0) return status_;
    int raw = 0;
    if (waitpid(pid_, &raw, WNOHANG) == 0) return -1000;
    pid_ = -1;
    return status_ = WIFEXITED(raw) ? WEXITSTATUS(raw) : -WTERMSIG(raw);
  }

  std::string out() const { return read_file(out_); }
  std::string err() const { return read_file(err_); }

 private:
  std::string out_, err_;
  pid_t pid_ = -1;
  int status_ = 0;
  double peak_megabytes_ = 0;
};

struct Finished {
  int status;
  std::string out, err;
};

inline Finished run(const Folder& folder, const std::vector<std::string>& arguments) {
  Program program(folder, arguments);
  const int status = program.wait();
  return {status, program.out(), program.err()};
}

}  // namespace powbench::test
