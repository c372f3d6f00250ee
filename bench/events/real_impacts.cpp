#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "dsp/events/extract.h"
#include "dsp/signal/statistics.h"

/// The extraction on recordings of impacts that nobody here made: columns of numbers (.lvm, .csv), time first, in a
/// folder. Each is a single blow seen by accelerometers, so a list of contacts is wrong, and the verdict has to say
/// so; where the first touch is listed, its time over the sensors of one shot should agree within what u says and the
/// wave's running time.
/// Usage: real_impacts FOLDER

namespace {

using namespace powbench;
namespace fs = std::filesystem;

/// Columns of numbers; lines that begin otherwise are left out. Separators: tab, comma, semicolon, blank.
std::vector<std::vector<double>> columns_of(const fs::path& file) {
  std::ifstream in(file);
  std::vector<std::vector<double>> columns;
  for (std::string line; std::getline(in, line);) {
    std::vector<double> row;
    const char *at = line.data(), *end = line.data() + line.size();
    while (at < end) {
      while (at < end && (*at == '\t' || *at == ',' || *at == ';' || *at == ' ')) ++at;
      double v = 0;
      const auto [rest, error] = std::from_chars(at, end, v);
      if (error != std::errc()) break;
      row.push_back(v);
      at = rest;
    }
    if (row.size() < 2) continue;
    if (columns.empty()) columns.resize(row.size());
    for (std::size_t k = 0; k < columns.size(); ++k)
      columns[k].push_back(k < row.size() ? row[k] : columns[k].empty() ? 0.0 : columns[k].back());
  }
  return columns;
}

/// One column as film A, 20 ms before a fifth of the largest excursion taken for switch-on.
Record record_of(const std::vector<double>& time, const std::vector<double>& value) {
  Record r;
  const double zero = dsp::median(std::span(value).first(std::min<std::size_t>(value.size(), 200)));
  double largest = 0;
  for (const double v : value) largest = std::max(largest, std::abs(v - zero));
  std::size_t first = 0;
  while (first < value.size() && std::abs(value[first] - zero) < 0.2 * largest) ++first;
  r.sample_rate = static_cast<double>(time.size() - 1) / (time.back() - time.front());
  r.fire_sample = static_cast<std::int64_t>(first) - std::llround(20e-3 * r.sample_rate);
  ChannelRecord c;
  c.channel = Channel::pvdf_a;
  c.scale = 10.0 / 30000;  // the largest excursion counts as 10 N
  for (const double v : value)
    c.raw.push_back(static_cast<std::int16_t>(std::lround((v - zero) / largest * 30000)));
  r.channels.push_back(std::move(c));
  return r;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 || !fs::is_directory(argv[1])) {
    std::fprintf(stderr, "real_impacts FOLDER: a folder of .lvm or .csv files, time in the first column\n");
    return 2;
  }
  std::vector<fs::path> files;
  for (const auto& e : fs::recursive_directory_iterator(argv[1]))
    if (e.path().extension() == ".lvm" || e.path().extension() == ".csv") files.push_back(e.path());
  std::sort(files.begin(), files.end());
  std::map<std::string, int> verdicts;
  int channels = 0, more_than_one = 0, most = 0;
  std::printf("%-44s %6s %-11s %8s %12s %8s\n", "file", "column", "shows", "contacts", "first touch ms",
              "+- us");
  for (const fs::path& file : files) {
    const auto columns = columns_of(file);
    if (columns.size() < 2 || columns[0].size() < 1000) continue;
    const bool sensors = file.extension() == ".csv";  // of these every column is an accelerometer
    for (std::size_t k = 1; k < (sensors ? columns.size() : 2); ++k) {
      const Record r = record_of(columns[0], columns[k]);
      const ContactTrain t = dsp::extract_events(r, {}).pvdf_a;
      ++channels, ++verdicts[std::string(name(t.shows))];
      more_than_one += t.contacts.size() > 1;
      most = std::max(most, static_cast<int>(t.contacts.size()));
      const double offset = static_cast<double>(r.fire_sample) / r.sample_rate;
      const bool any = !t.contacts.empty();
      std::printf("%-44.44s %6zu %-11s %8zu %12.4f %8.1f\n", file.filename().string().c_str(), k,
                  std::string(name(t.shows)).c_str(), t.contacts.size(),
                  any ? 1e3 * (t.contacts[0].touch.value + offset) : std::nan(""),
                  any ? 1e6 * t.contacts[0].touch.u : std::nan(""));
    }
  }
  std::printf("\n%d channels:", channels);
  for (const auto& [what, n] : verdicts) std::printf(" %s %d,", what.c_str(), n);
  std::printf(" more than one contact listed in %d, at most %d\n", more_than_one, most);
  return 0;
}
