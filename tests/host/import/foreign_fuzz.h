#pragma once

#include <fmt/format.h>

#include <map>
#include <string>

#include "bench/records/foreign_samples.h"
#include "core/random.h"
#include "host/config/bad_input.h"
#include "host/import/comtrade.h"
#include "host/import/dcc.h"
#include "host/import/foreign_table.h"
#include "host/import/wvf.h"

/// Broken files: every importer takes what a seed makes of whole files, and either reads a table that is one or
/// refuses in words.

namespace powbench::host {

struct FuzzTally {
  std::map<std::string, std::pair<long, long>> read_refused;  ///< by kind of file
  std::string wrong;                                          ///< the first input that did neither
  long count = 0;
};

/// Whole files to begin with: all of foreign_samples.h, COMTRADE, WAV, LVM, a certificate.
inline std::vector<Foreign> fuzz_corpus() {
  const Waves w = waves(7, 24);
  std::vector<Foreign> list = scope_texts(w);
  for (Foreign& f : binary_files(w)) list.push_back(std::move(f));
  Foreign comtrade{.name = "COMTRADE",
                   .file = "x.dat",
                   .bytes = "",
                   .header =
                       "S,D,1999\n2,2A,0D\n1,Ua,,,V,0.5,0,0,-32767,32767,1,1,P\n"
                       "2,Ub,,,V,0.5,0,0,-32767,32767,1,1,P\n50\n1\n10000,40\n01/01/2026,00:00:00.000000\n01/"
                       "01/2026,00:00:00.001000\nBINARY\n1\n"};
  for (int i = 0; i < 40; ++i)
    for (const int v : {i + 1, 0, 0, 0, i % 7, 0, i % 5, 0}) comtrade.bytes += static_cast<char>(v);
  comtrade.bytes.resize(40 * 12, '\1');
  list.push_back(comtrade);
  std::string wav("RIFF\x24\1\0\0WAVEfmt \x10\0\0\0\1\0\2\0\x10\x27\0\0\x40\x9c\0\0\4\0\x10\0data\0\1\0\0",
                  44);
  wav.resize(44 + 256, '\3');
  list.push_back({.name = "WAV", .file = "x.wav", .bytes = wav, .header = ""});
  std::string lvm =
      "LabVIEW "
      "Measurement\t\nSeparator\tTab\nX_Columns\tOne\n***End_of_Header***\t\nChannels\t2\nY_Unit_"
      "Label\tVolts\tVolts\n"
      "Delta_X\t1e-5\t1e-5\n***End_of_Header***\nX_Value\tA\tB\tComment\n";
  for (int i = 0; i < 30; ++i) lvm += fmt::format("{}\t{}\t{}\n", i * 1e-5, i % 4, i % 3);
  list.push_back({.name = "LVM", .file = "x.lvm", .bytes = lvm, .header = ""});
  list.push_back(
      {.name = "DCC",
       .file = "x.xml",
       .bytes = "<?xml version=\"1.0\"?><d:digitalCalibrationCertificate><d:coreData><d:uniqueIdentifier>K"
                "</d:uniqueIdentifier></d:coreData><d:measurementResults><d:quantity><s:real><s:value>10.02</"
                "s:value><s:unit>\\newton\\per\\volt"
                "</s:unit><s:expandedUnc><s:uncertainty>1</s:uncertainty></s:expandedUnc></s:real></"
                "d:quantity></d:measurementResults>"
                "</d:digitalCalibrationCertificate>",
       .header = ""});
  return list;
}

/// Flips, cuts, doublings, large numbers in two to eight bytes, words in place of others.
inline std::string broken(std::string s, Random& random) {
  static const char* const words[] = {"nan",    "1e308", "-1",         "99999999999", "0",        "",
                                      ",",      ";",     "\n",         "\"",          "\xFF\xFE", "\xC3\x28",
                                      "inf",    "=",     "4294967295", "1e-320",      "()",       "Sequence",
                                      "second", "<",     "\\volt\\per"};
  for (std::uint64_t k = 1 + random.below(4); k > 0 && !s.empty(); --k) {
    const std::size_t at = random.below(s.size());
    switch (random.below(8)) {
      case 0:
        s[at] = static_cast<char>(s[at] ^ (1 << random.below(8)));
        break;
      case 1:
        s[at] = static_cast<char>(random.below(256));
        break;
      case 2:
        s.resize(at);
        break;
      case 3:
        s.erase(at, 1 + random.below(40));
        break;
      case 4:
        s.insert(at, s.substr(random.below(s.size()), 1 + random.below(60)));
        break;
      case 5:
        for (std::size_t i = at; i < std::min(at + 2 + random.below(7), s.size()); ++i)
          s[i] = static_cast<char>(random.below(2) == 0 ? 0xFF : 0x7F);
        break;
      case 6:
        s.replace(at, 1 + random.below(8), words[random.below(std::size(words))]);
        break;
      default:
        s.insert(at, words[random.below(std::size(words))]);
    }
  }
  return s;
}

/// A table in which every column has every row, or the certificate's one gain.
inline bool whole(const CsvTable& t) {
  if (t.header.size() != t.columns.size() || t.header.empty()) return false;
  for (const auto& c : t.columns)
    if (c.size() != t.rows()) return false;
  return true;
}

inline FuzzTally fuzz_foreign(std::uint64_t seed, long count) {
  const std::vector<Foreign> corpus = fuzz_corpus();
  Random random(seed);
  FuzzTally tally;
  for (; tally.count < count; ++tally.count) {
    Foreign f = corpus[random.below(corpus.size())];
    std::string& part = !f.header.empty() && random.below(2) == 0 ? f.header : f.bytes;
    part = broken(part, random);
    auto& [read, refused] = tally.read_refused[f.name];
    try {
      if (f.name == "DCC") {
        gain_of(parse_dcc(f.bytes, f.file), "N", f.file);
      } else {
        const CsvTable t = f.name == "COMTRADE"
                               ? to_table(parse_comtrade(f.header, f.bytes, "x.cfg", "x.dat"))
                           : f.header.empty() ? parse_table(f.bytes, f.file)
                                              : parse_wvf(f.header, f.bytes, "x.hdr", "x.wvf");
        if (!whole(t)) throw std::logic_error("a table with holes");
      }
      ++read;
    } catch (const BadInput& e) {
      ++refused;
      if (std::string_view(e.what()).size() < 10) tally.wrong = f.name + ": a refusal without words";
    } catch (const std::exception& e) {
      tally.wrong = fmt::format("{}: input {} of seed {}: {}", f.name, tally.count, seed, e.what());
    }
    if (!tally.wrong.empty()) break;
  }
  return tally;
}

}  // namespace powbench::host
