#include "host/config/steel_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>

#include "core/units.h"
#include "host/config/bad_input.h"
#include "host/config/csv_table.h"
#include "sim/magnetics/circuit/magnetic_circuit.h"

namespace powbench::host {
namespace {

struct HeaderUnit {
  std::string_view text;  ///< lower case
  double factor;
};
constexpr std::array h_units{HeaderUnit{"a/m", 1},       HeaderUnit{"ka/m", 1e3},
                             HeaderUnit{"a/cm", 1e2},    HeaderUnit{"oe", 1e3 / (4 * pi)},
                             HeaderUnit{"a_per_m", 1},   HeaderUnit{"ka_per_m", 1e3},
                             HeaderUnit{"a_per_cm", 1e2}};
constexpr std::array b_units{HeaderUnit{"t", 1}, HeaderUnit{"mt", 1e-3}, HeaderUnit{"g", 1e-4},
                             HeaderUnit{"kg", 0.1}};
constexpr const char* h_list = "A/m, kA/m, A/cm, Oe";
constexpr const char* b_list = "T, mT, G, kG";

struct BhColumn {
  char quantity = 0;  ///< H, B, J; 0: another one
  double factor = 0;  ///< 0: no known unit
  std::string unit;   ///< as written
};

std::string lower(std::string_view word) {
  std::string out;
  for (const char c : word)
    if (c != ' ') out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

char quantity_of(const std::string& name) {
  for (const char* word : {"h", "field", "fieldstrength", "magneticfield", "magneticfieldstrength"})
    if (name == word) return 'H';
  for (const char* word : {"b", "fluxdensity", "magneticfluxdensity", "induction"})
    if (name == word) return 'B';
  for (const char* word :
       {"j", "polarisation", "polarization", "magneticpolarisation", "magneticpolarization"})
    if (name == word) return 'J';
  return 0;
}

/// `name (unit)`, `name [unit]`, `name / unit`, `name_unit`, `name in unit` apart.
BhColumn parse_cell(const std::string& cell) {
  BhColumn c;
  std::string name = cell;
  if (const auto open = cell.find_first_of("([{"); open != std::string::npos) {
    name = cell.substr(0, open);
    if (const auto end = name.find_last_not_of(" /"); end != std::string::npos) name.resize(end + 1);
    c.unit = cell.substr(open + 1, cell.find_last_of(")]}") - open - 1);
  } else if (const auto over = cell.find(" / "); over != std::string::npos) {
    name = cell.substr(0, over);
    c.unit = cell.substr(over + 3);
  } else if (const auto in = cell.find(" in "); in != std::string::npos) {
    name = cell.substr(0, in);
    c.unit = cell.substr(in + 4);
  } else if (const auto line = cell.find('_'); line != std::string::npos) {
    name = cell.substr(0, line);
    c.unit = cell.substr(line + 1);
  }
  c.quantity = quantity_of(lower(name));
  if (c.quantity == 0) return c;
  const auto find = [&](const auto& units) {
    for (const auto& u : units)
      if (lower(c.unit) == u.text) c.factor = u.factor;
  };
  if (c.quantity == 'H')
    find(h_units);
  else
    find(b_units);
  return c;
}

class SheetReader {
 public:
  SheetReader(const std::string& file, CsvTable table) : file_(file), table_(std::move(table)) {}

  SteelSheet run() {
    find_columns();
    SteelSheet sheet;
    sheet.name = std::filesystem::path(file_).stem().string();
    sheet.notes = notes_;
    std::size_t lost = 0, lost_line = 0;
    for (std::size_t row = 0; row < table_.rows(); ++row) {
      const double h = table_.columns[h_][row] * h_factor_;
      const double b = table_.columns[b_][row] * b_factor_ + (polarised_ ? sim::mu0 * h : 0);
      if (std::isfinite(h) && std::isfinite(b)) {
        sheet.measured.push_back({b, h});
        line_.push_back(table_.line[row]);
      } else if (lost++ == 0) {
        lost_line = table_.line[row];
      }
    }
    if (lost > 0)
      sheet.notes.push_back("line " + std::to_string(lost_line) +
                            (lost > 1 ? " and " + std::to_string(lost - 1) + " more" : "") +
                            ": no number in H or B, passed over");
    if (const auto doubt = sim::doubt_units(sheet.measured, b_factor_, h_factor_); !doubt.empty())
      fail(doubt);
    try {
      sheet.fitted = sim::fit_rows(sheet.measured);
      const auto weak = sim::weak_rows(sheet.measured, sim::Steel::table(sheet.name, sheet.fitted.rows));
      if (!weak.empty()) sheet.notes.push_back(weak);
    } catch (const sim::BadRow& error) {
      throw BadInput({file_ + ":" + std::to_string(line_[error.row]) + ": " + error.what()});
    } catch (const std::invalid_argument& error) {
      fail(error.what());
    }
    return sheet;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw BadInput({file_ + ":" + std::to_string(table_.header_line) + ": columns '" + title(h_) + "' and '" +
                    title(b_) + "': " + what});
  }
  std::string title(std::size_t column) const {
    return column < table_.header.size() ? table_.header[column] : "";
  }

  void find_columns() {
    std::vector<std::string> mistakes;
    const std::string place = file_ + ":" + std::to_string(table_.header_line) + ": ";
    std::optional<std::size_t> h, b;
    for (std::size_t k = 0; k < table_.header.size(); ++k) {
      const auto c = parse_cell(table_.header[k]);
      if (c.quantity == 0) {
        notes_.push_back("column '" + table_.header[k] + "': passed over");
        continue;
      }
      const bool field = c.quantity == 'H';
      auto& found = field ? h : b;
      if (found)
        mistakes.push_back(place + "column '" + table_.header[k] + "': " +
                           (field ? "H stands here twice" : "B or J stands here twice") + "; allowed once");
      if (c.factor == 0)
        mistakes.push_back(place + "column '" + table_.header[k] + "': " +
                           (c.unit.empty() ? "has no unit; write it in brackets, as in "
                                           : "unit '" + c.unit + "' is not known, as in ") +
                           (field ? "H (A/m); allowed " : "B (T); allowed ") + (field ? h_list : b_list));
      found = k;
      (field ? h_factor_ : b_factor_) = c.factor;
      if (!field) polarised_ = c.quantity == 'J';
    }
    std::string header;
    for (const auto& cell : table_.header) header += (header.empty() ? "'" : ", '") + cell + "'";
    if (!h) mistakes.push_back(place + "no column H, as in H (A/m); the header has " + header);
    if (!b) mistakes.push_back(place + "no column B or J, as in B (T); the header has " + header);
    if (!mistakes.empty()) throw BadInput(mistakes);
    h_ = *h;
    b_ = *b;
  }

  std::string file_;
  CsvTable table_;
  std::size_t h_ = 0, b_ = 0;
  double h_factor_ = 1, b_factor_ = 1;
  bool polarised_ = false;
  std::vector<std::string> notes_;
  std::vector<std::uint32_t> line_;  ///< of each measured row
};

}  // namespace

SteelSheet parse_steel(std::string_view text, const std::string& file) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos)
    throw BadInput({file + ": is empty; a header line such as `H (A/m), B (T)` and one line a row"});
  return SheetReader(file, read_csv(text, file)).run();
}

SteelSheet read_steel(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path))
    throw BadInput({path.string() + ": is a folder; a sheet is a CSV file"});
  std::ifstream in(path, std::ios::binary);
  if (!in) throw BadInput({path.string() + ": cannot be read"});
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  return parse_steel(text, path.string());
}

bool names_steel_file(std::string_view text) {
  return text.find_first_of("./\\") != std::string_view::npos;
}

}  // namespace powbench::host
