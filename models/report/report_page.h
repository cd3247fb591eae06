// The report of a run as a page: one HTML file that needs no network. It holds the summary, a bar a frame by stage
// against the budget, the quality levels, the pictures, and the conditions of the run. The page's own script
// (report_page.html) draws the bars from the text of report.csv, so the two cannot differ.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "models/report/report.h"

namespace sandglass::host {

using ImageFile = std::vector<uint8_t>;  // the bytes of a PNG or JPEG file

// One picture, or two of equal size that belong together, with a slider between them.
struct PageFigure {
  std::string title, caption;
  ImageFile picture;  // the left one
  ImageFile other;    // the right one; empty: a single picture, over the whole width
  std::string picture_label, other_label;
};

using PageFacts = std::vector<std::pair<std::string, std::string>>;

// The text of the page. Throws a Failure for a figure that is neither PNG nor JPEG.
std::string report_page(const RunReport& report, const std::vector<PageFigure>& figures, const PageFacts& conditions);

// This machine and the compiler, as conditions of a run.
PageFacts machine_facts();

std::string base64(const std::vector<uint8_t>& bytes);

}  // namespace sandglass::host
