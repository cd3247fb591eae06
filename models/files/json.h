// JSON to be written. Members keep the order in which they were added.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace sandglass::host {

using Json = nlohmann::ordered_json;

// Bytes that are not UTF-8, as a file's name may have, become U+FFFD; numbers that are not finite become null.
inline std::string text_of(const Json& json) { return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"; }

}  // namespace sandglass::host
