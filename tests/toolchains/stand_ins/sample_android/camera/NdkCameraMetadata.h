#pragma once
// What the sample reads of an image's metadata. The numbers of the tags are not those of Android.
#include <stdint.h>
typedef struct ACameraMetadata ACameraMetadata;
typedef enum { ACAMERA_OK = 0 } camera_status_t;
enum { ACAMERA_SENSOR_EXPOSURE_TIME, ACAMERA_SENSOR_SENSITIVITY, ACAMERA_CONTROL_POST_RAW_SENSITIVITY_BOOST };
typedef struct ACameraMetadata_const_entry {
  uint32_t tag;
  uint8_t type;
  uint32_t count;
  union {
    const uint8_t* u8;
    const int32_t* i32;
    const float* f;
    const int64_t* i64;
    const double* d;
  } data;
} ACameraMetadata_const_entry;
extern "C" camera_status_t ACameraMetadata_getConstEntry(const ACameraMetadata* metadata, uint32_t tag,
                                                         ACameraMetadata_const_entry* entry);
