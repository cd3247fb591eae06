#pragma once
#ifdef __cplusplus
extern "C"
#endif
    unsigned long
    getauxval(unsigned long type);
