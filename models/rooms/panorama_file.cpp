#include "models/rooms/panorama_file.h"

#include <stb_image_write.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"

#ifdef SANDGLASS_HAVE_OPENEXR
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#endif

namespace sandglass::host {

namespace {

constexpr int k_widest = 16384, k_narrowest = 8;  // pixels

void check_shape(const std::string& path, int64_t width, int64_t height) {
  if (width >= k_narrowest && width == 2 * height) return;
  throw cannot("read", path,
               "it has " + std::to_string(width) + " x " + std::to_string(height) +
                   " pixels, and a panorama is twice as wide as high",
               "Export it as equirectangular");
}

// Reads Radiance's format. It has lines of text, an empty line, the size, and then rows with four bytes a pixel. The
// four planes of a row are packed in runs (old files do not pack them). stb_image is not used, because its release in
// Debian 12 never returns from a file that was cut off.
struct HdrReader {
  const std::string& path;
  const std::string& bytes;
  size_t at = 0;

  [[noreturn]] void damaged(const std::string& what) const {
    throw cannot("read", path, "it " + what, "Export it again as Radiance .hdr");
  }
  std::string line() {
    const size_t end = bytes.find('\n', at);
    if (end == std::string::npos) damaged("ends within its header");
    std::string text = bytes.substr(at, end - at);
    at = end + 1;
    if (text.ends_with('\r')) text.pop_back();
    return text;
  }
  uint8_t byte() {
    if (at >= bytes.size()) damaged("is cut off");
    return static_cast<uint8_t>(bytes[at++]);
  }
  void packed_column(std::vector<uint8_t>* row, int channel, int width) {
    for (int u = 0; u < width;) {
      const int count = byte(), run = count > 128 ? count - 128 : 0, length = run > 0 ? run : count;
      if (length == 0 || u + length > width) damaged("has a run that does not fit its row");
      uint8_t value = run > 0 ? byte() : uint8_t{0};
      for (int i = 0; i < length; ++i, ++u) {
        if (run == 0) value = byte();
        (*row)[static_cast<size_t>(4 * u + channel)] = value;
      }
    }
  }
  // As files before 1991 have them: 1 1 1 n is no pixel, but n more of the last one; of several in a row, each counts
  // 256 times as much as the one before. The first pixel is in the row already.
  void repeated_pixels(std::vector<uint8_t>* row) {
    uint64_t shift = 0;
    for (size_t at_pixel = 0; at_pixel < row->size();) {
      uint8_t* p = row->data() + at_pixel;
      for (size_t i = 0; at_pixel > 0 && i < 4; ++i) p[i] = byte();
      if (p[0] != 1 || p[1] != 1 || p[2] != 1) {
        shift = 0;
        at_pixel += 4;
        continue;
      }
      const uint64_t count = uint64_t{p[3]} << shift;
      if (at_pixel == 0 || count > (row->size() - at_pixel) / 4) damaged("has a run that does not fit its row");
      for (uint64_t i = 0; i < count; ++i, at_pixel += 4)
        std::memcpy(row->data() + at_pixel, row->data() + at_pixel - 4, 4);
      shift += 8;
    }
  }
  RadianceMap read() {
    if (!line().starts_with("#?")) damaged("is not a Radiance file");
    // What the numbers were multiplied by: the products of these lines.
    double exposure = 1.0;
    Vec3 correction = {1.0, 1.0, 1.0};
    for (std::string text = line(); !text.empty(); text = line()) {
      if (text.starts_with("FORMAT=") && text != "FORMAT=32-bit_rle_rgbe") damaged("is not in RGB");
      if (text.starts_with("EXPOSURE=")) exposure *= std::strtod(text.c_str() + std::strlen("EXPOSURE="), nullptr);
      Vec3 c;
      if (std::sscanf(text.c_str(), "COLORCORR= %lf %lf %lf", &c.x, &c.y, &c.z) == 3)
        correction = {correction.x * c.x, correction.y * c.y, correction.z * c.z};
    }
    if (!(luminance(correction) > 1e-30 && luminance(correction) < 1e30)) damaged("has a COLORCORR that is no colour");
    if (!(exposure > 1e-30 && exposure < 1e30)) damaged("has an EXPOSURE that is no number above 0");
    int width = 0, height = 0;
    char rows = 0, columns = 0;
    const std::string size = line();
    if (std::sscanf(size.c_str(), "%cY %d %cX %d", &rows, &height, &columns, &width) != 4 || width < 1 || height < 1 ||
        width > k_widest || height > k_widest || (rows != '-' && rows != '+') || (columns != '-' && columns != '+'))
      damaged("has an unknown size line (\"" + size.substr(0, 40) + "\")");
    check_shape(path, width, height);
    // Before memory is taken for pixels that the file cannot hold.
    constexpr size_t k_run_bytes_min = 2, k_longest_run = 127;
    const size_t shortest_row =
        std::min<size_t>(4 * k_run_bytes_min * static_cast<size_t>(width) / k_longest_run, 12);  // 1 1 1 n twice
    if (bytes.size() - at < shortest_row * static_cast<size_t>(height)) damaged("is cut off");
    RadianceMap map(width, height);
    std::vector<uint8_t> row(4 * static_cast<size_t>(width));
    for (int v = 0; v < height; ++v) {
      for (size_t i = 0; i < 4; ++i) row[i] = byte();
      if (width >= 8 && width < 32768 && row[0] == 2 && row[1] == 2 && row[2] * 256 + row[3] == width) {
        for (int channel = 0; channel < 4; ++channel) packed_column(&row, channel, width);
      } else {
        repeated_pixels(&row);
      }
      for (int u = 0; u < width; ++u) {
        const uint8_t* p = row.data() + 4 * u;
        const double scale = p[3] > 0 ? std::ldexp(1.0, p[3] - 136) / exposure : 0.0;
        map.set(columns == '+' ? u : width - 1 - u, rows == '-' ? v : height - 1 - v,
                {p[0] * scale / correction.x, p[1] * scale / correction.y, p[2] * scale / correction.z});
      }
    }
    return map;
  }
};

#ifdef SANDGLASS_HAVE_OPENEXR
class MemoryStream : public Imf::IStream {
 public:
  MemoryStream(const std::string& name, const std::string& bytes) : Imf::IStream(name.c_str()), bytes_(bytes) {}
  bool read(char* to, int count) override {
    if (count < 0 || at_ > bytes_.size() || static_cast<size_t>(count) > bytes_.size() - at_)
      throw std::runtime_error("the file ends early");
    std::memcpy(to, bytes_.data() + at_, static_cast<size_t>(count));
    at_ += static_cast<size_t>(count);
    return at_ < bytes_.size();
  }
  uint64_t tellg() override { return at_; }
  void seekg(uint64_t position) override { at_ = position; }

