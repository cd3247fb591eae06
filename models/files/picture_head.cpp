// Every length in the file may lie, so each access is checked.
#include "models/files/picture_head.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace sandglass::host {

namespace {

struct Bytes {
  std::string_view of;
  bool little = false;  // a TIFF block says which end comes first

  bool has(size_t at, size_t count) const { return at <= of.size() && count <= of.size() - at; }
  uint32_t number(size_t at, size_t count) const {
    if (!has(at, count)) return 0;
    uint32_t value = 0;
    for (size_t i = 0; i < count; ++i)
      value = value << 8 | static_cast<uint8_t>(of[little ? at + count - 1 - i : at + i]);
    return value;
  }
};

// The orientation in a TIFF block: a byte order, the place of a table, and the table's entries of twelve bytes.
int orientation_of(std::string_view tiff) {
  constexpr uint32_t k_orientation = 0x0112, k_short = 3;
  if (!tiff.starts_with("II") && !tiff.starts_with("MM")) return 1;
  const Bytes b = {tiff, tiff[0] == 'I'};
  const size_t table = b.number(4, 4);
  const uint32_t entries = b.number(table, 2);
  for (size_t i = 0; i < entries && b.has(table + 2 + 12 * i, 12); ++i) {
    const size_t at = table + 2 + 12 * i;
    if (b.number(at, 2) != k_orientation || b.number(at + 2, 2) != k_short) continue;
    const uint32_t value = b.number(at + 8, 2);
    return value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
  }
  return 1;
}

void read_png(std::string_view file, PictureHead* head) {
  constexpr size_t k_first_chunk = 8;
  const Bytes b = {file};
  for (size_t at = k_first_chunk; b.has(at, 8);) {
    const uint32_t length = b.number(at, 4);
    const std::string_view kind = file.substr(at + 4, 4);
    if (!b.has(at + 8, length) || kind == "IEND") return;
    if (kind == "IHDR") {
      head->width = b.number(at + 8, 4);
      head->height = b.number(at + 12, 4);
      head->bits = b.number(at + 16, 1);
    }
    if (kind == "PLTE" && length > 0 && length % 3 == 0) {
      head->palette = at + 8;
      head->colours = length / 3;
    }
    const std::string_view content = file.substr(at + 8, length);
    if (kind == "eXIf") head->orientation = orientation_of(content);
    if (kind == "cICP") head->cicp = content;
    if (kind == "iCCP") head->icc = content;
    if (kind == "gAMA") head->gamma = content;
    if (kind == "cHRM") head->chromaticities = content;
    if (kind == "sRGB") head->says_srgb = true;
    at += 12 + size_t{length};
  }
}

// The segments of a JPEG that its decoder depends on, in their order.
struct Jpeg {
  PictureHead* head;
  // Which tables of codes there are: bits 0 to 3 for first coefficients, 4 to 7 for all others.
  uint32_t tables = 0;
  bool progressive = false, framed = false, scanned = false;

