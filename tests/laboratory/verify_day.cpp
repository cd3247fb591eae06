// `sandglass_lab verify day`: a day with a phone, in captured rooms and in drawn ones.
#include "models/rooms/panorama_file.h"
#include "models/work/progress.h"
#include "tests/laboratory/room/day_rows.h"
#include "tests/laboratory/verify.h"

namespace sandglass::host {

int verify_day_command(const VerifyOptions& options) {
  DayChoice choice = {options.cases, {}, options.seed, options.threads, options.quick};
  for (const std::string& file : panoramas_of(options, "days", {"indoor"})) choice.rooms.push_back(read_panorama(file));
  std::vector<Verdict> rows;
  {
    Progress progress("living through days", 1);
    rows = day_verdicts(choice, [&](uint64_t done, uint64_t total) {
      progress.total(total);
      progress.done(done);
      return !interrupted();
    });
  }
  return interrupted() ? k_exit_interrupted : tell(options, "day", "automatic", rows);
}

}  // namespace sandglass::host