 private:
  const std::string& bytes_;
  uint64_t at_ = 0;
};

RadianceMap decode_exr(const std::string& path, const std::string& bytes) {
  try {
    MemoryStream stream(path, bytes);
    Imf::InputFile file(stream);
    // Stitchers and renderers store a part of the picture, or more than it: what is not stored is black.
    const Imath::Box2i window = file.header().dataWindow(), picture = file.header().displayWindow();
    const auto width_of = [](const Imath::Box2i& box) { return int64_t{box.max.x} - box.min.x + 1; };
    const auto height_of = [](const Imath::Box2i& box) { return int64_t{box.max.y} - box.min.y + 1; };
    if (std::max({width_of(window), height_of(window), width_of(picture), height_of(picture)}) > k_widest)
      throw cannot("read", path, "it is wider than " + std::to_string(k_widest) + " pixels", "Scale it down");
    check_shape(path, width_of(picture), height_of(picture));
    for (const char* channel : {"R", "G", "B"})
      if (file.header().channels().findChannel(channel) == nullptr)
        throw cannot("read", path, std::string("it has no channel ") + channel, "Export it with R, G and B");
    const int width = static_cast<int>(width_of(window)), height = static_cast<int>(height_of(window));
    RadianceMap stored(width, height);
    Imf::FrameBuffer buffer;
    const char* names[] = {"R", "G", "B"};
    for (size_t k = 0; k < 3; ++k)
      buffer.insert(names[k], Imf::Slice::Make(Imf::FLOAT, stored.rgb.data() + k, window, 3 * sizeof(float),
                                               3 * sizeof(float) * static_cast<size_t>(width)));
    file.setFrameBuffer(buffer);
    file.readPixels(window.min.y, window.max.y);
    RadianceMap map(static_cast<int>(width_of(picture)), static_cast<int>(height_of(picture)));
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u) {
        const int x = window.min.x + u - picture.min.x, y = window.min.y + v - picture.min.y;
        if (x >= 0 && y >= 0 && x < map.width && y < map.height) map.set(x, y, stored.colour(u, v));
      }
    return map;
  } catch (const Failure&) {
    throw;
  } catch (const std::exception&) {
    throw cannot("read", path, "it is missing, or no complete OpenEXR file", "Export it again");
  }
}
#else
RadianceMap decode_exr(const std::string& path, const std::string&) {
  throw cannot("read", path, "this build does not read OpenEXR", "Convert it to .hdr");
}
#endif

}  // namespace