  void damaged(const char* what) {
    if (head->damage == nullptr) head->damage = what;
  }
};

// Tables, each of a byte, the numbers of codes of 1 to 16 bits, and the codes. A table that begins within the segment may
// end behind it: stb reads on, and reads 0 behind the end of the file.
void read_tables(std::string_view file, size_t segment, Jpeg* jpeg) {
  constexpr size_t k_lengths = 16, k_codes_max = 256;
  const Bytes b = {file};
  for (size_t at = 0; at < segment;) {
    size_t codes = 0;
    for (size_t i = 1; i <= k_lengths; ++i) codes += b.number(at + i, 1);
    if (codes > k_codes_max) return jpeg->damaged("a table of codes is too long");
    const uint32_t name = b.number(at, 1);  // its class and its number
    if (name >> 4 <= 1 && (name & 15) <= 3) jpeg->tables |= 1u << ((name >> 4) * 4 + (name & 3));
    at += 1 + k_lengths + codes;
  }
}

// The count of colours, for each its name and its tables, and which coefficients and bits the scan brings.
void read_scan(std::string_view content, Jpeg* jpeg) {
  const Bytes b = {content};
  const uint32_t colours = b.number(0, 1), first = b.number(1 + 2 * colours, 1), bits = b.number(3 + 2 * colours, 1);
  jpeg->scanned = true;
  const bool names_first = !jpeg->progressive || (first == 0 && bits >> 4 == 0);
  const bool names_others = !jpeg->progressive || first != 0;
  for (uint32_t i = 0; i < colours && b.has(2 + 2 * i, 1); ++i) {
    const uint32_t named = b.number(2 + 2 * i, 1);
    const uint32_t wanted = (names_first ? 1u << (named >> 4 & 3) : 0) | (names_others ? 16u << (named & 3) : 0);
    if ((wanted & ~jpeg->tables) != 0) jpeg->damaged("a table of codes is missing");
  }
}

// `file` begins with the segment's content.
void read_segment(uint32_t marker, std::string_view file, size_t size, Jpeg* jpeg) {
  constexpr uint32_t k_exif = 0xE1, k_first_frame = 0xC0, k_last_frame = 0xCF, k_progressive = 0xC2, k_tables = 0xC4,
                     k_scan = 0xDA;
  constexpr uint32_t k_profile = 0xE2;
  constexpr std::string_view k_exif_name("Exif\0\0", 6), k_profile_name("ICC_PROFILE\0", 12);
  const std::string_view content = file.substr(0, size);
  PictureHead* head = jpeg->head;
  if (marker == k_exif && content.starts_with(k_exif_name))
    head->orientation = orientation_of(content.substr(k_exif_name.size()));
  if (marker == k_profile && content.starts_with(k_profile_name) && head->icc.empty())
    head->icc = content.substr(std::min(k_profile_name.size() + 2, content.size()));  // two bytes say which part it is
  if (marker == k_tables) read_tables(file, size, jpeg);
  if (marker == k_scan) read_scan(content, jpeg);
  // All markers in the range begin a frame but three: tables, a reserved one, and arithmetic conditioning.
  if (marker < k_first_frame || marker > k_last_frame || marker == k_tables || marker == 0xC8 || marker == 0xCC) return;
  if (jpeg->framed) return;  // stb decodes the first one
  jpeg->framed = true;
  const Bytes frame = {content};
  head->bits = frame.number(0, 1);
  head->height = frame.number(1, 2);
  head->width = frame.number(3, 2);
  head->components = frame.number(5, 1);
  jpeg->progressive = marker == k_progressive;
}

// Up to the picture's end, since a table may come between two scans; behind it phones keep films and second pictures. As
// stb does, it looks for the next marker behind whatever is no segment: a scan's data, or damage.
void read_jpeg(std::string_view file, PictureHead* head) {
  constexpr uint32_t k_end = 0xD9;
  const Bytes b = {file};
  Jpeg jpeg = {head};
  for (size_t at = 2; b.has(at, 2);) {
    const uint32_t marker = b.number(at + 1, 1);
    const bool begins_segment = b.number(at, 1) == 0xFF && marker >= 0xC0 && marker < 0xFF;
    const bool is_bare = marker >= 0xD0 && marker <= k_end;  // restarts, begin and end have no content
    if (begins_segment && marker == k_end) break;
    if (!begins_segment || is_bare) {
      ++at;
      continue;
    }
    const size_t length = b.number(at + 2, 2);
    if (b.has(at, 4)) read_segment(marker, file.substr(at + 4), length < 2 ? 0 : length - 2, &jpeg);
    at += 2 + (length < 2 ? 2 : length);
  }
  if (!jpeg.scanned) jpeg.damaged("it has no pixels");
}

}  // namespace

PictureHead picture_head(std::string_view bytes) {
  struct Known {
    size_t at;
    std::string_view magic;
    const char* name;
  };
  constexpr Known k_others[] = {{4, "ftypavif", "AVIF"}, {4, "ftyp", "HEIC"},          {0, "GIF8", "GIF"},
                                {0, "BM", "BMP"},        {8, "WEBP", "WebP"},          {0, "II*", "TIFF"},
                                {0, "MM", "TIFF"},       {0, "#?RADIANCE", "Radiance"}};
  PictureHead head;
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) {
    head.kind = PictureHead::Kind::png;
    read_png(bytes, &head);
  } else if (bytes.starts_with("\xFF\xD8\xFF")) {
    head.kind = PictureHead::Kind::jpeg;
    read_jpeg(bytes, &head);
  } else {
    for (const Known& other : k_others)
      if (bytes.size() > other.at && bytes.substr(other.at).starts_with(other.magic)) {
        head.kind = PictureHead::Kind::other;
        head.name = other.name;
        break;
      }
  }
  return head;
}

}  // namespace sandglass::host
