// See measurement_json.h. The keys have the order in which a reader wants them.
#include "models/files/measurement_json.h"

#include "models/files/json.h"

namespace sandglass::host {

std::string measurements_json(const std::vector<Measurement>& measurements) {
  Json list = Json::array();
  for (const Measurement& m : measurements) {
    Json entry = {{"suite", m.suite}, {"case", m.scene}, {"metric", m.metric},  {"value", m.value},
                  {"unit", m.unit},   {"isa", m.isa},    {"threads", m.threads}};
    if (m.judgement) {
      entry["truth"] = m.judgement->truth;
      entry["limit"] = m.judgement->limit;
      entry["pass"] = m.judgement->pass;
      if (m.judgement->control) entry["control"] = true;
    }
    list.push_back(std::move(entry));
  }
  return text_of(list);
}

}  // namespace sandglass::host
