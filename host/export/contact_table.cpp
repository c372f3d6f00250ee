#include "host/export/contact_table.h"

#include "core/channels.h"
#include "host/store/json.h"

namespace powbench::host {

Table contact_table(const std::vector<std::pair<std::int64_t, Events>>& shots) {
  std::vector<std::int64_t> shot, contact;
  std::vector<std::string> channel, flags;
  std::vector<double> probability;
  struct Numbers {
    const char* name;
    Measured Contact::*of;
    std::vector<double> value, u;
  };
  std::vector<Numbers> numbers{{"touch_s", &Contact::touch, {}, {}},
                               {"release_s", &Contact::release, {}, {}},
                               {"peak_N", &Contact::peak, {}, {}},
                               {"impulse_N_s", &Contact::impulse, {}, {}}};
  for (const auto& [id, events] : shots) {
    const auto add = [&, id = id](Channel of, const ContactTrain& train) {
      std::int64_t k = 0;
      for (const Contact& c : train.contacts) {
        shot.push_back(id), channel.emplace_back(info(of).name), contact.push_back(++k);
        for (Numbers& n : numbers) n.value.push_back((c.*n.of).value), n.u.push_back((c.*n.of).u);
        probability.push_back(c.probability), flags.push_back(flag_names(c.flags));
      }
    };
    add(Channel::contact_a, events.contact_voltage);
    add(Channel::pvdf_a, events.pvdf_a);
    add(Channel::pvdf_b, events.pvdf_b);
  }
  Table t{{"shot", shot}, {"channel", channel}, {"contact", contact}};
  for (const Numbers& n : numbers)
    t.push_back({n.name, n.value}), t.push_back({std::string("u_") + n.name, n.u});
  t.push_back({"probability", probability}), t.push_back({"flags", flags});
  return t;
}

}  // namespace powbench::host