bool reads_exr() {
#ifdef SANDGLASS_HAVE_OPENEXR
  return true;
#else
  return false;
#endif
}

RadianceMap read_panorama(const std::string& path) {
  RadianceMap map;
  const std::string bytes = read_file(path, "panorama");
  if (bytes.starts_with("#?")) map = HdrReader{path, bytes}.read();
  else if (bytes.starts_with("\x76\x2f\x31\x01")) map = decode_exr(path, bytes);
  else throw cannot("read", path, "it is neither Radiance .hdr nor OpenEXR", "Convert it to one of them");
  check_shape(path, map.width, map.height);
  for (float& value : map.rgb) {
    if (!std::isfinite(value))
      throw cannot("read", path, "it has a pixel that is not a finite number", "Repair or export it again");
    value = std::max(value, 0.0f);  // sharpening filters can make radiance negative beside lamps
  }
  if (greatest_luminance(map) <= 0.0) throw cannot("read", path, "it is black everywhere", "Expose it");
  return map;
}

void write_hdr(const std::string& path, const RadianceMap& map) {
  std::vector<uint8_t> bytes;
  if (stbi_write_hdr_to_func(append_bytes, &bytes, map.width, map.height, 3, map.rgb.data()) == 0)
    throw cannot("encode", ".hdr", "the picture has no pixel", "Make it larger");
  write_file(path, bytes);
}

// The noise of paths is evened out: each pixel becomes the mean of those around it that show nearly the same.
static Picture evened(const Picture& picture) {
  constexpr int k_reach = 3;
  constexpr double k_alike = 1.0 / (2.0 * 9.0 * 9.0), k_near = 1.0 / (2.0 * 1.6 * 1.6);  // of bytes, of pixels
  Picture out = picture;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const uint8_t* middle = picture.at(x, y);
      double sum[3] = {}, all = 0.0;
      for (int j = -k_reach; j <= k_reach; ++j)
        for (int i = -k_reach; i <= k_reach; ++i) {
          const int v = std::clamp(y + j, 0, picture.height - 1), u = (x + i + picture.width) % picture.width;
          const uint8_t* other = picture.at(u, v);
          double distance = 0.0;
          for (int c = 0; c < 3; ++c) distance += (other[c] - middle[c]) * (other[c] - middle[c]) / 3.0;
          const double weight = std::exp(-distance * k_alike - (i * i + j * j) * k_near);
          all += weight;
          for (int c = 0; c < 3; ++c) sum[c] += weight * other[c];
        }
      for (int c = 0; c < 3; ++c) out.at(x, y)[c] = static_cast<uint8_t>(std::lround(sum[c] / all));
    }
  return out;
}

void write_kept_room(const std::string& path, const RadianceMap& map) {
  constexpr int k_quality = 92;
  write_file(path, jpeg_file(evened(tone_mapped_picture(map, k_kept_white)), k_quality));
}

RadianceMap read_kept_room(const std::string& path) {
  const Picture picture = read_picture(path);
  RadianceMap map(picture.width, picture.height);
  for (int v = 0; v < map.height; ++v)
    for (int u = 0; u < map.width; ++u) {
      const uint8_t* pixel = picture.at(u, v);
      map.set(u, v, radiance_of({linear_of(pixel[0]), linear_of(pixel[1]), linear_of(pixel[2])}, k_kept_white));
    }
  return map;
}

}  // namespace sandglass::host
