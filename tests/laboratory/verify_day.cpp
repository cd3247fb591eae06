// `sandglass_lab verify day`: a day with a phone, in captured rooms and in drawn ones.
#include "models/rooms/panorama_file.h"
#include "tests/laboratory/room/day_rows.h"
#include "tests/laboratory/verify.h"

namespace sandglass::host {

namespace {

Options options_of(VerifyOptions& o) {
  return {panoramas_option(o),
          cases_option(o, "Only these", day_cases()),
          {"--quick", &o.quick, "", "One seed instead of three"},
          seed_option(o.seed, "Lamps, rooms and ways of looking; the two after it are taken too"),
          threads_option(o.threads),
          json_option(o.json)};
}

int run(const VerifyOptions& options) {
  DayChoice choice = {options.cases, {}, options.seed, options.threads, options.quick};
  for (const std::string& file : panoramas_of(options, "days", {"indoor"})) choice.rooms.push_back(read_panorama(file));
  const auto rows =
      with_progress("living through days", [&](const auto& go_on) { return day_verdicts(choice, go_on); });
  return interrupted() ? k_exit_interrupted : tell(options, "day", "automatic", rows);
}

}  // namespace

Command verify_day_suite() {
  return command<VerifyOptions>("day", "A day with a phone: light that changes, covered lenses, lamps, doors",
                                options_of, run);
}

}  // namespace sandglass::host
