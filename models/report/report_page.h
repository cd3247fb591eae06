// The report of a run as a page: one HTML file that needs no network. It holds the pictures, charts of the frames'
// times against the budget, of quality, of the quality ladder and of the light, and the numbers behind them as JSON.
// The page's own script (report_page.html) draws the charts from the rows of report.csv, so the two cannot differ.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "models/report/report.h"

namespace sandglass::host {

using ImageFile = std::vector<uint8_t>;  // the bytes of a PNG or JPEG file

// One picture, or two of equal size that belong together, with a slider between them.
struct PageFigure {
  std::string title, caption;
  ImageFile picture;  // the left one
  ImageFile other;    // the right one; empty: a single picture
  std::string picture_label, other_label;
  bool wide = false;  // takes the whole width of the page
};

struct PageTable {
  std::string title, caption;
  std::vector<std::string> head;  // empty: a list of facts in two columns
  std::vector<std::vector<std::string>> rows;
};

struct LightSample {
  double time = 0.0;                     // seconds
  std::array<double, 3> direction = {};  // towards the light, world; any length above 0
  std::array<double, 3> colour = {-1, 0, 0},
                        ambient = {-1, 0, 0};  // linear RGB, 0..1; a first value below 0: not known
};
struct LightSeries {
  std::string name;  // for example "labels"
  std::vector<LightSample> samples;
};

struct PageContent {
  std::string title;  // empty: the scene's name
  std::vector<PageFigure> figures;
  std::vector<PageTable> tables;
  std::vector<LightSeries> light;  // drawn beside the light of the report's rows, for example the true light
};

// The numbers behind the page, as a script element holds them.
std::string report_page_data(const RunReport& report, const PageContent& content);

// The text of the page. Throws a Failure for a figure that is neither PNG nor JPEG.
std::string report_page(const RunReport& report, const PageContent& content);

// Facts about this machine and the compiler, as rows for a table.
std::vector<std::vector<std::string>> machine_facts();

std::string base64(const std::vector<uint8_t>& bytes);

}  // namespace sandglass::host
