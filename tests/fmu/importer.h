#pragma once

#include <dlfcn.h>

#include <map>
#include <pugixml.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "fmu/description.h"
#include "fmu/fmi2.h"
#include "fmu/fmi3.h"
#include "fmu/resource.h"
#include "tests/folder.h"
#include "tests/places.h"

/// A small importer: loads the library as a simulator does and finds the variables in the model description.

namespace powbench::test {

/// The library of the build, loaded once.
inline void* fmu_symbol(const char* name) {
  static void* const library =
      dlopen((test::build_dir() + "/fmu/powbench_contactor.so").c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) throw std::runtime_error(dlerror());
  void* found = dlsym(library, name);
  if (found == nullptr) throw std::runtime_error(std::string(name) + " is not exported");
  return found;
}

/// A unit unpacked: its resources on disk and what its description says.
class Unpacked {
 public:
  Unpacked(const sim::Specimen& s, fmu::Fmi fmi) {
    const std::string text = fmu::resource_text(s, "test");
    resources_.write(fmu::resource_name, text);
    description = fmu::model_description(s, fmi, fmu::token_of(text), "test");
    pugi::xml_document document;
    if (!document.load_string(description.c_str())) throw std::runtime_error("the description is not XML");
    const auto root = document.document_element();
    token = root.attribute(fmi == fmu::Fmi::two ? "guid" : "instantiationToken").value();
    indicators = root.attribute("numberOfEventIndicators").as_uint();
    for (const auto& v : root.child("ModelVariables").children())
      references[v.attribute("name").value()] = v.attribute("valueReference").as_uint();
    for (const auto& u : root.child("ModelStructure").child("Derivatives").children())
      states += u.name()[0] == 'U';
  }
  std::string folder() const { return resources_.file(""); }
  std::string uri() const { return "file://" + folder(); }

  std::string description, token;
  std::size_t states = 0, indicators = 0;
  std::map<std::string, unsigned> references;

 private:
  Folder resources_;
};

inline int logged = 0;
inline void count_message(void*, const char*, fmu::fmi2::Status, const char*, const char*, ...) {
  ++logged;
}
inline void count_message3(void*, fmu::fmi3::Status, const char*, const char*) {
  ++logged;
}

/// One instance by FMI 2.0. Every call goes through the library's own symbols.
class Unit2 {
 public:
  Unit2(const Unpacked& u, fmu::fmi2::Type type) : u_(&u) {
    const fmu::fmi2::Callbacks callbacks{count_message, nullptr, nullptr, nullptr, nullptr};
    using Make = void* (*)(const char*, fmu::fmi2::Type, const char*, const char*,
                           const fmu::fmi2::Callbacks*, int, int);
    c = reinterpret_cast<Make>(fmu_symbol("fmi2Instantiate"))("one", type, u.token.c_str(), u.uri().c_str(),
                                                              &callbacks, 0, 1);
  }
  ~Unit2() { reinterpret_cast<void (*)(void*)>(fmu_symbol("fmi2FreeInstance"))(c); }
  Unit2(const Unit2&) = delete;
  Unit2& operator=(const Unit2&) = delete;

  template <class... Args>
  int call(const char* name, Args... args) {
    return reinterpret_cast<int (*)(void*, Args...)>(fmu_symbol(name))(c, args...);
  }
  unsigned reference(const std::string& name) const { return u_->references.at(name); }
  void set(const std::string& name, double value) {
    const unsigned vr = reference(name);
    const double v = value;
    if (call("fmi2SetReal", &vr, std::size_t{1}, &v) != 0) throw std::runtime_error(name + " was refused");
  }
  double get(const std::string& name) {
    const unsigned vr = reference(name);
    double v = 0;
    if (call("fmi2GetReal", &vr, std::size_t{1}, &v) != 0) throw std::runtime_error(name + " was refused");
    return v;
  }
  bool is(const std::string& name) {
    const unsigned vr = reference(name);
    int v = 0;
    if (call("fmi2GetBoolean", &vr, std::size_t{1}, &v) != 0) throw std::runtime_error(name + " was refused");
    return v != 0;
  }
  void start(double from = 0) {
    if (call("fmi2SetupExperiment", 0, 0.0, from, 0, 0.0) != 0 || call("fmi2EnterInitializationMode") != 0 ||
        call("fmi2ExitInitializationMode") != 0)
      throw std::runtime_error("initialization was refused");
  }
  int step(double t, double h) { return call("fmi2DoStep", t, h, 1); }

  void* c = nullptr;

 private:
  const Unpacked* u_;
};

/// One instance by FMI 3.0.
class Unit3 {
 public:
  Unit3(const Unpacked& u, bool event_mode, bool early) : u_(&u) {
    using Make = void* (*)(const char*, const char*, const char*, bool, bool, bool, bool, const unsigned*,
                           std::size_t, void*, fmu::fmi3::Logger, fmu::fmi3::IntermediateUpdate);
    c = reinterpret_cast<Make>(fmu_symbol("fmi3InstantiateCoSimulation"))(
        "one", u.token.c_str(), u.folder().c_str(), false, true, event_mode, early, nullptr, 0, nullptr,
        count_message3, nullptr);
  }
  ~Unit3() { reinterpret_cast<void (*)(void*)>(fmu_symbol("fmi3FreeInstance"))(c); }
  Unit3(const Unit3&) = delete;
  Unit3& operator=(const Unit3&) = delete;

  template <class... Args>
  int call(const char* name, Args... args) {
    return reinterpret_cast<int (*)(void*, Args...)>(fmu_symbol(name))(c, args...);
  }
  void set(const std::string& name, double value) {
    const unsigned vr = u_->references.at(name);
    const double v = value;
    if (call("fmi3SetFloat64", &vr, std::size_t{1}, &v, std::size_t{1}) != 0)
      throw std::runtime_error(name + " was refused");
  }
  double get(const std::string& name) {
    const unsigned vr = u_->references.at(name);
    double v = 0;
    if (call("fmi3GetFloat64", &vr, std::size_t{1}, &v, std::size_t{1}) != 0)
      throw std::runtime_error(name + " was refused");
    return v;
  }
  bool is(const std::string& name) {
    const unsigned vr = u_->references.at(name);
    bool v = false;
    if (call("fmi3GetBoolean", &vr, std::size_t{1}, &v, std::size_t{1}) != 0)
      throw std::runtime_error(name + " was refused");
    return v;
  }
  void start() {
    if (call("fmi3EnterInitializationMode", false, 0.0, 0.0, false, 0.0) != 0 ||
        call("fmi3ExitInitializationMode") != 0)
      throw std::runtime_error("initialization was refused");
  }
  struct Step {
    int status = 0;
    bool event = false, terminate = false, early = false;
    double reached = 0;
  };
  Step step(double t, double h) {
    Step s;
    s.status = call("fmi3DoStep", t, h, true, &s.event, &s.terminate, &s.early, &s.reached);
    return s;
  }
  /// Event mode and back: what an importer does after a step that asks for it.
  int update() {
    bool b[5] = {};
    double next = 0;
    return call("fmi3UpdateDiscreteStates", &b[0], &b[1], &b[2], &b[3], &b[4], &next);
  }

  void* c = nullptr;

 private:
  const Unpacked* u_;
};

}  // namespace powbench::test
