// The one copy of stb_image_write that is compiled. STBI_WRITE_NO_STDIO is not set, because version 1.16 then lacks the
// .hdr writer.
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>
