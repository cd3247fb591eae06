// Fills the template of the page. Text is escaped here, once; everything else is in the template.
#include "models/report/report_page.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string_view>
#include <thread>

#include "models/files/failure.h"

namespace sandglass::host {

extern const char k_report_page_template[];  // report_page.html, put into the program by the build

namespace {

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text)
    if (c == '&') out += "&amp;";
    else if (c == '<') out += "&lt;";
    else if (c == '>') out += "&gt;";
    else if (c == '"') out += "&quot;";
    else out += c;
  return out;
}

std::string image_html(const ImageFile& file, const std::string& title, const char* attributes = "") {
  const auto begins = [&](std::string_view signature) {
    return file.size() >= signature.size() &&
           std::equal(signature.begin(), signature.end(), file.begin(),
                      [](char a, uint8_t b) { return static_cast<uint8_t>(a) == b; });
  };
  const char* type = begins("\x89PNG") ? "png" : begins("\xff\xd8\xff") ? "jpeg" : nullptr;
  if (type == nullptr) throw cannot("show", title, "the figure is neither a PNG nor a JPEG file", "Write it as one");
  return "<img" + std::string(attributes) + " alt=\"" + title + "\" src=\"data:image/" + type + ";base64," +
         base64(file) + "\">";
}

std::string figure_html(const PageFigure& figure) {
  const std::string title = escaped(figure.title), left = escaped(figure.picture_label),
                    right = escaped(figure.other_label);
  std::string html = figure.other.empty()
                         ? "<figure class=\"wide\">" + image_html(figure.picture, title)
                         : "<figure><div class=\"compare\">" + image_html(figure.other, title + ": " + right) +
                               image_html(figure.picture, title + ": " + left, " class=\"before\"");
  if (!figure.other.empty())
    html += "<span>" + left + "</span><span class=\"right\">" + right + "</span><input type=\"range\" step=\"0.5\" " +
            "aria-label=\"" + title + ": how much of '" + left + "' is seen beside '" + right + "'\"></div>";
  return html + "<figcaption><b>" + title + "</b> " + escaped(figure.caption) + "</figcaption></figure>\n";
}

std::string level_names() {
  std::string names;
  for (uint32_t level = 0; level < SANDGLASS_LEVEL_COUNT; ++level)
    names += (level == 0 ? "" : "|") + escaped(level_text(level));
  return names;
}

std::string estimate_data(const PhoneEstimate& e) {
  if (e.core.empty()) return "";
  char data[96];
  std::snprintf(data, sizeof data, " data-fastest=\"%g\" data-slowest=\"%g\"", e.low, e.high);
  return data;
}

}  // namespace

std::string base64(const std::vector<uint8_t>& bytes) {
  constexpr char k_letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t left = bytes.size() - i;
    const uint32_t word = static_cast<uint32_t>(bytes[i]) << 16 |
                          (left > 1 ? static_cast<uint32_t>(bytes[i + 1]) << 8 : 0u) | (left > 2 ? bytes[i + 2] : 0u);
    text += k_letters[word >> 18];
    text += k_letters[word >> 12 & 63];
    text += left > 1 ? k_letters[word >> 6 & 63] : '=';
    text += left > 2 ? k_letters[word & 63] : '=';
  }
  return text;
}

PageFacts machine_facts() {
  PageFacts facts;
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; facts.empty() && std::getline(info, line);)
    if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos)
      facts.emplace_back("processor", line.substr(line.find(": ") + 2));
  facts.emplace_back("hardware threads", std::to_string(std::thread::hardware_concurrency()));
#if defined(__clang__)
  facts.emplace_back("compiler", "clang " __clang_version__);
#elif defined(__GNUC__)
  facts.emplace_back("compiler", "g++ " __VERSION__);
#endif
  return facts;
}

std::string report_page(const RunReport& report, const std::vector<PageFigure>& figures, const PageFacts& conditions) {
  std::string pictures, facts;
  for (const PageFigure& figure : figures) pictures += figure_html(figure);
  for (const auto& [name, value] : conditions)
    facts += "<tr><td>" + escaped(name) + "</td><td>" + escaped(value) + "</td></tr>\n";
  const std::string title = escaped(report.scene);
  // From the last to the first: no name is looked for in what was put in.
  const std::pair<std::string_view, std::string> parts[] = {{"@CSV@", report_csv(report)},
                                                            {"@CONDITIONS@", facts},
                                                            {"@PICTURES@", pictures},
                                                            {"@ESTIMATE@", estimate_data(report.estimate)},
                                                            {"@LEVELS@", level_names()},
                                                            {"@SUMMARY@", escaped(report_summary_text(report))},
                                                            {"@TITLE@", title},
                                                            {"@TITLE@", title}};
  std::string page = k_report_page_template;
  size_t at = page.size();
  for (const auto& [name, content] : parts) {
    at = page.rfind(name, at - 1);
    page.replace(at, name.size(), content);
  }
  return page;
}

}  // namespace sandglass::host
