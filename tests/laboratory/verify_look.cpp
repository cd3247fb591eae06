// `sandglass_lab verify look`: compares drawn sand with path traced grains.
#include "models/files/atomic_file.h"
#include "models/work/progress.h"
#include "tests/laboratory/shot/look_rows.h"
#include "tests/laboratory/verify.h"

namespace sandglass::host {

int verify_look_command(const VerifyOptions& options) {
  std::vector<Verdict> rows;
  {
    Progress progress("tracing views", 1);
    rows = verify_look({options.quick, options.picture, options.threads}, [&](size_t done, size_t all) {
      progress.total(all);
      progress.done(done);
      return !interrupted();
    });
  }
  if (interrupted()) return k_exit_interrupted;
  print_verdicts(rows);
  if (!options.plain.empty()) write_file(options.plain, jpeg_file(plain_picture(options.threads), 85));
  if (!options.json.empty())
    write_file(options.json, measurements_json(measurements_of("look", "automatic", options.threads, rows)));
  return count_failed(rows) > 0 ? k_exit_check_failed : k_exit_done;
}

}  // namespace sandglass::host
