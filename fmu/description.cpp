#include "fmu/description.h"

#include <cstdio>

#include "fmu/contactor_unit.h"

namespace powbench::fmu {
namespace {

using Causality = Variable::Causality;
using Kind = Variable::Kind;

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out + "\"";
}

std::string shortest(double v) {
  char text[40];
  for (int digits = 1; digits <= 17; ++digits) {
    std::snprintf(text, sizeof text, "%.*g", digits, v);
    double back = 0;
    if (std::sscanf(text, "%lf", &back) == 1 && back == v) break;
  }
  return text;
}

std::string attribute(const char* name, std::string_view value) {
  return std::string(" ") + name + "=" + quoted(value);
}

const char* causality_text(Causality c) {
  constexpr const char* names[] = {"independent", "parameter", "input", "output", "local"};
  return names[static_cast<std::size_t>(c)];
}

const char* variability_text(const Variable& v) {
  return v.causality == Causality::parameter ? "fixed" : v.discrete ? "discrete" : "continuous";
}

bool has_start(const Variable& v) {
  return v.causality == Causality::parameter || v.causality == Causality::input;
}

std::string start_text(const Variable& v) {
  if (v.boolean) return v.start != 0 ? "true" : "false";
  return shortest(v.start);
}

std::string units() {
  std::string out = "  <UnitDefinitions>\n";
  for (const auto& u : unit_rows()) {
    out += "    <Unit" + attribute("name", u.name) + "><BaseUnit";
    for (const auto& [name, power] :
         {std::pair{"kg", u.kg}, {"m", u.m}, {"s", u.s}, {"A", u.A}, {"K", u.K}, {"rad", u.rad}})
      if (power != 0) out += attribute(name, std::to_string(power));
    if (u.factor != 1) out += attribute("factor", shortest(u.factor));
    out += "/></Unit>\n";
  }
  return out + "  </UnitDefinitions>\n";
}

constexpr const char* categories =
    "  <LogCategories>\n"
    "    <Category name=\"logStatusError\" description=\"why a call was refused or failed\"/>\n"
    "  </LogCategories>\n";

constexpr const char* experiment =
    "  <DefaultExperiment startTime=\"0\" stopTime=\"0.06\" stepSize=\"0.0001\"/>\n";

std::string variable2(const Variable& v, std::size_t states) {
  std::string out =
      "    <ScalarVariable" + attribute("name", v.name) +
      attribute("valueReference", std::to_string(v.reference)) + attribute("description", v.description) +
      attribute("causality", causality_text(v.causality)) + attribute("variability", variability_text(v));
  if (v.causality == Causality::parameter) out += attribute("initial", "exact");
  if (v.causality == Causality::output || v.causality == Causality::local)
    out += attribute("initial", "calculated");
  out += v.boolean ? "><Boolean" : "><Real";
  if (!v.boolean) out += attribute("unit", v.unit);
  if (has_start(v)) out += attribute("start", start_text(v));
  // indices count from 1, and the table is in their order; the states stand before their derivatives
  if (v.kind == Kind::rate) out += attribute("derivative", std::to_string(v.reference + 1 - states));
  return out + "/></ScalarVariable>\n";
}

std::string variable3(const Variable& v) {
  std::string out =
      std::string("    <") + (v.boolean ? "Boolean" : "Float64") + attribute("name", v.name) +
      attribute("valueReference", std::to_string(v.reference)) + attribute("description", v.description) +
      attribute("causality", causality_text(v.causality)) + attribute("variability", variability_text(v));
  if (v.causality == Causality::output) out += attribute("initial", "calculated");
  if (v.causality == Causality::parameter) out += attribute("initial", "exact");
  if (!v.boolean) out += attribute("unit", v.unit);
  if (has_start(v)) out += attribute("start", start_text(v));
  return out + "/>\n";
}

std::string structure2(const std::vector<Variable>& all) {
  const auto list = [&](const char* name, auto&& belongs) {
    std::string out = std::string("    <") + name + ">\n";
    for (const auto& v : all)
      if (belongs(v)) out += "      <Unknown" + attribute("index", std::to_string(v.reference + 1)) + "/>\n";
    return out + "    </" + name + ">\n";
  };
  return "  <ModelStructure>\n" +
         list("Outputs", [](const Variable& v) { return v.causality == Causality::output; }) +
         list("Derivatives", [](const Variable& v) { return v.kind == Kind::rate; }) +
         list("InitialUnknowns",
              [](const Variable& v) {
                return v.causality == Causality::output || v.causality == Causality::local;
              }) +
         "  </ModelStructure>\n";
}

std::string structure3(const std::vector<Variable>& all) {
  std::string out = "  <ModelStructure>\n";
  for (const char* name : {"Output", "InitialUnknown"})
    for (const auto& v : all)
      if (v.causality == Causality::output)
        out +=
            std::string("    <") + name + attribute("valueReference", std::to_string(v.reference)) + "/>\n";
  return out + "  </ModelStructure>\n";
}

std::string head(const sim::Specimen& s, const char* fmi, const char* token_name, std::string_view token,
                 std::string_view version) {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription" + attribute("fmiVersion", fmi) +
         attribute("modelName", s.name.empty() ? "contactor" : s.name) + attribute(token_name, token) +
         attribute("description",
                   "Closing of an AC contactor: magnetic circuit and rigid bodies with located events") +
         attribute("version", version) + attribute("generationTool", "powbench " + std::string(version)) +
         attribute("variableNamingConvention", "structured");
}

}  // namespace

std::string binary_folder(Fmi fmi) {
#if defined(__x86_64__)
  return fmi == Fmi::two ? "linux64" : "x86_64-linux";
#elif defined(__aarch64__)
  return "aarch64-linux";
#else
  return fmi == Fmi::two ? "linux32" : "x86-linux";
#endif
}

std::string model_description(const sim::Specimen& s, Fmi fmi, std::string_view token,
                              std::string_view version) {
  const auto all = variables(s, fmi);
  const std::string identifier = attribute("modelIdentifier", model_identifier);
  std::string out;
  if (fmi == Fmi::two) {
    out = head(s, "2.0", "guid", token, version) +
          attribute("numberOfEventIndicators", std::to_string(indicator_count(s))) + ">\n";
    out += "  <ModelExchange" + identifier + attribute("canGetAndSetFMUstate", "true") + "/>\n";
    out += "  <CoSimulation" + identifier + attribute("canHandleVariableCommunicationStepSize", "true") +
           attribute("canInterpolateInputs", "true") + attribute("canGetAndSetFMUstate", "true") + "/>\n";
  } else {
    out = head(s, "3.0", "instantiationToken", token, version) + ">\n";
    out += "  <CoSimulation" + identifier + attribute("canGetAndSetFMUState", "true") +
           attribute("canHandleVariableCommunicationStepSize", "true") + attribute("hasEventMode", "true") +
           "/>\n";
  }
  out += units();
  out += std::string(categories) + experiment + "  <ModelVariables>\n";
  const std::size_t states = fmi == Fmi::two ? state_names(s).size() : 0;
  for (const auto& v : all) out += fmi == Fmi::two ? variable2(v, states) : variable3(v);
  out += "  </ModelVariables>\n" + (fmi == Fmi::two ? structure2(all) : structure3(all));
  return out + "</fmiModelDescription>\n";
}

}  // namespace powbench::fmu
