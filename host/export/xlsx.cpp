#include <fmt/format.h>
#include <zlib.h>

#include <cmath>
#include <iterator>

#include "host/config/bad_input.h"
#include "host/export/event_table.h"
#include "host/export/xml_text.h"

namespace powbench::host {
namespace {

constexpr std::size_t most_rows = 1'048'576, most_columns = 16'384;

void put(std::string& to, std::uint32_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) to += static_cast<char>(value >> (8 * i));
}

std::string deflated(const std::string& text) {
  z_stream z{};
  if (deflateInit2(&z, 6, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw BadInput({"no memory to compress a sheet"});
  std::string out(deflateBound(&z, text.size()), '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  z.avail_in = static_cast<uInt>(text.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

/// The container: deflated files, then their directory. No time is kept, so that equal content makes equal bytes.
class Zip {
 public:
  void add(const std::string& name, const std::string& text) {
    const std::string packed = deflated(text);
    std::string head;
    put(head, 20, 2), put(head, 0, 2), put(head, 8, 2), put(head, 0, 2), put(head, 0x21, 2);  // 1980-01-01
    put(head,
        static_cast<std::uint32_t>(
            crc32(0, reinterpret_cast<const Bytef*>(text.data()), static_cast<uInt>(text.size()))),
        4);
    put(head, static_cast<std::uint32_t>(packed.size()), 4),
        put(head, static_cast<std::uint32_t>(text.size()), 4);
    put(head, static_cast<std::uint32_t>(name.size()), 2), put(head, 0, 2);
    put(directory_, 0x02014B50, 4), put(directory_, 20, 2);
    directory_ += head;
    put(directory_, 0, 2), put(directory_, 0, 2), put(directory_, 0, 2), put(directory_, 0, 4);
    put(directory_, static_cast<std::uint32_t>(bytes_.size()), 4);
    directory_ += name;
    put(bytes_, 0x04034B50, 4);
    bytes_ += head + name + packed;
    ++files_;
  }
  std::string finish() {
    std::string end;
    put(end, 0x06054B50, 4), put(end, 0, 4), put(end, files_, 2), put(end, files_, 2);
    put(end, static_cast<std::uint32_t>(directory_.size()), 4),
        put(end, static_cast<std::uint32_t>(bytes_.size()), 4), put(end, 0, 2);
    return bytes_ + directory_ + end;
  }

 private:
  std::string bytes_, directory_;
  std::uint32_t files_ = 0;
};

std::string text_cell(const std::string& text) {
  return "<c t=\"inlineStr\"><is><t xml:space=\"preserve\">" + escaped(text) + "</t></is></c>";
}

struct CellOf {
  std::size_t row;
  std::string operator()(const std::vector<std::int64_t>& v) const {
    return fmt::format("<c><v>{}</v></c>", v[row]);
  }
  std::string operator()(const std::vector<double>& v) const {
    return std::isfinite(v[row]) ? fmt::format("<c><v>{}</v></c>", v[row])
                                 : "<c/>";  // the shortest text of this double
  }
  std::string operator()(const std::vector<std::string>& v) const { return text_cell(v[row]); }
};

constexpr const char* xml = "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\"?>\n";
constexpr const char* office = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
constexpr const char* main_ns = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
constexpr const char* package = "http://schemas.openxmlformats.org/package/2006";

std::string sheet_xml(const Sheet& sheet) {
  const std::size_t n = rows(sheet.table);
  if (n + 1 > most_rows || sheet.table.size() > most_columns)
    throw BadInput({fmt::format("sheet '{}': {} rows and {} columns; Excel takes {} and {}: use csv or nc",
                                sheet.name, n, sheet.table.size(), most_rows - 1, most_columns)});
  std::string out = fmt::format(
      "{}<worksheet xmlns=\"{}\"><sheetViews><sheetView workbookViewId=\"0\"><pane ySplit=\"1\" "
      "topLeftCell=\"A2\" state=\"frozen\"/></sheetView></sheetViews><sheetData><row>",
      xml, main_ns);
  for (const TableColumn& c : sheet.table) out += text_cell(c.name);
  out += "</row>";
  for (std::size_t i = 0; i < n; ++i) {
    out += "<row>";
    for (const TableColumn& c : sheet.table) out += std::visit(CellOf{i}, c.values);
    out += "</row>";
  }
  return out + "</sheetData></worksheet>";
}

}  // namespace

std::string to_xlsx(const std::vector<Sheet>& sheets) {
  Zip zip;
  std::string types = fmt::format(
      "{}<Types xmlns=\"{}/content-types\"><Default Extension=\"rels\" ContentType=\"application/vnd."
      "openxmlformats-package.relationships+xml\"/><Default Extension=\"xml\" "
      "ContentType=\"application/xml\"/>"
      "<Override PartName=\"/xl/workbook.xml\" ContentType=\"application/vnd.openxmlformats-officedocument."
      "spreadsheetml.sheet.main+xml\"/>",
      xml, package);
  std::string book =
      fmt::format("{}<workbook xmlns=\"{}\" xmlns:r=\"{}\"><bookViews><workbookView/></bookViews><sheets>",
                  xml, main_ns, office);
  std::string links = fmt::format("{}<Relationships xmlns=\"{}/relationships\">", xml, package);
  for (std::size_t i = 1; i <= sheets.size(); ++i) {
    types += fmt::format(
        "<Override PartName=\"/xl/worksheets/sheet{}.xml\" "
        "ContentType=\"application/vnd.openxmlformats-officedocument."
        "spreadsheetml.worksheet+xml\"/>",
        i);
    book +=
        fmt::format("<sheet name=\"{}\" sheetId=\"{}\" r:id=\"rId{}\"/>", escaped(sheets[i - 1].name), i, i);
    links += fmt::format(
        "<Relationship Id=\"rId{}\" Type=\"{}/worksheet\" Target=\"worksheets/sheet{}.xml\"/>", i, office, i);
  }
  zip.add("[Content_Types].xml", types + "</Types>");
  zip.add(
      "_rels/.rels",
      fmt::format(
          "{}<Relationships xmlns=\"{}/relationships\"><Relationship Id=\"rId1\" Type=\"{}/officeDocument\" "
          "Target=\"xl/workbook.xml\"/></Relationships>",
          xml, package, office));
  zip.add("xl/workbook.xml", book + "</sheets></workbook>");
  zip.add("xl/_rels/workbook.xml.rels", links + "</Relationships>");
  for (std::size_t i = 0; i < sheets.size(); ++i)
    zip.add(fmt::format("xl/worksheets/sheet{}.xml", i + 1), sheet_xml(sheets[i]));
  return zip.finish();
}

}  // namespace powbench::host
