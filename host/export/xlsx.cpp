#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "host/config/bad_input.h"
#include "host/export/event_table.h"
#include "host/export/xml_text.h"
#include "host/export/zip.h"

namespace powbench::host {
namespace {

constexpr std::size_t most_rows = 1'048'576, most_columns = 16'384;

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
