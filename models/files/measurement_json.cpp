// See measurement_json.h. The keys have the order in which a reader wants them.
#include "models/files/measurement_json.h"

#include "models/files/json.h"

namespace sandglass::host {

std::string measurements_json(const std::vector<Measurement>& measurements) {
  std::vector<Json> list;
  for (const Measurement& m : measurements) {
    std::vector<Json::Member> entry = {{"suite", m.suite}, {"case", m.scene}, {"metric", m.metric},  {"value", m.value},
                                       {"unit", m.unit},   {"isa", m.isa},    {"threads", m.threads}};
    if (m.judgement) {
      entry.emplace_back("truth", m.judgement->truth);
      entry.emplace_back("limit", m.judgement->limit);
      entry.emplace_back("pass", m.judgement->pass);
      if (m.judgement->control) entry.emplace_back("control", true);
    }
    list.push_back(Json::object(entry));
  }
  return Json::list(list).text() + "\n";
}

}  // namespace sandglass::host
