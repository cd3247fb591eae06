#include "models/lighting/panorama_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "models/host/atomic_file.h"
#include "models/host/failure.h"

#ifdef SANDGLASS_HAVE_OPENEXR
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#endif

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_ONLY_HDR
#define STBI_MAX_DIMENSIONS 16384
// Not STBI_WRITE_NO_STDIO: stb_image_write 1.16 loses the .hdr writer with it.
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#include <stb_image.h>
#include <stb_image_write.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace sandglass::host {

namespace {

constexpr int k_widest = 16384, k_narrowest = 8;  // pixels

std::string extension_of(const std::string& path) {
  const size_t dot = path.find_last_of('.');
  std::string extension = dot == std::string::npos ? "" : path.substr(dot);
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

RadianceMap decode_hdr(const std::string& path, const std::string& bytes) {
  int width = 0, height = 0, channels = 0;
  const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
  const int size = static_cast<int>(std::min<size_t>(bytes.size(), INT32_MAX));
  if (stbi_is_hdr_from_memory(data, size) == 0)
    throw Failure("panorama '" + path + "' is not a Radiance .hdr file; export it as one");
  const std::unique_ptr<float, void (*)(void*)> pixels(
      stbi_loadf_from_memory(data, size, &width, &height, &channels, 3), stbi_image_free);
  if (pixels == nullptr)
    throw Failure("panorama '" + path + "' cannot be decoded (" + stbi_failure_reason() + "); export it again");
  RadianceMap map(width, height);
  std::copy_n(pixels.get(), map.rgb.size(), map.rgb.data());
  return map;
}

#ifdef SANDGLASS_HAVE_OPENEXR
RadianceMap decode_exr(const std::string& path) {
  try {
    Imf::InputFile file(path.c_str());
    const Imath::Box2i window = file.header().dataWindow();
    const int64_t width = int64_t{window.max.x} - window.min.x + 1, height = int64_t{window.max.y} - window.min.y + 1;
    if (width > k_widest || height > k_widest)
      throw Failure("panorama '" + path + "' is wider than " + std::to_string(k_widest) + " pixels; scale it down");
    for (const char* channel : {"R", "G", "B"})
      if (file.header().channels().findChannel(channel) == nullptr)
        throw Failure("panorama '" + path + "' has no channel " + channel + "; export it with R, G and B");
    RadianceMap map(static_cast<int>(width), static_cast<int>(height));
    Imf::FrameBuffer buffer;
    const char* names[] = {"R", "G", "B"};
    for (size_t k = 0; k < 3; ++k)
      buffer.insert(names[k], Imf::Slice::Make(Imf::FLOAT, map.rgb.data() + k, window, 3 * sizeof(float),
                                               3 * sizeof(float) * static_cast<size_t>(width)));
    file.setFrameBuffer(buffer);
    file.readPixels(window.min.y, window.max.y);
    return map;
  } catch (const Failure&) {
    throw;
  } catch (const std::exception&) {
    throw Failure("panorama '" + path + "' cannot be read as OpenEXR: it is missing or damaged; export it again");
  }
}
#else
RadianceMap decode_exr(const std::string& path) {
  throw Failure("panorama '" + path + "' is OpenEXR, which this build does not read; convert it to .hdr");
}
#endif

void append_bytes(void* context, void* data, int size) {
  auto* bytes = static_cast<std::vector<uint8_t>*>(context);
  const auto* begin = static_cast<const uint8_t*>(data);
  bytes->insert(bytes->end(), begin, begin + size);
}

std::vector<uint8_t> encode_hdr(const RadianceMap& map) {
  std::vector<uint8_t> bytes;
  if (stbi_write_hdr_to_func(append_bytes, &bytes, map.width, map.height, 3, map.rgb.data()) == 0)
    throw Failure("a picture of " + std::to_string(map.width) + " x " + std::to_string(map.height) +
                  " pixels cannot be written as .hdr; it needs at least one");
  return bytes;
}

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
  const std::string extension = extension_of(path);
  if (extension == ".hdr") map = decode_hdr(path, read_file(path, "panorama"));
  else if (extension == ".exr") map = decode_exr(path);
  else throw Failure("panorama '" + path + "' is neither .hdr nor .exr; convert it to one of them");
  if (map.width < k_narrowest || map.width != 2 * map.height)
    throw Failure("panorama '" + path + "' is " + std::to_string(map.width) + " x " + std::to_string(map.height) +
                  " pixels; an equirectangular panorama is twice as wide as high");
  for (float& value : map.rgb) {
    if (!std::isfinite(value))
      throw Failure("panorama '" + path + "' has a pixel that is not a finite number; repair or export it again");
    value = std::max(value, 0.0f);  // filters that sharpen leave radiance a little below 0 beside lamps
  }
  if (greatest_luminance(map) <= 0.0) throw Failure("panorama '" + path + "' is black everywhere; expose it");
  return map;
}

void write_hdr(const std::string& path, const RadianceMap& map) { write_file(path, encode_hdr(map)); }

}  // namespace sandglass::host
