// Writes measurements with nlohmann-json. The keys keep the order in which a reader wants them.
#include "models/files/measurement_json.h"

#include <nlohmann/json.hpp>

namespace sandglass::host {

std::string measurements_json(const std::vector<Measurement>& measurements) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Measurement& m : measurements) {
    nlohmann::ordered_json entry = {{"suite", m.suite}, {"case", m.scene}, {"metric", m.metric},  {"value", m.value},
                                    {"unit", m.unit},   {"isa", m.isa},    {"threads", m.threads}};
    if (m.judgement) {
      entry["truth"] = m.judgement->truth;
      entry["limit"] = m.judgement->limit;
      entry["pass"] = m.judgement->pass;
      if (m.judgement->control) entry["control"] = true;
    }
    list.push_back(std::move(entry));
  }
  return list.dump(1) + "\n";
}

}  // namespace sandglass::host
