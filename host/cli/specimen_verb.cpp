#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/cli/solenoid_verb.h"
#include "host/cli/specimen_verb.h"
#include "host/config/solenoid_file.h"
#include "host/config/specimen_file.h"
#include "host/study/specimen_facts.h"
#include "sim/mechanics/contact_damping.h"

namespace powbench::host {

Exit describe_specimen(const SpecimenArgs& args) {
  if (is_solenoid_file(args.file)) return describe_solenoid(args);
  const sim::Specimen s = args.file.empty() ? sim::Specimen{} : read_specimen(args.file);
  Conditions rated;
  rated.supply_volts = args.volts.value_or(230);
  rated.mains_hertz = args.hertz.value_or(50);
  const auto facts = specimen_facts(s, rated);
  fmt::print("{}", args.json ? facts_json(s, facts) : facts_text(s, rated, facts));
  return Exit::pass;
}

Exit convert_specimen(const SpecimenArgs& args) {
  const sim::Specimen former = read_specimen(args.file);
  fmt::print("{}", resolved_text(sim::with_rebounds(former)));
  fmt::print(stderr,
             "{}: stop_restitution, contact_restitution and seat_damping converted; the closings stay as "
             "they were\n",
             args.file);
  return Exit::pass;
}

}  // namespace powbench::host
