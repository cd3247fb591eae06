#pragma once
#ifdef __cplusplus
extern "C" {
#endif
void ATrace_beginSection(const char* name);  // API 23
void ATrace_endSection(void);
#ifdef __cplusplus
}
#endif
