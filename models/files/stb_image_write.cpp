// The one copy of stb_image_write that is compiled. Not STBI_WRITE_NO_STDIO: version 1.16 loses the .hdr writer with
// it.
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>
