#include <catch2/catch.hpp>
#include <set>

#include "tests/fmu/importer.h"
#include "tests/fmu/specimens.h"

using namespace powbench;
using namespace powbench::test;

namespace {

struct Parsed {
  explicit Parsed(const std::string& text) { REQUIRE(document.load_string(text.c_str())); }
  pugi::xml_node root() const { return document.document_element(); }
  pugi::xml_document document;
};

std::set<std::string> units_of(pugi::xml_node root) {
  std::set<std::string> names;
  for (const auto& u : root.child("UnitDefinitions").children())
    CHECK(names.insert(u.attribute("name").value()).second);
  return names;
}

bool has(pugi::xml_node node, const char* name) {
  return !node.attribute(name).empty();
}

}  // namespace

TEST_CASE("the description of FMI 2.0 keeps the rules of the standard") {
  for (const auto& [name, specimen] : kinds_of_contactor()) {
    INFO(name);
    sim::Specimen s = specimen;
    s.name = "a \"quoted\" <name> & more";
    const Parsed parsed(fmu::model_description(s, fmu::Fmi::two, "{x}", "1"));
    const auto root = parsed.root();
    CHECK(std::string(root.name()) == "fmiModelDescription");
    CHECK(std::string(root.attribute("fmiVersion").value()) == "2.0");
    CHECK(root.attribute("modelName").value() == s.name);
    std::vector<std::string> order;
    for (const auto& child : root.children()) order.emplace_back(child.name());
    CHECK(order == std::vector<std::string>{"ModelExchange", "CoSimulation", "UnitDefinitions",
                                            "LogCategories", "DefaultExperiment", "ModelVariables",
                                            "ModelStructure"});
    const auto units = units_of(root);
    std::set<std::string> names, references;
    std::set<unsigned> outputs, derivatives, calculated;
    std::vector<pugi::xml_node> variables;
    for (const auto& v : root.child("ModelVariables").children()) variables.push_back(v);
    unsigned index = 0;
    for (const auto& v : variables) {
      ++index;
      INFO(v.attribute("name").value());
      CHECK(names.insert(v.attribute("name").value()).second);
      CHECK(references.insert(v.attribute("valueReference").value()).second);
      const std::string causality = v.attribute("causality").value(),
                        initial = v.attribute("initial").value(),
                        variability = v.attribute("variability").value();
      const auto type = v.first_child();
      const bool real = std::string(type.name()) == "Real";
      CHECK((real || std::string(type.name()) == "Boolean"));
      if (real) CHECK(units.count(type.attribute("unit").value()) == 1);
      CHECK((real || variability == "discrete"));
      const bool needs_start = causality == "input" || initial == "exact" || initial == "approx";
      CHECK(has(type, "start") == needs_start);
      if (causality == "parameter") CHECK((variability == "fixed" && initial == "exact"));
      if (causality == "input" || causality == "independent") CHECK(initial.empty());
      if (causality == "output") outputs.insert(index);
      if (initial == "calculated") calculated.insert(index);
      if (!has(type, "derivative")) continue;
      derivatives.insert(index);
      const auto& state = variables.at(type.attribute("derivative").as_uint() - 1);
      CHECK(v.attribute("name").value() == "der(" + std::string(state.attribute("name").value()) + ")");
    }
    const auto listed = [&](const char* part) {
      std::set<unsigned> out;
      for (const auto& u : root.child("ModelStructure").child(part).children())
        out.insert(u.attribute("index").as_uint());
      return out;
    };
    CHECK(listed("Outputs") == outputs);
    CHECK(listed("Derivatives") == derivatives);
    CHECK(listed("InitialUnknowns") == calculated);

    // what the library has is what the description says
    const Unpacked files(specimen, fmu::Fmi::two);
    Unit2 u(files, fmu::fmi2::model_exchange);
    u.start();
    std::vector<double> x(files.states), z(files.indicators);
    CHECK(u.call("fmi2GetContinuousStates", x.data(), x.size()) == 0);
    CHECK(u.call("fmi2GetContinuousStates", x.data(), x.size() + 1) != 0);
    CHECK(u.call("fmi2GetEventIndicators", z.data(), z.size()) == 0);
    CHECK(u.call("fmi2GetNominalsOfContinuousStates", x.data(), x.size()) == 0);
    for (const double nominal : x) CHECK(nominal > 0);
    for (const auto& v : variables) {
      const std::string variable = v.attribute("name").value();
      if (std::string(v.first_child().name()) == "Real")
        CHECK(std::isfinite(u.get(variable)));
      else
        u.is(variable);
      if (has(v.first_child(), "start") && std::string(v.first_child().name()) == "Real")
        CHECK(u.get(variable) == v.first_child().attribute("start").as_double());
    }
  }
}

TEST_CASE("the description of FMI 3.0 keeps the rules of the standard") {
  const Parsed parsed(fmu::model_description({}, fmu::Fmi::three, "{x}", "1"));
  const auto root = parsed.root();
  CHECK(std::string(root.attribute("fmiVersion").value()) == "3.0");
  CHECK(root.child("ModelExchange").empty());
  CHECK(root.child("CoSimulation").attribute("hasEventMode").as_bool());
  const auto units = units_of(root);
  std::set<std::string> names, references, outputs, listed, initial;
  bool independent = false;
  for (const auto& v : root.child("ModelVariables").children()) {
    CHECK(names.insert(v.attribute("name").value()).second);
    CHECK(references.insert(v.attribute("valueReference").value()).second);
    const std::string causality = v.attribute("causality").value();
    independent = independent || causality == "independent";
    if (std::string(v.name()) == "Float64") CHECK(units.count(v.attribute("unit").value()) == 1);
    CHECK(has(v, "start") == (causality == "input" || causality == "parameter"));
    if (causality == "output") outputs.insert(v.attribute("valueReference").value());
  }
  CHECK(independent);
  for (const auto& u : root.child("ModelStructure").children())
    (std::string(u.name()) == "Output" ? listed : initial).insert(u.attribute("valueReference").value());
  CHECK(listed == outputs);
  CHECK(initial == outputs);
}
