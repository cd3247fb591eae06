#pragma once
#define GL_TEXTURE_EXTERNAL_OES 0x8D65
