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

std::string image_url(const ImageFile& file, const std::string& title) {
  constexpr uint8_t k_png[] = {0x89, 'P', 'N', 'G'}, k_jpeg[] = {0xff, 0xd8, 0xff};
  const auto begins = [&](const auto& signature) {
    return file.size() >= std::size(signature) && std::equal(std::begin(signature), std::end(signature), file.begin());
  };
  const char* type = begins(k_png) ? "png" : begins(k_jpeg) ? "jpeg" : nullptr;
  if (type == nullptr) throw cannot("show", title, "the figure is neither a PNG nor a JPEG file", "Write it as one");
  return std::string("data:image/") + type + ";base64," + base64(file);
}

std::string figure_html(const PageFigure& figure) {
  const std::string title = escaped(figure.title), left = escaped(figure.picture_label),
                    right = escaped(figure.other_label);
  std::string html = figure.wide ? "<figure class=\"wide\">" : "<figure>";
  if (figure.other.empty()) {
    html += "<img alt=\"" + title + "\" src=\"" + image_url(figure.picture, figure.title) + "\">";
  } else {
    html += "<div class=\"compare\"><img class=\"after\" alt=\"" + title + ": " + right + "\" src=\"" +
            image_url(figure.other, figure.title) + "\"><img class=\"before\" alt=\"" + title + ": " + left +
            "\" src=\"" + image_url(figure.picture, figure.title) + "\"><span class=\"tag left\">" + left +
            "</span><span class=\"tag right\">" + right + "</span><span class=\"knob\" aria-hidden=\"true\">&#8596;" +
            "</span><input type=\"range\" min=\"0\" max=\"100\" step=\"0.5\" value=\"50\" data-before=\"" + left +
            "\" aria-label=\"" + title + ": how much of '" + left + "' is seen beside '" + right + "'\"></div>";
  }
  return html + "<figcaption><b>" + title + "</b> " + escaped(figure.caption) + "</figcaption></figure>\n";
}

std::string table_html(const PageTable& table) {
  std::string html = "<section><h2>" + escaped(table.title) + "</h2>";
  if (!table.caption.empty()) html += "<p class=\"how\">" + escaped(table.caption) + "</p>";
  html += table.head.empty() ? "<div class=\"scroll\"><table class=\"facts\">" : "<div class=\"scroll\"><table>";
  if (!table.head.empty()) {
    html += "<thead><tr>";
    for (const std::string& cell : table.head) html += "<th scope=\"col\">" + escaped(cell) + "</th>";
    html += "</tr></thead>";
  }
  html += "<tbody>";
  for (const auto& row : table.rows) {
    html += "<tr>";
    for (const std::string& cell : row) html += "<td>" + escaped(cell) + "</td>";
    html += "</tr>";
  }
  return html + "</tbody></table></div></section>\n";
}

PageTable stage_table(const Summary& summary) {
  PageTable table;
  table.title = "Milliseconds a frame";
  table.head = {"", "mean", "median"};
  const Distribution& all = summary.elapsed;
  for (const auto& [name, value] :
       {std::pair{"95 %", all.p95}, std::pair{"99 %", all.p99}, std::pair{"99.9 %", all.p999}})
    if (value) table.head.emplace_back(name);
  table.head.emplace_back("longest");
  const auto add = [&](const std::string& name, const Distribution& d) {
    std::vector<std::string> row = {name};
    for (const std::optional<double>& value :
         {std::optional(d.mean), std::optional(d.p50), d.p95, d.p99, d.p999, std::optional(d.max)}) {
      if (!value) continue;
      char cell[32];
      std::snprintf(cell, sizeof cell, "%.3f", *value);
      row.emplace_back(cell);
    }
    table.rows.push_back(std::move(row));
  };
  add("by the scene's clock", summary.elapsed);
  for (int stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage)
    if (summary.stages[stage].max > 0.0) add(std::string("· ") + stage_name(stage), summary.stages[stage]);
  add("wall time", summary.wall);
  add("CPU time of the calling thread", summary.cpu);
  return table;
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

std::vector<std::vector<std::string>> machine_facts() {
  std::vector<std::vector<std::string>> facts;
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos) {
      facts.push_back({"processor", line.substr(line.find(": ") + 2)});
      break;
    }
  facts.push_back({"hardware threads", std::to_string(std::thread::hardware_concurrency())});
#if defined(__clang__)
  facts.push_back({"compiler", "clang " __clang_version__});
#elif defined(__GNUC__)
  facts.push_back({"compiler", "g++ " __VERSION__});
#endif
  return facts;
}

std::string report_page(const RunReport& report, const PageContent& content) {
  std::string pictures, tables = table_html(stage_table(summarise(report.frames)));
  for (const PageFigure& figure : content.figures) pictures += figure_html(figure);
  if (!pictures.empty())
    pictures =
        "<section><h2>Pictures</h2><p class=\"how\">Drag over a pair, or focus it and use the arrow keys, to "
        "compare.</p><div class=\"pictures\">\n" +
        pictures + "</div></section>";
  for (const PageTable& table : content.tables) tables += table_html(table);

  const std::pair<std::string_view, std::string> parts[] = {
      {"TITLE", escaped(content.title.empty() ? report.scene : content.title)},
      {"LEAD", escaped(report_headline(report))},
      {"PICTURES", pictures},
      {"TABLES", tables},
      {"DATA", report_page_data(report, content)}};
  std::string page;
  for (std::string_view rest = k_report_page_template; !rest.empty();) {
    const size_t at = rest.find('@');
    page += rest.substr(0, at);
    if (at == std::string_view::npos) break;
    rest.remove_prefix(at + 1);
    const auto part = std::find_if(std::begin(parts), std::end(parts), [&](const auto& p) {
      return rest.substr(0, p.first.size()) == p.first && rest.substr(p.first.size(), 1) == "@";
    });
    if (part == std::end(parts)) {
      page += '@';  // it belongs to a rule of the style sheet
      continue;
    }
    page += part->second;
    rest.remove_prefix(part->first.size() + 1);
  }
  return page;
}

}  // namespace sandglass::host
